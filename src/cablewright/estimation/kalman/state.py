"""State of the Kalman filter, and the algebra of its covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.estimation.kalman.consistency import LARGE, Consistency
from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.estimation.kalman.sag import Sag
from cablewright.estimation.reading_checks import ClockedState
from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.filtering import update as kernel

_LONG_GAP: Final = 0.15  # s, of a step and a half
_SHAKEN_SIGMA: Final = 0.01  # m
INCONSISTENT: Final = f"its readings are over {math.sqrt(LARGE):g} times as far from the estimate as expected"
_NONE: Final = slice(0, 0)
_NOTHING: Final = np.zeros(0, np.bool_)
_NO_SPREAD: Final = np.zeros((0, 0))
_States = slice | NDArray[np.intp]
CHI2: Final = {1: 15.1, 2: 18.4, 3: 21.1, 4: 23.5}
"""Gates of the normalised square of an innovation by degrees of freedom: exceeded by one of 10 000."""


class FilterLayout(NamedTuple):
    """Positions (slices) of the parts of the error state.

    ``range_bias`` has one entry for each horizontal lidar, then the vertical one. From ``walls`` on they are constants
    of a machine as built: errors of its specified values.
    """

    position: slice
    velocity: slice  # used without encoders only
    attitude: slice  # tilt x and y, yaw
    lengths: slice
    radii: slice  # as shares
    gyro_bias: slice
    accelerometer_bias: slice
    range_bias: slice
    ground: int
    stretch: slice  # m/s, by which each line's unstrained length grows and no encoder shows
    walls: slice  # of each: distance at its reference, and slope, as azimuth
    mounts: slice  # of each horizontal lidar: x, y and yaw, drum's axes
    vertical_mount: slice  # x, y, z and rotation vector, drum's axes
    zeros: slice  # of the line accelerometers
    compliances: slice  # of each line with its mount, as logarithms of `Lines.compliances`
    clock: int  # of the drum's clock, ahead of the machine's
    size: int
    camera: slice  # its errors, before the end

    @classmethod
    def of(cls, m: int, lidars: int, walls: int, camera: int = 0) -> FilterLayout:
        """Return the layout for *m* lines, *lidars* horizontal lidars, *walls* walls and errors of a *camera*."""
        sizes = [3, 3, 3, m, m, 3, 2, lidars + 1, 1, m, 2 * walls, 3 * lidars, 6, m, m, 1, camera]
        ends = np.cumsum(sizes).tolist()
        at: list[Any] = [slice(end - size, end) for size, end in zip(sizes, ends, strict=True)]
        return cls._make([*at[:8], at[8].start, *at[9:15], at[15].start, ends[-1], at[16]])

    @property
    def surveyed(self) -> slice:
        """Indices of quantities measured by tape: walls and mounts of lidars."""
        return slice(self.walls.start, self.vertical_mount.stop)

    @property
    def placed(self) -> NDArray[np.intp]:
        """Indices of the places of all that measures B: `surveyed`, and the camera's errors."""
        return np.asarray(np.r_[self.surveyed, self.camera])

    @property
    def tilt(self) -> slice:
        """Indices of the tilt: the first two coordinates of the attitude."""
        return slice(self.attitude.start, self.attitude.start + 2)

    @property
    def yaw(self) -> int:
        """Index of the yaw: the last coordinate of the attitude."""
        return int(self.attitude.stop) - 1


class Mean(NamedTuple):
    """State vector of the filter, packed in the order of its error, for kernels."""

    x: Array  # (size,)
    layout: FilterLayout
    at: NDArray[np.int64]  # first indices of the layout's parts, and its size

    @classmethod
    def of(cls, layout: FilterLayout) -> Mean:
        """Return the state vector before the first state is found."""
        x = np.zeros(layout.size)
        x[layout.position] = np.nan
        return cls(x, layout, np.array([each.start if isinstance(each, slice) else each for each in layout]))


class _Part:
    """A part of the mean, as rows of so many *columns*: a view, which assignment fills."""

    def __init__(self, name: str, columns: int = 0, last: int | None = None) -> None:
        self._name, self._shape, self._last = name, (-1, columns) if columns else (-1,), last
        self._key = f"_{name}_{last}"  # of the view that its owner keeps

    def __get__(self, owner: Any, kind: type) -> Array:
        mean, found = owner.mean, owner.__dict__.get(self._key)  # which deep copies do not share
        if found is None or found.base is not mean.x:
            part = mean.x[getattr(mean.layout, self._name)]
            found = owner.__dict__[self._key] = part[: self._last].reshape(self._shape)
        view: Array = found
        return view

    def __set__(self, owner: Any, value: ArrayLike) -> None:
        self.__get__(owner, type(owner))[...] = value


class _Number:
    """One number of the mean."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, owner: Any, kind: type) -> float:
        return float(owner.mean.x[getattr(owner.mean.layout, self._name)])

    def __set__(self, owner: Any, value: float) -> None:
        owner.mean.x[getattr(owner.mean.layout, self._name)] = value


class MotionSince(NamedTuple):
    """Motion of the platform from k times until now."""

    rotation: Array  # (k, m) rad, of the winch drums
    coasting_time: Array  # (k,) s without encoders
    displacement: Array  # (k, 3) m


@dataclass(eq=False)
class DrumMotionState:
    """Position and velocity of B, rotation of the winch drums, and when encoders were last reliable. Times are in s."""

    position, velocity = _Part("position"), _Part("velocity")

    mean: Mean
    mass: float  # kg of the drum, see `drum_mass.weigh`
    travelled: Array = field(default_factory=lambda: np.zeros(4))  # (m + 4,): see `drum_angles` and `coasted`
    drum_rates: Array = field(default_factory=lambda: np.zeros(0))  # (m,) rad/s, smoothed
    coasting: bool = False  # predicting without encoders
    max_gap: float = 0.1  # s without readings after which a sensor is not relied on
    last_encoder_time: float = -math.inf  # of the last encoder reading ...
    last_motion_time: float = -math.inf  # ... and the last in which the counts had changed
    settling_start: float = -math.inf  # when the first state, or encoders after a gap, were first used
    bounce_end: float = -math.inf  # of the drum, after a large sudden change of its mass

    @property
    def drum_angles(self) -> Array:
        """Angles (m,), rad, that the drums have paid out; a view."""
        return self.travelled[:-4]

    @property
    def coasted(self) -> Array:
        """Motion (3,), m, that no count shows, and time, s, without encoders; a view (4,)."""
        return self.travelled[-4:]


@dataclass(eq=False)
class DrumAttitude:
    """Attitude of the platform, by gyro and accelerometer. Times are in s."""

    tilt, yaw = _Part("attitude", last=2), _Number("yaw")

    mean: Mean
    angular_rate: Array = field(default_factory=lambda: np.zeros(3))  # rad/s, of tilt and yaw
    gyro_yaw: float = 0.0  # rad: yaw by the gyro alone
    turn_yaw: float = 0.0  # rad, of `gyro_yaw` at the end of the extracted turn
    level_velocity: Array = field(default_factory=lambda: np.zeros(2))  # m/s of B, at the last update by gravity ...
    level_acceleration: Array = field(default_factory=lambda: np.zeros(2))  # ... and m/s^2, smoothed
    measured_tilts: list[tuple[float, float]] = field(default_factory=list)  # rad, by the accelerometer, not used yet
    last_imu_time: float = -math.inf  # to which the attitude is integrated
    imu_gap_end: float = -math.inf  # of the last time without an IMU
    shaken_time: float = -math.inf  # when B was last accelerated in a way that encoders do not show
    shaken_since: float = -math.inf  # when that began


@dataclass(eq=False)
class Lines:
    """Estimated state of the m lines, and the times, s, of updates by their angles.

    ``stretch_rates``: rates of the unstrained lengths, m/s; ``compliances``: compliances of lines with mounts, relative
    to those described.
    """

    lengths, radii, stretch_rates = _Part("lengths"), _Part("radii"), _Part("stretch")
    zeros, compliances = _Part("zeros"), _Part("compliances")

    mean: Mean
    layer_radii: Array = field(default_factory=lambda: np.zeros(0))  # (m,) m, expected by the layers of the coils
    stretching: float = 0.0  # s since the covariance had what the rates of stretch did
    loosened: Array = field(default_factory=lambda: np.zeros(0))  # (m,) m of excess, since the covariance had it
    last_angle_time: float = -math.inf  # of the last update by line angles
    angles_refused_since: float = math.inf  # of the first in a row that was rejected; inf: the last was not


@dataclass(eq=False)
class Hung:
    """Linearised statics of the lines at the position of B where they were last computed."""

    position: Array = field(default_factory=lambda: np.zeros(3))
    time: float = -math.inf  # s
    sag: Sag | None = None
    jacobian: Array = field(default_factory=lambda: np.zeros((3, 0)))  # (3, m): motion of B per length
    rising: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m/N: motion of B per force upwards
    by_compliance: Array = field(default_factory=lambda: np.zeros((3, 0)))  # (3, m): motion of B, per `Lines.loosened`


@dataclass(eq=False)
class AsBuilt:
    """Estimated errors of sensors and of specified values, and the ground height.

    ``wall_errors``: (w, 2) m and rad; ``mount_errors``: (l, 3) m, m and rad; ``vertical_mount_error``: (6,) m and rad;
    ``clock_error``: s; ``ground_height``: m, under the valve.
    """

    gyro_bias, accelerometer_bias = _Part("gyro_bias"), _Part("accelerometer_bias")
    range_bias, ground_height, clock_error = _Part("range_bias"), _Number("ground"), _Number("clock")
    wall_errors, mount_errors = _Part("walls", 2), _Part("mounts", 3)
    vertical_mount_error = _Part("vertical_mount")

    mean: Mean
    unfaded: float = 0.0  # s since what was learnt of surveyed numbers faded
    survey_variances: Array = field(default_factory=lambda: np.zeros(0))  # of `FilterLayout.surveyed`, at first
    ground_map: GroundMap = field(default_factory=GroundMap)


@dataclass(eq=False)
class Judged:
    """Record of how well measurements agree with the state. Times are in s."""

    consistency: Consistency = field(default_factory=Consistency)
    rejections: dict[str, int] = field(default_factory=dict)  # in a row, by measurement
    last_position_time: float = -math.inf  # of the last update by a wall
    last_wall_times: dict[str, float] = field(default_factory=dict)  # of the last update, by kind of wall
    survey_doubt: Array = field(default_factory=lambda: np.zeros((3, 3)))  # m^2, variance of the position to be added
    sound: float = 0.0  # finite where all of the state was in the last estimate


@dataclass(eq=False, kw_only=True)
class FilterState(ClockedState):
    """State of the filter, changed in place by `step`. `FilterLayout` names the parts of its vector.

    The motion of its ``turns`` is `DrumMotionState.drum_angles` and `DrumMotionState.coasted`.
    """

    mean: Mean
    P: Array  # (size, size)
    motion: DrumMotionState
    attitude: DrumAttitude
    lines: Lines
    built: AsBuilt
    hung: Hung = field(default_factory=Hung)
    judged: Judged = field(default_factory=Judged)

    @property
    def layout(self) -> FilterLayout:
        """The positions of all quantities in state and covariance."""
        return self.mean.layout

    @property
    def has_long_steps(self) -> bool:
        """Whether time steps are too long to integrate the gyro, as those of a quasi-static simulation."""
        return self.motion.max_gap > _LONG_GAP

    def motion_since(self, times: ArrayLike) -> MotionSince:
        """Return the motion since *times* (k,), s."""
        change = self.change_since(times)
        m = len(self.lines.lengths)
        return MotionSince(change[:, :m], change[:, m + 3], self.displacement(change))

    def change_since(self, times: ArrayLike) -> Array:
        """Return the change (k, m + 4) of `drum_angles` and `coasted` since *times* (k,), s."""
        return self.motion.travelled - self.turns.motion.at(times)

    def displacement(self, change: Array) -> Array:
        """Return the displacement of B (k, 3), m, by a *change* (k, m + 4) of the state with the present radii."""
        m = len(self.lines.lengths)
        return np.asarray((change[:, :m] * self.lines.radii) @ self.hung.jacobian.T + change[:, m : m + 3])


def kalman_update(
    P: Array, H: Array, innovation: Array, R: Array, spread: Array | None = None, considered: _States = _NONE
) -> tuple[Array, Array]:
    """Return the correction (n,) and the updated covariance, in Joseph's form, which stays symmetric and positive.

    *H* (k, n), *innovation* (k,), *R* (k, k). With a *spread* (k, k) the innovation is the mean of several that may be,
    and that their covariance: the law of the state is their mixture, of which this keeps both moments. States that are
    *considered* (Schmidt 1966) count with their covariance and are not corrected.
    """
    updated, correction = P.copy(), np.empty(len(P))
    kernel.correct(
        updated, H, innovation, R, _NO_SPREAD if spread is None else spread, _chosen(considered, len(P)), correction
    )
    return correction, updated


def passes_gate(P: Array, H: Array, innovation: Array, R: Array) -> tuple[bool, float]:
    """Return whether an *innovation* (k,) passes the chi-square gate, and its normalised square (NIS)."""
    nis = kernel.size_of(P, H, innovation, R)
    return nis <= CHI2[len(innovation)], nis


def _chosen(states: _States, size: int) -> Mask:
    """Return which states, (size,), are among the given ones; empty: none is."""
    if states is _NONE:
        return _NOTHING
    found = np.zeros(size, np.bool_)
    found[states] = True
    return found


def update_state(state: FilterState, sensor: str, H: Array, innovation: Array, R: Array) -> None:
    """Update the state by one measurement of a *sensor*, and record its consistency."""
    judge(state, sensor, passes_gate(state.P, H, innovation, R)[1], len(innovation))
    apply_update(state, H, innovation, R)


def apply_update(
    state: FilterState, H: Array, innovation: Array, R: Array, spread: Array | None = None, considered: _States = _NONE
) -> None:
    """Update the state and its covariance, in place, by one measurement, as `kalman_update`."""
    x, _, at = state.mean
    spread = _NO_SPREAD if spread is None else spread
    kernel.update(x, state.P, at, H, innovation, R, spread, _chosen(considered, len(x)))


def moving_velocity(state: FilterState) -> Array:
    """Return the velocity (3,) of B, m/s: by the winches, or its own state while no encoder reports it."""
    if state.motion.coasting:
        return state.motion.velocity
    return np.asarray(state.hung.jacobian @ (state.lines.radii * state.motion.drum_rates))


def judge(state: FilterState, sensor: str, nis: float, freedoms: int) -> None:
    """Add an innovation's normalised square to the mean of its *sensor*, and report the sensor if that is large."""
    consistent = state.judged.consistency.add(sensor, nis, freedoms)
    if consistent is not None:
        state.monitor.set(sensor, "consistency", INCONSISTENT, active=not consistent)


def diagonal(P: Array) -> Array:
    """Return the diagonal (n,) of *P* (n, n), to be changed in place."""
    return P.reshape(-1)[:: len(P) + 1]


def inject_correction(state: FilterState, correction: Array) -> None:
    """Add an error-state *correction* (size,) to the state."""
    kernel.inject(state.mean.x, state.mean.at, correction)


def inflate_shaken(state: FilterState, most: float = math.inf) -> None:
    """Add the uncertainty of a motion of B that encoders did not measure, *most* m so far, until it is measured."""
    position, deviation = state.layout.position, min(most, _SHAKEN_SIGMA)
    if float(np.trace(state.P[position, position])) < deviation**2:
        inflate_position(state, deviation)


def inflate_position(state: FilterState, deviation: ArrayLike) -> None:
    """Add a *deviation* of B, m, to the covariance, and to the lengths': along every axis, or (3,) along each."""
    lay = state.layout
    toward = np.zeros((len(state.lines.lengths), 3)) if state.taut is None else state.taut.toward
    spread = np.vstack([np.eye(3), toward]) * deviation
    rows = np.r_[lay.position, lay.lengths]
    state.P[np.ix_(rows, rows)] += spread @ spread.T
