"""What the filter is told of the machine, what it keeps from step to step, and the algebra of its covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError
from cablewright.estimation.chain.state import Looked, ObserverSettings, ObserverState
from cablewright.estimation.fault_monitor import Watch
from cablewright.estimation.reading_checks import Intake
from cablewright.estimation.slackness import SlacknessState, Taut
from cablewright.estimation.time_buffer import Trail
from cablewright.signals import Scan

__all__ = ["FilterSettings", "FilterState", "Layout", "Since", "add_unknown", "correct", "fuse", "likely"]

Array = NDArray[np.float64]

_COARSE: Final = 0.15  # s that a step and a half take
_CHI2: Final = {1: 15.1, 2: 18.4, 3: 21.1}  # of so many numbers, exceeded by one of 10 000


@dataclass(frozen=True, eq=False)
class FilterSettings:
    """What is believed beside what the paper's chain is told, and how sure of it the filter is: standard deviations.

    ``chain``: with which the first place is found. docs/estimation.md says where each number is from.

    Random walks: ``travel`` m per root metre that B goes, of B and of lengths, for anchors, moduli and lines that
    change; ``time`` m per root second; ``radius_walk`` of each radius, a share per root radian; ``push`` m/s per root
    second, of B's speed where no encoder tells it; ``ground`` m per root metre, of what lies under the valve;
    ``gyro_noise`` rad per root second.

    Constant: ``radius`` as a share, ``gyro`` rad/s, ``lean`` rad of the accelerometer, ``height_bias`` m of the
    vertical lidar.

    Readings, besides their own noise: ``wall`` m and ``wall_angle`` rad of a wall's line, ``height`` m of the floor,
    ``level_height`` m of the distance sensor, ``gravity`` rad of a tenth of a second's mean, ``swing`` rad that the
    drum leans by and ``period`` s of its swing, ``angle`` rad of a smoothed line angle, ``excess`` m, ``stretch`` as a
    share, ``speed`` m/s and ``tremble`` rad of what is told.

    Without the inertial unit: ``turning`` rad/s of the drum, ``bend`` m that a wall then seems off for each rad/s.
    ``unsure``: m, of a position's standard deviation in space, beyond which the estimate is a guess.
    """

    chain: ObserverSettings
    travel: float = 5e-4
    time: float = 1e-4
    radius_walk: float = 3.6e-3
    push: float = 0.01
    ground: float = 0.03
    radius: float = 0.1
    gyro: float = 2e-3
    gyro_noise: float = 2e-4
    lean: float = 3e-3
    wall: float = 5e-5
    wall_angle: float = 1e-4
    height: float = 1e-4
    height_bias: float = 2e-3
    level_height: float = 2e-3
    gravity: float = 1e-3
    swing: float = 1e-3
    period: float = 1.5
    angle: float = math.radians(0.05)
    excess: float = 5e-4
    stretch: float = 0.25
    speed: float = 1e-3
    tremble: float = 1e-4
    turning: float = math.radians(1.5)
    bend: float = 0.15
    unsure: float = 0.1

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation."""
        for name, value in vars(self).items():
            if name != "chain" and not 0.0 < value < math.inf:
                raise InputError(f"{name} = {value:g}: a finite number over 0 is wanted")


class Layout(NamedTuple):
    """Where each part of the error state stands: slices; ``bias`` one for each horizontal lidar, then the vertical."""

    position: slice
    velocity: slice  # only where encoders do not tell it
    attitude: slice  # tilt x and y, yaw
    lengths: slice
    radii: slice  # as shares
    gyro: slice
    lean: slice
    bias: slice
    ground: int
    size: int

    @classmethod
    def of(cls, m: int, lidars: int) -> Layout:
        """Return the layout for *m* lines and so many horizontal *lidars*."""
        ends = np.cumsum([3, 3, 3, m, m, 3, 2, lidars + 1]).tolist()
        p, v, a, lengths, radii, gyro, lean, bias = map(slice, [0, *ends[:-1]], ends)
        return cls(p, v, a, lengths, radii, gyro, lean, bias, ends[-1], ends[-1] + 1)


class Since(NamedTuple):
    """What happened to B since some moments."""

    turned: Array  # (k, m) rad that the winch drums turned
    alone: Array  # (k,) s without encoders
    moved: Array  # (k, 3) m


@dataclass(eq=False)
class FilterState:
    """What `step` changes."""

    intake: Intake
    layout: Layout
    slackness: SlacknessState
    mass: float  # kg of the drum; who lets powder out may set it
    chain: ObserverState | None  # until the first place is found
    P: Array  # (size, size)
    time: float = -math.inf
    position: Array = field(default_factory=lambda: np.full(3, np.nan))
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    tilt: Array = field(default_factory=lambda: np.zeros(2))
    yaw: float = 0.0
    lengths: Array = field(default_factory=lambda: np.zeros(0))
    radii: Array = field(default_factory=lambda: np.zeros(0))
    gyro: Array = field(default_factory=lambda: np.zeros(3))
    lean: Array = field(default_factory=lambda: np.zeros(2))
    bias: Array = field(default_factory=lambda: np.zeros(0))
    ground: float = 0.0  # m: height of what lies under the valve
    angles: Array = field(default_factory=lambda: np.zeros(0))  # (m,) rad paid out
    rates: Array = field(default_factory=lambda: np.zeros(0))  # (m,) rad/s, smoothed
    drifted: Array = field(default_factory=lambda: np.zeros(4))  # m, and s, that B went without encoders
    way: Trail = field(default_factory=lambda: Trail(1, 1))  # angles, and `drifted`
    turning: Trail = field(default_factory=lambda: Trail(3, 1))  # yaw by the gyro, tilt, at the inertial readings'
    turn_rate: Array = field(default_factory=lambda: np.zeros(3))  # rad/s, of tilt and yaw
    gyro_yaw: float = 0.0  # rad: what the gyro made of yaw since the beginning
    gap: float = 0.1  # s without readings after which a sensor is not gone by
    told: float = -math.inf  # s: when the encoders were read last, ...
    went: float = -math.inf  # ... when they last told another count, ...
    felt: float = -math.inf  # ... and the inertial unit,
    blind: float = -math.inf  # ... without which all was until then
    pending: list[Scan] = field(default_factory=list)
    looked: Looked | None = None
    taut: Taut | None = None
    taut_at: Array = field(default_factory=lambda: np.zeros(3))
    drawn: float = -math.inf  # s: when taut was drawn
    jacobian: Array = field(default_factory=lambda: np.zeros((3, 0)))  # (3, m): how B moves as lengths grow
    speed: Array = field(default_factory=lambda: np.zeros(2))  # m/s of B, level, when gravity was used last ...
    push: Array = field(default_factory=lambda: np.zeros(2))  # ... and m/s^2, smoothed
    leans: list[tuple[float, float]] = field(default_factory=list)  # of the accelerometer, not yet used
    listened: float = -math.inf  # s: when the line angles were used last
    refused: dict[str, int] = field(default_factory=dict)  # turns in a row of which nothing fitted
    begun: float = -math.inf  # s: when the chain handed over
    fixed: float = -math.inf  # s: when a lidar told a place last
    across: dict[str, float] = field(default_factory=dict)  # s: when walls of each kind were seen last
    clearance_off: float = math.nan  # m: fictive height less the height of B
    free: bool = False  # no encoder tells where the drum goes
    nis: list[tuple[str, float, int]] | None = None  # what was made of innovations, for who wants to know

    @property
    def watch(self) -> Watch:
        """Faults."""
        return self.intake.watch

    @property
    def coarse(self) -> bool:
        """Whether steps are so long that the gyro does not tell how the drum turns: those of a quasi-static plant."""
        return self.gap > _COARSE

    def since(self, times: ArrayLike) -> Since:
        """Return what happened to B since *times* (k,), s."""
        gone = self.gone(times)
        m = len(self.angles)
        return Since(gone[:, :m], gone[:, m + 3], self.moved(gone))

    def gone(self, times: ArrayLike) -> Array:
        """Return what `way` keeps, less that at *times* (k,), s: (k, m + 4)."""
        return np.concatenate([self.angles, self.drifted]) - self.way.at(times)

    def moved(self, gone: Array) -> Array:
        """Return how far B went, (k, 3) m, while so much was *gone* (k, m + 4), by the radii as they are now."""
        m = len(self.angles)
        return np.asarray((gone[:, :m] * self.radii) @ self.jacobian.T + gone[:, m : m + 3])


def fuse(P: Array, H: Array, innovation: Array, R: Array) -> tuple[Array, Array]:
    """Return the correction (n,) and the covariance after it, by Joseph's form, which stays symmetric and positive.

    *H* (k, n), *innovation* (k,), *R* (k, k).
    """
    PH = P @ H.T
    S = H @ PH + R
    K = PH / S[0, 0] if len(H) == 1 else np.linalg.solve(S, PH.T).T
    A = -K @ H
    A.flat[:: len(P) + 1] += 1.0
    made = A @ P @ A.T + K @ R @ K.T
    return K @ innovation, 0.5 * (made + made.T)


def likely(P: Array, H: Array, innovation: Array, R: Array) -> tuple[bool, float]:
    """Whether so large an *innovation* (k,) is to be expected, and its squared size in standard deviations."""
    S = H @ P @ H.T + R
    size = float(innovation[0] ** 2 / S[0, 0] if len(H) == 1 else innovation @ np.linalg.solve(S, innovation))
    return size <= _CHI2[len(innovation)], size


def correct(state: FilterState, by: Array) -> None:
    """Take a correction (size,) into the state."""
    lay = state.layout
    state.position = state.position + by[lay.position]
    state.velocity = state.velocity + by[lay.velocity]
    state.tilt = state.tilt + by[lay.attitude][:2]
    state.yaw += float(by[lay.attitude][2])
    state.lengths = state.lengths + by[lay.lengths]
    state.radii = state.radii * np.exp(np.clip(by[lay.radii], -0.2, 0.2))
    state.gyro = state.gyro + by[lay.gyro]
    state.lean = state.lean + by[lay.lean]
    state.bias = state.bias + by[lay.bias]
    state.ground += float(by[lay.ground])


def add_unknown(state: FilterState, moved: ArrayLike) -> None:
    """Add that B, and the lengths with it, may be elsewhere by *moved*, m: along every axis, or (3,) along each."""
    lay = state.layout
    toward = np.zeros((len(state.lengths), 3)) if state.taut is None else state.taut.toward
    by_place = np.vstack([np.eye(3), toward]) * moved
    rows = np.r_[lay.position, lay.lengths]
    state.P[np.ix_(rows, rows)] += by_place @ by_place.T
