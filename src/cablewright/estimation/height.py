"""Height of the platform point B from the vertical lidar, above floor and structure.

Merlet and Papegay 2023, III.A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Scan
from cablewright.kernels.filtering import vertical_turn as kernel

_NORMAL: Final = NormalDist()
_BAND: Final = 3.0  # sigmas from the middle, of points of one level
_MIN_SHARE: Final = 0.1  # of the points of the fullest level, of the floor's
FLOOR_MAJORITY: Final = 0.5
"""Share of all points from which a level is certainly the floor."""
_MINORITY_REACH: Final = 0.25  # of the tolerated height of a floor that has fewer points
_MIN_SIGMA: Final = 1e-3  # m
_FLOOR_BAND: Final = 6.0  # sigmas above the line through the lowest points, of floor points


@dataclass(frozen=True)
class HeightSettings:
    """The vertical lidar and how its points are chosen.

    ``mount``: (3,) m and ``axes``: x and y of its plane, in the platform's frame. ``cone``: rad, half angle about the
    platform's axis in which the structure, and in the paper the floor, is measured. ``lowest_points``: how many points
    the floor's line goes through. ``outlier_distance``: m; a point that differs by more from both neighbours is
    rejected. ``sigma``: m, of one range: corrects the bias of taking the lowest of noisy points; 0, as the paper: no
    correction. ``max_slope``: slope of the line through the lowest points, beyond which these are no floor.
    ``floor_cone``: rad, half angle in which the floor is searched instead, as the lowest level with many points,
    because the cone may contain only structure; None, as the paper: in the cone. ``floor``: m, world, height of the
    floor. ``place_sigma``, m, and ``turn_sigma``, rad: of the lidar's mount along and about each axis of the drum.
    """

    mount: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], tuple[float, float, float]]
    cone: float = math.radians(20.0)
    lowest_points: int = 5
    outlier_distance: float = 0.05
    sigma: float = 0.0
    max_slope: float = 0.2
    floor_cone: float | None = None
    floor: float = 0.0
    place_sigma: float = 0.0
    turn_sigma: float = 0.0

    def __post_init__(self) -> None:
        """Reject a line through one point."""
        if self.lowest_points < 2:
            raise InputError(f"lowest_points = {self.lowest_points}: at least 2 points are expected")

    @cached_property
    def lidar(self) -> Array:
        """Mount and axes (9,), as `kernels.filtering.vertical_turn` takes them."""
        return np.concatenate([self.mount, *self.axes])

    @cached_property
    def heading(self) -> Array:
        """Horizontal unit direction (2,) of the scan's plane."""
        x, y = np.array(self.axes)[:, :2]
        longer = x if np.hypot(*x) > np.hypot(*y) else y
        return np.asarray(longer / np.hypot(*longer))


class HeightEstimate(NamedTuple):
    """Height of the platform point B by one vertical scan, m; NaN with the reason in `note` where unknown."""

    over_floor: float = math.nan  # world: z of B
    over_structure: float = math.nan  # mean over the cone: the paper's fictive height
    slope: float = math.nan  # of the line through the lowest points; near 0 on a level floor; NaN where none was fitted
    points: int = 0  # in the cone
    note: str = ""


def estimate_height(
    settings: HeightSettings, scan: Scan, tilt: ArrayLike, expected: float = math.nan, reach: float = math.inf
) -> HeightEstimate:
    """Return the height of the platform point B from one *scan* of the vertical lidar.

    *tilt*: (2,) or (n, 2) rad, as in `estimation.tilt`, at each ray. *expected*: m, B's height. *reach*: m, by which a
    floor may be above the expected one; a quarter of that where less than half of the points belong to it. It may be
    lower by any amount. Both are ignored if ``floor_cone`` is None.
    """
    cone = _cone(settings, scan, tilt)
    if isinstance(cone, HeightEstimate):
        return cone
    depth, along, last = cone
    fictive = settings.floor + float(depth.mean())
    if settings.floor_cone is not None:
        points, _ = _within(settings, scan, tilt, settings.floor_cone)
        ceiling = settings.floor - expected + reach if math.isfinite(expected) else math.inf
        band = np.full(len(points), _BAND * max(settings.sigma, _MIN_SIGMA))
        floor = floor_points(points[:, 2].copy(), points[:, :2] @ settings.heading, band, _MIN_SHARE, ceiling)
        count = int(np.count_nonzero(floor))
        low = float(points[floor, 2].mean()) if count else math.nan
        tolerance = reach if count >= FLOOR_MAJORITY * len(points) else _MINORITY_REACH * reach
        if count < kernel.MIN_LEVEL or settings.floor - low < expected - tolerance:
            note = "no floor in sight near the expected height"
            return HeightEstimate(over_structure=fictive, points=len(depth), note=note)
        return HeightEstimate(settings.floor - low, fictive, points=len(depth))
    order = np.argpartition(-depth, settings.lowest_points)[: settings.lowest_points]
    below = float(np.array(kernel.tilted(*settings.lidar[:3], *last)[:2]) @ settings.heading)
    slope, height = kernel.line(along[order] - below, depth[order])
    height -= _selection_bias(settings, depth, height + slope * (along - below))
    if not abs(slope) <= settings.max_slope:
        note = f"the lowest points slope by {slope:.2f}: no floor"
        return HeightEstimate(math.nan, fictive, slope, len(depth), note)
    return HeightEstimate(settings.floor + height, fictive, slope, len(depth))


def height_over_structure(settings: HeightSettings, scan: Scan, tilt: ArrayLike) -> float:
    """Return the height of B above the structure, m, from a vertical scan; NaN where nothing is visible."""
    cone = _cone(settings, scan, tilt)
    return math.nan if isinstance(cone, HeightEstimate) else settings.floor + float(cone[0].mean())


def _cone(settings: HeightSettings, scan: Scan, tilt: ArrayLike) -> HeightEstimate | tuple[Array, Array, Array]:
    """Points in the cone: depth (k,) below B, position (k,) along the scan, m; and the last one's tilt (2,), rad.

    A `HeightEstimate` with a note where there are too few.
    """
    level, last = _within(settings, scan, tilt, settings.cone)
    if len(level) < 2 * settings.lowest_points:
        return HeightEstimate(points=len(level), note="no floor in sight")
    depth, along = -level[:, 2], level[:, :2] @ settings.heading
    near = np.abs(np.diff(depth)) <= settings.outlier_distance
    kept = np.append(near, False) | np.append(False, near)
    depth, along = depth[kept], along[kept]
    if len(depth) < 2 * settings.lowest_points:
        return HeightEstimate(points=len(depth), note="no floor in sight: its points are isolated")
    return depth, along, last


def _within(settings: HeightSettings, scan: Scan, tilt: ArrayLike, half_angle: float) -> tuple[Array, Array]:
    """Points (k, 3), m from B, level, within *half_angle* (rad) of the drum's axis, and the last one's tilt (2,)."""
    tilts = np.empty((len(scan.ranges), 2))
    tilts[:] = tilt
    points, last = kernel.within(
        np.array(scan.ranges), scan.first_angle, scan.angle_step, settings.lidar, tilts, math.cos(half_angle)
    )
    return points, tilts[last]


def floor_points(heights: Array, along: Array, band: Array, share: float, ceiling: float) -> Mask:
    """Return which points (k,), in the order of their rays, are floor, by *heights* and places *along* the scan, m.

    They are within *band* (k,), m, of the `vertical_turn.lowest_level` below *ceiling*, m, and in runs that are level:
    the part of a flank that crosses that height is no floor. *share*: see there.
    """
    floor = np.zeros(len(heights), dtype=np.bool_)
    if len(heights):
        kernel.mark_floor(np.sort(heights), heights, along, band, share, ceiling, floor)
    return floor


def _selection_bias(settings: HeightSettings, depth: Array, floor: Array) -> float:
    """How much lower than the floor the mean of its lowest noisy points is expected, m."""
    count = int(np.count_nonzero(depth > floor - _FLOOR_BAND * settings.sigma))
    if settings.sigma == 0.0 or count <= settings.lowest_points:
        return 0.0
    share = settings.lowest_points / count
    return settings.sigma * _NORMAL.pdf(_NORMAL.inv_cdf(share)) / share
