"""The plain messages between machine, estimation, control, log and viewer: readings, commands, estimates.

Frozen values; arrays in them are read-only. SI units. Frames: **world** as the robot file's; **drum**: origin in B,
where the lines meet, axes along the world's where it hangs straight and unturned, z up its axis; **lidar**: the scan's
plane is its x-y plane. Times are seconds since the machine began, on its own clock. NaN is a number that was not
measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "SOURCES",
    "Barrier",
    "Climate",
    "Command",
    "Condition",
    "DistanceReading",
    "Encoders",
    "Estimate",
    "Fault",
    "Inertial",
    "LineAngles",
    "Notice",
    "PrintState",
    "Progress",
    "Reading",
    "Scan",
    "SensorFrame",
    "Truth",
    "frozen",
]

Array = NDArray[np.float64]
_Kind = TypeVar("_Kind")

SOURCES = ("north", "south", "vertical", "inertial", "line_angles", "distance", "encoders", "climate", "barrier")
"""Names of the sensors; the first three are lidars."""


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy, floats."""
    made = np.array(values, dtype=np.float64)
    made.flags.writeable = False
    return made


class Condition(StrEnum):
    """What a machine has to say about a step besides its readings."""

    STALLED = "a motor cannot pull its load"
    LIMITED = "a winch was asked for more speed than its motor has"
    DRUM_END = "a winch drum is empty or full"
    POWDER_OUT = "the valve is open but no powder is left"
    SILENT = "nothing came over the wireless link for longer than it should"
    NO_EQUILIBRIUM = "the plant found no equilibrium and stayed where it was"
    CLOCK_BACK = "the clock jumped back; what was told meanwhile is left out"


@dataclass(frozen=True)
class Notice:
    """One condition, and whose it is: a line's name, a source, or none."""

    condition: Condition
    subject: str = ""


@dataclass(frozen=True, eq=False)
class Encoders:
    """Counts of the incremental encoders on the motors; more counts is more cable paid out."""

    time: float  # s, when read
    counts: NDArray[np.int64]  # (m,) since the machine began


@dataclass(frozen=True, eq=False)
class Inertial:
    """Accelerometer and gyro on the drum."""

    time: float  # s
    acceleration: Array  # (3,) m/s^2, drum: specific force, +g along z where it hangs still
    rate: Array  # (3,) rad/s, drum


@dataclass(frozen=True, eq=False)
class LineAngles:
    """Accelerometers on the lines: the tangent's angle above the horizontal, seen from the sheave.

    Negative on a line that falls to the platform; as `cablewright.solvers.slack.tangent_angle`.
    """

    time: float  # s
    angles: Array  # (m,) rad; NaN: no reading of this line


@dataclass(frozen=True, eq=False)
class DistanceReading:
    """The distance sensor under the valve."""

    time: float  # s
    distance: float  # m, along the drum's axis to the ground or what lies on it; NaN: nothing came back


@dataclass(frozen=True, eq=False)
class Climate:
    """The room."""

    time: float  # s
    temperature: float  # degrees Celsius
    humidity: float  # relative, 0 to 1


@dataclass(frozen=True, eq=False)
class Barrier:
    """The light barrier round the machine's place."""

    time: float  # s
    broken: bool  # somebody is in the way of the light


@dataclass(frozen=True, eq=False)
class Scan:
    """One turn of a planar lidar. Ray k was measured at `times[k]`, at angle `angles[k]`."""

    source: str  # which lidar
    begin: float  # s, when the first ray was measured
    period: float  # s between rays
    first_angle: float  # rad, lidar: of the first ray, from x towards y
    angle_step: float  # rad between rays
    ranges: Array  # (k,) m; NaN: nothing in range came back, or the ray is masked by the drum

    @property
    def time(self) -> float:
        """When the last ray was measured, s."""
        return self.begin + self.period * (len(self.ranges) - 1)

    @property
    def times(self) -> Array:
        """When each ray was measured, (k,) s."""
        return np.asarray(self.begin + self.period * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def angles(self) -> Array:
        """Direction of each ray, (k,) rad, lidar."""
        return np.asarray(self.first_angle + self.angle_step * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def points(self) -> Array:
        """What each ray met, (k, 2) m, lidar; NaN where nothing."""
        angles = self.angles
        return np.asarray(self.ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


Reading = Encoders | Inertial | LineAngles | DistanceReading | Climate | Barrier | Scan


@dataclass(frozen=True, eq=False)
class SensorFrame:
    """All readings that arrived since the frame before, in the order in which they arrived.

    A reading's own time is when it was measured; it may be earlier than the frame before. Missing readings are simply
    not there: a sensor that is quiet, a lost message, a gap of the wireless link.
    """

    time: float  # s, now
    readings: tuple[Reading, ...] = ()
    notices: tuple[Notice, ...] = ()

    def of(self, kind: type[_Kind]) -> tuple[_Kind, ...]:
        """Return the readings of one kind: ``frame.of(Scan)``."""
        return tuple(reading for reading in self.readings if isinstance(reading, kind))


@dataclass(frozen=True, eq=False)
class Command:
    """What the machine shall do from now on."""

    time: float  # s, when it was made
    winch_speeds: Array  # (m,) rad/s of the winch drums, not the motors; positive pays cable out
    valve: float = 0.0  # opening of the powder's valve, 0 to 1


@dataclass(frozen=True, eq=False)
class Truth:
    """What only a simulation knows. It is logged, but no frame has it.

    Of the dynamic plant, tensions and the taut lengths behind `excess` are those of half a substep before `time`.
    """

    time: float  # s
    position: Array  # (3,) m, world: of B
    velocity: Array  # (3,) m/s, world
    rotation: Array  # (3,) rad: rotation vector of the drum
    rate: Array  # (3,) rad/s, world
    lengths: Array  # (m,) m: unstrained, winch exit to B
    tensions: Array  # (m,) N: at the sheaves
    excess: Array  # (m,) m: of each line over its taut length; positive is slack
    radii: Array  # (m,) m: at which cable leaves each winch drum
    powder: float  # kg: left in the drum


@dataclass(frozen=True)
class Fault:
    """Something an estimator noticed: which source, since when (s), and one sentence."""

    source: str
    since: float
    sentence: str


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is believed of the machine's state, and how surely."""

    time: float  # s
    position: Array  # (3,) m, world: of B
    velocity: Array  # (3,) m/s, world
    rotation: Array  # (3,) rad: rotation vector of the drum
    lengths: Array  # (m,) m: unstrained, winch exit to B
    excess: Array  # (m,) m: over the taut length; positive is slack
    slack: NDArray[np.bool_]  # (m,)
    radii: Array  # (m,) m: of the winch drums, where cable leaves
    covariance: Array | None = None  # (9, 9) of position, velocity, rotation in space; None: not known
    faults: tuple[Fault, ...] = field(default=())
    valid: bool = True  # False: position is a guess, do not control by it
    clearance: float = float("nan")  # m of B over what lies below, on average: the fictive height; NaN: not known

    @property
    def yaw(self) -> float:
        """Turn of the drum about the vertical, rad, where it is tilted by little."""
        return float(self.rotation[2])


class PrintState(StrEnum):
    """What a print is doing."""

    IDLE = "idle"
    READY = "ready"
    PRINTING = "printing"
    PAUSED = "paused"
    REFILLING = "refilling"
    STOPPED = "stopped"
    FAULT = "fault"


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a print has come, once in each step of control."""

    time: float  # s
    state: PrintState
    layer: int  # from 0 on
    distance: float  # m along the path from its beginning, all layers
    target: Array  # (3,) m, world: where B should be
    error: (
        float  # m: cross-track, seen from above, by the estimate; positive is left of the path; NaN: not following it
    )
    reason: str = ""  # why it is not printing
