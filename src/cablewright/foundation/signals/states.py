"""True and estimated state of a machine, and the progress of its print."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.quick_values import quickly_filled
from cablewright.foundation.signals.reading import PerLine


@quickly_filled
@dataclass(frozen=True, eq=False)
class Truth:
    """The true state of a simulated machine: logged, but never part of a frame.

    In the dynamic plant, tensions and the taut lengths of `excess` are those half a substep before `time`.
    """

    time: float  # s
    position: Array  # (3,) m, world: of B, the origin of a rigid platform's frame
    velocity: Array  # (3,) m/s, world
    rotation: Array  # (3,) rad: rotation vector of the drum or body
    rate: Array  # (3,) rad/s, world
    lengths: Annotated[Array, PerLine("m")]  # (m,) unstrained, winch exit to platform point
    tensions: Annotated[Array, PerLine("N")]  # (m,) at the sheaves
    excess: Annotated[Array, PerLine("m")]  # (m,) over the taut length; positive is slack
    radii: Annotated[Array, PerLine("m")]  # (m,) of the winch drums, where cable leaves; 0 of a line without a winch
    powder: float  # kg: left in the drum
    retraction: float = float("nan")  # m: length of a platform that retracts; NaN: of any other


@dataclass(frozen=True)
class Fault:
    """A fault that an estimator reports: its source, its start time (s), and one sentence."""

    source: str
    since: float
    sentence: str


@quickly_filled
@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimated state of the machine, and its covariance."""

    time: float  # s
    position: Array  # (3,) m, world: of B
    velocity: Array  # (3,) m/s, world
    rotation: Array  # (3,) rad: rotation vector of the drum
    lengths: Annotated[Array, PerLine("m")]  # (m,) unstrained, winch exit to B
    excess: Annotated[Array, PerLine("m")]  # (m,) over the taut length; positive is slack
    slack: Annotated[Mask, PerLine()]  # (m,)
    radii: Annotated[Array, PerLine("m")]  # (m,) of the winch drums, at the cable
    covariance: Array | None = None  # (9, 9) of position, velocity, rotation, world; None: unknown
    faults: tuple[Fault, ...] = field(default=())
    valid: bool = True  # False: the position is uncertain; do not control by it
    clearance: float = float("nan")  # m, mean height of B over the surface below (fictive height); NaN: unknown
    consistency: Mapping[str, float] = field(default_factory=dict)
    """By sensor, mean of its last normalised innovations squared over their degrees of freedom: about 1."""

    @property
    def yaw(self) -> float:
        """Rotation of the platform about the vertical, rad, for small tilts."""
        return float(self.rotation[2])


class PrintState(StrEnum):
    """State of a print, and of the machine before and between prints."""

    OFF = "off"
    TENSIONING = "tensioning"
    HOMING = "homing"
    MANUAL = "manual"
    IDLE = "idle"
    READY = "ready"
    PRINTING = "printing"
    PAUSED = "paused"
    REFILLING = "refilling"
    STOPPED = "stopped"
    FAULT = "fault"


@quickly_filled
@dataclass(frozen=True, eq=False)
class Progress:
    """Progress of a print, once in each control step."""

    time: float  # s
    state: PrintState
    layer: int  # from 1 on; 0 before the first
    distance: float  # m along the path, all layers
    target: Array  # (3,) m, world, of B
    error: float  # m, estimated cross-track error in plan view; positive: left of the path; NaN: off the path
    reason: str = ""  # for not printing
    tensions: Array | None = None  # (m,) N at the sheaves, at which the lines are to be; None: none are chosen
