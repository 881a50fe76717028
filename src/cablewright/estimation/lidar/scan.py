"""One scan of a planar lidar: model of the device, points corrected for tilt and motion, and their clusters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting.scan_lines import SUMS, choose, cut, level, tilted

Index = NDArray[np.int64]
Levelled = tuple[Array, Array, Array, Array]
"""The arrays of `Points`."""

_STILL: Final = np.empty((0, 3))


@dataclass(frozen=True)
class LidarModel:
    """A planar lidar on the platform; the defaults are an RPLIDAR A1M8's, by Merlet and Papegay 2023.

    ``mount``: (3,) m, from the platform point to its centre, platform frame. ``yaw``: rad, direction of its angle 0 in
    the platform frame. ``min_range`` and ``max_range``: m. ``sigma``: m, of one range at 0 m, and ``sigma_per_metre``:
    m/m, how much it grows with range; ``angle_sigma``: rad, of one bearing; ``bias_sigma``: m, of the common error of
    all ranges of this unit; ``place_sigma``, m, and ``turn_sigma``, rad: of its mount along and about each axis.
    ``masks``: bearings (from, to), rad, counter-clockwise, at which it sees the platform itself. ``visible_walls``:
    names of the walls that it can see; None: all.
    """

    name: str = "lidar"
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    min_range: float = 0.15
    max_range: float = 12.0
    sigma: float = 2e-3
    angle_sigma: float = 0.0
    bias_sigma: float = 2e-3
    masks: tuple[tuple[float, float], ...] = ()
    visible_walls: tuple[str, ...] | None = None
    sigma_per_metre: float = 0.0
    place_sigma: float = 0.0
    turn_sigma: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.min_range < self.max_range < math.inf and 0 < self.sigma < math.inf):
            raise InputError(
                f"lidar {self.name!r}: 0 <= min_range < max_range and sigma over 0 are expected, "
                f"not {self.min_range:g}, {self.max_range:g} and {self.sigma:g}"
            )
        if not 0 <= self.sigma_per_metre < 1:
            raise InputError(f"lidar {self.name!r}: sigma_per_metre = {self.sigma_per_metre:g}: must be from 0 to 1")

    @cached_property
    def masked(self) -> Array:
        """The masks, (k, 2) rad."""
        return np.array(self.masks, dtype=np.float64).reshape(-1, 2)

    def sigmas(self, distance: Array) -> Array:
        """Return the standard deviations (n,), m, of the ranges to given distances (n,), m."""
        return np.asarray(self.sigma + self.sigma_per_metre * distance)


@dataclass(frozen=True)
class Clustering:
    """Rules by which points of a scan belong to one cluster.

    ``min_incidence``: rad, smallest angle between ray and wall at which the next point of a wall is expected.
    ``max_missing``: rays without an echo between two points of a cluster. ``reach``: m, distance to the two outer ones
    of three aligned points: noise hides a corner between successive points of a near wall. ``alignment``: m, distance
    of the middle point from the line of the outer two, besides three sigma of noise. ``min_points``: smallest number of
    points in a cluster.
    """

    min_incidence: float = math.radians(10.0)
    max_missing: int = 4
    reach: float = 0.12
    alignment: float = 4e-3
    min_points: int = 5


class Points(NamedTuple):
    """The points of one scan by rising bearing, beginning after the widest gap; level, in the lidar's frame."""

    xy: Array  # (n, 2) m
    ray: Array  # (n, 2) unit, from the lidar to the point
    distance: Array  # (n,) m
    bearing_step: Array  # (n,) rad, to the next point's bearing; of the last point: to the first one's, a turn later

    def __len__(self) -> int:
        return len(self.xy)


def drift_of(displacement: Array, yaws: Array, yaw: float) -> Array:
    """Return the pose (n, 3), m and rad, of the platform at each ray relative to the end of the scan.

    Along the platform's level axes there. ``displacement``: (n, 2) m, from the end, reference frame. ``yaws``: (n,)
    rad, from any direction; ``yaw``: rad, of the platform at the end, reference frame.
    """
    c, s = math.cos(yaw), math.sin(yaw)
    return np.column_stack([displacement @ np.array([[c, -s], [s, c]]), yaws - yaws[-1]])


def level_points(
    lidar: LidarModel,
    angles: ArrayLike,
    ranges: ArrayLike,
    tilt: ArrayLike = (0.0, 0.0),
    drift: ArrayLike | None = None,
) -> Points:
    """Return the valid points of a scan as `levelled` does, with their arrays by name."""
    return Points(*levelled(lidar, angles, ranges, tilt, drift))


def levelled(
    lidar: LidarModel,
    angles: ArrayLike,
    ranges: ArrayLike,
    tilt: ArrayLike = (0.0, 0.0),
    drift: ArrayLike | None = None,
) -> Levelled:
    """Return the valid points of a scan, corrected to the level frame of the lidar at the end of the turn.

    Valid are finite ranges within the unit's range that do not meet the platform. ``angles``: (n,) rad,
    counter-clockwise; ``ranges``: (n,) m, 0 or not finite: no echo. ``tilt``: (2,) or (n, 2) rad, rotation vector
    (x, y) from the level platform frame to the tilted one, at the end or at each ray. ``drift``: (n, 3) m and rad, x, y
    and yaw of the platform at each ray relative to the end, along its level axes there, as of `drift_of`.

    Raises `InputError` for arrays whose shapes differ.
    """
    a, r = np.array(angles, dtype=np.float64), np.array(ranges, dtype=np.float64)
    if a.ndim != 1 or a.shape != r.shape:
        raise InputError(f"scan: as many angles as ranges are expected, not shapes {a.shape} and {r.shape}")
    n, tilts, moved = len(a), np.array(tilt, dtype=np.float64), _STILL
    if drift is not None:
        moved = np.array(drift, dtype=np.float64)
    if tilts.shape not in ((2,), (n, 2)) or (drift is not None and moved.shape != (n, 3)):
        shapes = f"{tilts.shape} and {None if drift is None else moved.shape}"
        raise InputError(f"scan: a tilt (2,) or (n, 2) and a drift (n, 3) are expected, not {shapes}")
    last = tilts[-1:] if tilts.ndim == 2 else tilts[None]
    count, chosen, bearing = 0, np.empty(n, np.int64), np.empty(n)
    if np.isfinite(last).all():  # else the tilt at the end is not known
        tilts = np.ascontiguousarray(tilts.reshape(-1, 2))
        count = choose(a, r, tilts, moved, np.array([lidar.min_range, lidar.max_range]), lidar.masked, chosen, bearing)
    order = bearing[:count].argsort(kind="stable")
    xy, ray, far, step = np.empty((count, 2)), np.empty((count, 2)), np.empty(count), np.empty(count)
    if count:
        mount, centre = np.array([lidar.yaw, *lidar.mount]), level_mount(lidar, last)
        level(bearing[order], chosen[order], r, tilts, moved, mount, centre, xy, ray, far, step)
    return xy, ray, far, step


def level_mount(lidar: LidarModel, tilt: ArrayLike = (0.0, 0.0)) -> Array:
    """Return the horizontal position (2,), m, of the lidar's centre from the platform point, in the level frame."""
    last = np.asarray(tilt, dtype=np.float64).reshape(-1, 2)[-1]
    return np.array(tilted(*map(float, lidar.mount), *last.tolist()))


def find_clusters(points: Levelled, sigma: float, settings: Clustering) -> tuple[Index, Index, Index, Array]:
    """Cut a scan's *points* into k clusters. ``sigma``: m, of one range.

    Returns their members, the first (k,) and the number (k,) of each one's, and their sums (k, SUMS): means, ends and
    scatters. Points of cluster i are ``members[first[i]:first[i] + size[i]]``.
    """
    (xy, _, far, step), c = points, settings
    n = len(xy)
    rules = np.array([sigma, c.min_incidence, c.max_missing, c.reach, c.alignment, c.min_points], np.float64)
    work, marks, sums = np.empty((4, n)), np.empty((5, n), np.int64), np.empty((n // 2, SUMS))
    members, first, size = marks[2:]
    k = cut(xy, far, step, rules, work, marks[:2], members, first, size, sums)
    return members, first[:k], size[:k], sums[:k]
