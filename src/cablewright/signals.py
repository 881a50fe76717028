"""The messages between machine, estimation, control, log and viewer: readings, commands, estimates.

Frozen values with read-only arrays, in SI units. Frames: **world**: the robot file's; **drum**: origin at B, where the
lines meet, z up along its axis, parallel to the world's axes without tilt and yaw; of a rigid platform its own frame,
whose origin is then B; **lidar**: its x-y plane is the scan's. Times are seconds since the machine's start, by its own
clock. NaN: not measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType
from typing import Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.arrays import Array, Mask

_Kind = TypeVar("_Kind")

SOURCES = (
    "north", "south", "vertical", "inertial", "line_angles", "distance", "encoders", "climate", "barrier",
    "load_cells", "motor_torques", "drives", "inputs", "retraction", "swivels",
)  # fmt: skip
"""Names of the sensors; the first three are lidars."""


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy as floats."""
    copy = np.array(values, dtype=np.float64)
    copy.flags.writeable = False
    return copy


class Condition(StrEnum):
    """Conditions that a machine reports with a step's readings."""

    STALLED = "a motor cannot pull its load"
    LIMITED = "a winch was asked for more speed than its motor has"
    DRUM_END = "a winch drum is empty or full"
    POWDER_OUT = "the valve is open but no powder is left"
    SILENT = "nothing came over the wireless link for longer than it should"
    NO_EQUILIBRIUM = "the plant found no equilibrium and stayed where it was"
    BRANCH_END = "the equilibrium that the plant followed ended, and it went to another one nearby"
    UNCERTIFIED = "the equilibrium that the plant followed could not be certified"
    CLOCK_BACK = "the clock jumped back; what was told meanwhile is left out"
    OVERRUN = "a step came later than it was due"
    HUNG = "the control hung"
    DRIVE_FAULT = "a winch's drive reports a fault"
    BUS_SILENT = "a winch's drive does not answer"
    ESTOP = "the emergency-stop chain is open"
    BRAKE = "a brake is not as it was commanded"
    NOT_SAVED = "counts of the winches could not be saved: after a loss of power it is to be homed"


@dataclass(frozen=True)
class Notice:
    """One condition, and its subject: a line's name, a source, or none."""

    condition: Condition
    subject: str = ""


@dataclass(frozen=True, eq=False)
class Encoders:
    """Counts of the motors' incremental encoders; paying cable out is positive."""

    time: float  # s
    counts: NDArray[np.int64]  # (m,) since the machine's start


@dataclass(frozen=True, eq=False)
class Inertial:
    """Reading of the inertial measurement unit (IMU) on the drum."""

    time: float  # s
    acceleration: Array  # (3,) m/s^2, drum: specific force, +g along z at rest
    rate: Array  # (3,) rad/s, drum


@dataclass(frozen=True, eq=False)
class LineAngles:
    """Accelerometers on the lines: angle of the tangent above the horizontal, in the direction away from the sheave.

    Negative on a line that descends to the platform; as `cablewright.solvers.slack.tangent_angle`.
    """

    time: float  # s
    angles: Array  # (m,) rad; NaN: not measured


@dataclass(frozen=True, eq=False)
class Distance:
    """Reading of the distance sensor under the valve."""

    time: float  # s
    distance: float  # m, along the drum's axis to the ground or material; NaN: no echo


@dataclass(frozen=True, eq=False)
class Climate:
    """Reading of the climate sensor."""

    time: float  # s
    temperature: float  # degrees Celsius
    humidity: float  # relative, 0 to 1


@dataclass(frozen=True, eq=False)
class Barrier:
    """Reading of the light barrier around the machine."""

    time: float  # s
    broken: bool  # somebody interrupts the light


@dataclass(frozen=True, eq=False)
class Scan:
    """One revolution of a planar lidar. Ray k was measured at `times[k]`, at angle `angles[k]`."""

    source: str  # name of the lidar
    begin: float  # s, time of the first ray
    period: float  # s between rays
    first_angle: float  # rad, lidar: of the first ray, from x towards y
    angle_step: float  # rad between rays
    ranges: Array  # (k,) m; NaN: no echo in range, or masked by the drum

    @property
    def time(self) -> float:
        """Time of the last ray, s."""
        return self.begin + self.period * (len(self.ranges) - 1)

    @property
    def times(self) -> Array:
        """Time of each ray, (k,) s."""
        return np.asarray(self.begin + self.period * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def angles(self) -> Array:
        """Direction of each ray, (k,) rad, lidar."""
        return np.asarray(self.first_angle + self.angle_step * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def points(self) -> Array:
        """Point hit by each ray, (k, 2) m, lidar; NaN without an echo."""
        angles = self.angles
        return np.asarray(self.ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


@dataclass(frozen=True, eq=False)
class Tensions:
    """Measured tensions of the lines, from ``load_cells`` or from ``motor_torques``."""

    source: str
    time: float  # s
    tensions: Array  # (m,) N, at the sheaves; NaN: not measured


@dataclass(frozen=True, eq=False)
class BeamLength:
    """Measured length of a platform that retracts."""

    time: float  # s
    length: float  # m


@dataclass(frozen=True, eq=False)
class Swivels:
    """Angles of the swivelling sheaves: of each line's vertical plane in plan view, from x towards y."""

    time: float  # s
    angles: Array  # (m,) rad, -pi to pi; NaN: not measured


class DriveState(StrEnum):
    """State of a winch's drive."""

    OFF = "off"
    READY = "ready"
    ENABLED = "enabled"
    FAULT = "fault"


@dataclass(frozen=True, eq=False)
class Drives:
    """What the winches' drives report. Angles are of the winch drums; paying cable out is positive."""

    time: float  # s
    states: tuple[DriveState, ...]  # (m,)
    positions: Array  # (m,) rad; NaN: not measured, as in the others
    velocities: Array  # (m,) rad/s
    torques: Array  # (m,) N m
    following_errors: Array  # (m,) rad, commanded less measured
    faults: tuple[str, ...]  # (m,) text of each drive's fault; empty: none


@dataclass(frozen=True, eq=False)
class Inputs:
    """Inputs of the machine that concern its safety. The chain itself stops the machine; this only shows it."""

    time: float  # s
    chain_closed: bool  # the emergency-stop chain
    torque_off: bool  # safe torque off is active
    enabling: bool  # an enabling switch is pressed; true where there is none
    brakes_closed: tuple[bool, ...]  # (m,) as the brakes' own contacts say; none without such contacts


Reading = (
    Encoders
    | Inertial
    | LineAngles
    | Distance
    | Climate
    | Barrier
    | Scan
    | Tensions
    | Drives
    | Inputs
    | BeamLength
    | Swivels
)


_SOURCES: Final[Mapping[type, str]] = MappingProxyType({
    Barrier: "barrier",
    BeamLength: "retraction",
    Climate: "climate",
    Distance: "distance",
    Drives: "drives",
    Encoders: "encoders",
    Inertial: "inertial",
    Inputs: "inputs",
    LineAngles: "line_angles",
    Swivels: "swivels",
})  # fmt: skip


def source_of(reading: Reading) -> str:
    """Return the name of the sensor, one of `SOURCES`, that a reading comes from."""
    return reading.source if isinstance(reading, Scan | Tensions) else _SOURCES[type(reading)]


@dataclass(frozen=True, eq=False)
class SensorFrame:
    """All readings that arrived since the last frame, in the order of arrival.

    A reading's own time is that of its measurement, possibly before the last frame. Readings may be missing: a silent
    sensor, a lost message, a gap of the wireless link.
    """

    time: float  # s
    readings: tuple[Reading, ...] = ()
    notices: tuple[Notice, ...] = ()

    def of(self, kind: type[_Kind]) -> tuple[_Kind, ...]:
        """Return the readings of one kind: ``frame.of(Scan)``."""
        return tuple(reading for reading in self.readings if isinstance(reading, kind))


class WinchMode(StrEnum):
    """What a winch is to do."""

    OFF = "off"  # brake closed, no torque
    HOLD = "hold"  # stand still under torque
    VELOCITY = "velocity"
    TENSION = "tension"


@dataclass(frozen=True, eq=False)
class Command:
    """Command to the machine, valid until the next one. A winch that is off or holds has a speed of 0."""

    time: float  # s
    winch_speeds: Array  # (m,) rad/s of the winch drums, not the motors; positive pays cable out
    valve: float = 0.0  # opening of the powder's valve, 0 to 1
    modes: tuple[WinchMode, ...] = ()  # (m,); empty: all `VELOCITY`
    tensions: Array | None = None  # (m,) N, of the winches in mode `TENSION`; NaN: of the others. None: of none
    outputs: Mapping[str, float] = field(default_factory=dict)  # further outputs of the machine by name


class OrderKind(StrEnum):
    """Orders of an operator."""

    ENABLE = "enable"
    TAKE_UP = "take up"
    HOME = "home"
    RELEASE = "release"
    JOG = "jog"
    GO_TO = "go to"
    PARK = "park"
    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    OVERRIDE = "override"
    REFILLED = "refilled"
    STOP = "stop"
    EMERGENCY = "emergency stop"
    RESET = "reset"


ORDER_LIFE: Final = 1.0
"""Time, s, after which an order that enables or moves the machine is rejected, if it was not obeyed before."""


@dataclass(frozen=True, eq=False)
class Order:
    """An order, and who gave it.

    ``arguments``: of `JOG` the platform's ``velocity`` (3,), m/s, for `control.manual.LEASE`; of `GO_TO` the
    ``position`` (3,), m; of `OVERRIDE` the ``share`` of the planned speed, 0 to 1.
    """

    kind: OrderKind
    by: str = ""
    time: float = 0.0  # s, by the machine's clock
    arguments: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    refusal: str = ""  # why it was not obeyed; known afterwards


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
    lengths: Array  # (m,) m: unstrained, winch exit to platform point
    tensions: Array  # (m,) N: at the sheaves
    excess: Array  # (m,) m: over the taut length; positive is slack
    radii: Array  # (m,) m: of the winch drums, where cable leaves
    powder: float  # kg: left in the drum
    retraction: float = float("nan")  # m: length of a platform that retracts; NaN: of any other


@dataclass(frozen=True)
class Fault:
    """A fault that an estimator reports: its source, its start time (s), and one sentence."""

    source: str
    since: float
    sentence: str


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimated state of the machine, and its covariance."""

    time: float  # s
    position: Array  # (3,) m, world: of B
    velocity: Array  # (3,) m/s, world
    rotation: Array  # (3,) rad: rotation vector of the drum
    lengths: Array  # (m,) m: unstrained, winch exit to B
    excess: Array  # (m,) m: over the taut length; positive is slack
    slack: Mask  # (m,)
    radii: Array  # (m,) m: of the winch drums, at the cable
    covariance: Array | None = None  # (9, 9) of position, velocity, rotation, world; None: unknown
    faults: tuple[Fault, ...] = field(default=())
    valid: bool = True  # False: the position is uncertain; do not control by it
    clearance: float = float("nan")  # m, mean height of B over the surface below (fictive height); NaN: unknown
    consistency: Mapping[str, float] = field(default_factory=dict)
    """By sensor, mean of its last normalised innovations squared over their degrees of freedom: about 1."""

    @property
    def yaw(self) -> float:
        """Rotation of the drum about the vertical, rad, for small tilts."""
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


PER_LINE: Final[Mapping[type, tuple[str, ...]]] = MappingProxyType({
    Encoders: ("counts",),
    LineAngles: ("angles",),
    Swivels: ("angles",),
    Tensions: ("tensions",),
    Drives: ("states", "positions", "velocities", "torques", "following_errors", "faults"),
    Command: ("winch_speeds",),
    Truth: ("lengths", "tensions", "excess", "radii"),
    Estimate: ("lengths", "excess", "slack", "radii"),
})  # fmt: skip
"""Arrays (m,) with a number for each line, by kind of signal."""
