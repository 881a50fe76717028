"""Height of B from the vertical lidar, over the floor and over what lies on it (Merlet and Papegay 2023, III.A)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError
from cablewright.signals import Scan

__all__ = [
    "MOSTLY",
    "HeightEstimate",
    "HeightSettings",
    "floor_among",
    "height_of",
    "leaned",
    "lowest_of_many",
    "over_structure",
]

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

_NORMAL: Final = NormalDist()
_NEAR: Final = 3.0  # sigmas from the middle, of points that count as one level
_FEW: Final = 8  # points at least that are the floor ...
_MANY: Final = 0.1  # ... and of the most that lie together
MOSTLY: Final = 0.5
"""Share of the points that lie on one level, of which this then is the floor."""
_DOUBTFUL: Final = 0.25  # of how far over where it should be a floor may lie that is no such
_APART: Final = 4  # rays from one point of a run on the floor to the next
_RUN: Final = 4  # points of such a run
_LEVEL: Final = 0.15  # slope of it, at most: powder lies at 0.4
_ROUNDS: Final = 3
_LEAST_SIGMA: Final = 1e-3  # m
_ON_FLOOR: Final = 6.0  # sigmas above the lowest points' line: what else counts as floor


@dataclass(frozen=True)
class HeightSettings:
    """The vertical lidar and how its points are chosen.

    ``place``: (3,) m and ``axes``: x and y of its plane, in the drum's frame. ``cone``: rad to both sides of the drum's
    axis. ``lowest``: how many points count as floor. ``alone``: m by which a point that both its neighbours differ from
    is no point. ``sigma``: m, of one range: by how much the lowest of noisy points are too low is then known, and taken
    off; 0 leaves it, as the paper does. ``slope``: of the line through the lowest, beyond which they are no floor.
    ``wide``: rad to both sides in which the floor is looked for instead, as the lowest level that many points lie on,
    for the cone may hold nothing but what was laid; None, as the paper: in the cone. ``floor``: m, world.
    """

    place: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], tuple[float, float, float]]
    cone: float = math.radians(20.0)
    lowest: int = 5
    alone: float = 0.05
    sigma: float = 0.0
    slope: float = 0.2
    wide: float | None = None
    floor: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a line through one point."""
        if self.lowest < 2:
            raise InputError(f"lowest = {self.lowest}: 2 points at least make a line")


class HeightEstimate(NamedTuple):
    """What one vertical scan tells. Both heights are B's, m; NaN where `note` says why not."""

    over_floor: float  # world: z of B
    over_structure: float  # over all that lies in the cone, on average: the paper's fictive height
    slope: float  # of the line through the lowest points; near 0 on a level floor; NaN where none was drawn
    points: int  # in the cone
    note: str


def height_of(
    settings: HeightSettings, scan: Scan, tilt: ArrayLike, expected: float = math.nan, reach: float = math.inf
) -> HeightEstimate:
    """Return B's height by one *scan*. *tilt*: (2,) or (n, 2) rad, as `estimation.tilt` has it, at each ray.

    *expected*: m, B's height; then what lies more than *reach*, m, over the floor is none, or more than a quarter of it
    where little is level. What lies under it is, how far ever: nothing is under a floor. Not looked at where the floor
    is looked for in the cone.
    """
    cone = _cone(settings, scan, tilt)
    if isinstance(cone, HeightEstimate):
        return cone
    depth, along, last = cone
    fictive = settings.floor + float(depth.mean())
    if settings.wide is not None:
        points = _within(settings, scan, tilt, settings.wide)[0]
        below = settings.floor - expected + reach if math.isfinite(expected) else math.inf
        near = np.full(len(points), _NEAR * max(settings.sigma, _LEAST_SIGMA))
        floor = floor_among(settings, points, points[:, 2], near, _MANY, below)
        count = int(np.count_nonzero(floor))
        low = float(points[floor, 2].mean()) if count else math.nan
        most = reach if count >= MOSTLY * len(points) else _DOUBTFUL * reach
        if count < _FEW or settings.floor - low < expected - most:
            return HeightEstimate(math.nan, fictive, math.nan, len(depth), "no floor in sight where it should be")
        return HeightEstimate(settings.floor - low, fictive, math.nan, len(depth), "")
    order = np.argpartition(-depth, settings.lowest)[: settings.lowest]
    under = float(leaned(np.array([settings.place]), last)[0, :2] @ _heading(settings))
    slope, at = _line(along[order] - under, depth[order])
    at -= _too_low(settings, depth, at + slope * (along - under))
    if not abs(slope) <= settings.slope:
        said = f"the lowest points slope by {slope:.2f}: no floor"
        return HeightEstimate(math.nan, fictive, slope, len(depth), said)
    return HeightEstimate(settings.floor + at, fictive, slope, len(depth), "")


def over_structure(settings: HeightSettings, scan: Scan, tilt: ArrayLike) -> float:
    """`HeightEstimate.over_structure` alone, m; NaN where nothing is in sight."""
    cone = _cone(settings, scan, tilt)
    return math.nan if isinstance(cone, HeightEstimate) else settings.floor + float(cone[0].mean())


def _cone(settings: HeightSettings, scan: Scan, tilt: ArrayLike) -> HeightEstimate | tuple[Array, Array, Array]:
    """Depth (k,) below B and place (k,) along the scan of the points in the cone, m, and the last lean (1, 2), rad.

    A height that says why where there are too few.
    """
    level, lean = _within(settings, scan, tilt, settings.cone)
    if len(level) < 2 * settings.lowest:
        return HeightEstimate(math.nan, math.nan, math.nan, len(level), "no floor in sight")
    depth, along = -level[:, 2], level[:, :2] @ _heading(settings)
    near = np.abs(np.diff(depth)) <= settings.alone
    kept = np.append(near, False) | np.append(False, near)
    depth, along = depth[kept], along[kept]
    if len(depth) < 2 * settings.lowest:
        return HeightEstimate(
            math.nan, math.nan, math.nan, len(depth), "no floor in sight: its points do not hang together"
        )
    return depth, along, lean[-1:]


def _within(settings: HeightSettings, scan: Scan, tilt: ArrayLike, reach: float) -> tuple[Array, Array]:
    """Points (k, 3), m from B, level, that are up to *reach* (rad) from the drum's axis, and its lean (k, 2)."""
    x, y = np.array(settings.axes)
    angles = scan.angles
    c, s = np.cos(angles), np.sin(angles)
    good = np.isfinite(scan.ranges) & (-(c * x[2] + s * y[2]) >= math.cos(reach))
    lean = np.broadcast_to(np.asarray(tilt, dtype=np.float64), (len(angles), 2))[good]
    rays = c[good, None] * x + s[good, None] * y  # drum
    return leaned(np.array(settings.place) + scan.ranges[good, None] * rays, lean), lean


def floor_among(settings: HeightSettings, points: Array, up: Array, reach: Array, many: float, below: float) -> Bools:
    """Which *points* (k, 3), m from B, level, in the order of their rays, are floor by how high they are *up* (k,), m.

    They are within *reach* (k,) of the lowest level *below* some height that *many* times the most lie on, and go on
    level: a flank that comes near is none.
    """
    floor = np.zeros(len(up), dtype=np.bool_)
    level = lowest_of_many(up, float(reach.mean()), many, below) if len(up) else math.nan
    near = np.flatnonzero(np.abs(up - level) < reach)
    along = points[:, :2] @ _heading(settings)
    for run in np.split(near, np.flatnonzero(np.diff(near) > _APART) + 1):
        if len(run) >= _RUN and abs(_line(along[run], up[run])[0]) < _LEVEL:
            floor[run] = True
    return floor


def lowest_of_many(values: Array, reach: float, many: float, below: float = math.inf) -> float:
    """The lowest of *values* (k,), all *below* some, that many lie within *reach* of; NaN where there is none.

    That is *many* times the most that lie so near to each other, and some at least.
    """
    ordered = np.sort(values)
    starts = ordered[: np.searchsorted(ordered, below)]
    if not len(starts):
        return math.nan
    count = np.searchsorted(ordered, starts + reach) - np.arange(len(starts))
    most = int(count.max())
    middle = float(ordered[np.argmax(count >= max(many * most, min(_FEW, most)))]) + 0.5 * reach
    for _ in range(_ROUNDS):
        near = ordered[np.abs(ordered - middle) < reach]
        if not len(near):
            break
        middle = float(near.mean())
    return middle


def _too_low(settings: HeightSettings, depth: Array, floor: Array) -> float:
    """How much lower than the floor the mean of the lowest of its noisy points is expected, m."""
    count = int(np.count_nonzero(depth > floor - _ON_FLOOR * settings.sigma))
    if settings.sigma == 0.0 or count <= settings.lowest:
        return 0.0
    share = settings.lowest / count
    return settings.sigma * _NORMAL.pdf(_NORMAL.inv_cdf(share)) / share


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope and value at 0 of the line through some points; level where they stand above each other."""
    away = x - x.mean()
    spread = float(away @ away)
    slope = float(away @ y) / spread if spread > 1e-12 else 0.0
    return slope, float(y.mean()) - slope * float(x.mean())


def _heading(settings: HeightSettings) -> Array:
    """Unit direction (2,), level, in which the scan's plane stands."""
    x, y = np.array(settings.axes)[:, :2]
    way = x if np.hypot(*x) > np.hypot(*y) else y
    return np.asarray(way / np.hypot(*way))


def leaned(points: Array, lean: Array) -> Array:
    """Points (n, 3) turned by small rotation vectors (n, 2), to second order."""
    (x, y, z), (rx, ry) = points.T, lean.T
    ux, uy, uz = ry * z, -rx * z, rx * y - ry * x  # turn x point
    return np.stack([x + ux + 0.5 * ry * uz, y + uy - 0.5 * rx * uz, z + uz + 0.5 * (rx * uy - ry * ux)], axis=1)
