"""Straight lines through clusters of scan points, with covariances: clusters on one line merged, outliers rejected.

Weighted total least squares: a range's noise is weighted by the angle between its ray and the line. `scanned` makes of
a machine's scan the `LidarTurn` that estimators take.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.estimation.lidar.line_fits import Rules, fit_lines
from cablewright.estimation.lidar.scan import (
    Clustering,
    Levelled,
    LidarModel,
    Points,
    drift_of,
    find_clusters,
    level_mount,
    levelled,
)
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Scan
from cablewright.kernels.fitting.scan_lines import COLUMNS, draw, sweep

_MAX_LINES = 24


@dataclass(frozen=True)
class LineSearch:
    """Rules by which clusters are one line, and a line is a wall.

    ``merge_distance``: largest distance, m, of a cluster's ends from the line of another cluster with which it is
    merged. ``outlier_sigmas``: distance, in standard deviations, from which a point is rejected. ``min_points`` and
    ``min_length`` (m): smallest number of points and smallest length of a wall.
    """

    clustering: Clustering = field(default_factory=Clustering)
    merge_distance: float = 0.012
    outlier_sigmas: float = 3.5
    min_points: int = 10
    min_length: float = 0.4

    @classmethod
    def for_noise(cls, sigma: float) -> LineSearch:
        """Return the rules for ranges with that noise, m; the default ones up to a good lidar's noise."""
        usual = cls()
        clustering = replace(usual.clustering, reach=max(usual.clustering.reach, 20.0 * sigma))
        return replace(usual, clustering=clustering, merge_distance=max(usual.merge_distance, 4.0 * sigma))


class WallLine(NamedTuple):
    """A straight line n . p = distance in the lidar's frame, n = (cos angle, sin angle) from the lidar towards it."""

    angle: float  # rad
    distance: float  # m, 0 or more
    covariance: Array  # (2, 2) of angle and distance, from the noise, or from the points' scatter if larger
    variance: float  # m^2, of the points' distances from the line
    point_count: int
    ends: Array  # (2, 2) m, the first and last of its points, on the line
    bias_slopes: Array  # (2,) of angle and distance per metre of bias of all ranges

    @property
    def length(self) -> float:
        """Length from end to end, m."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))


Figures = tuple[float, float, Array, float, int, Array, Array]
"""The figures of a `WallLine`."""


@dataclass(frozen=True, eq=False)
class LidarTurn:
    """Straight lines, and points, of one turn of a lidar, level, in the platform's frame at the end of the turn.

    It is what both estimators take of a lidar. Each of k lines is n (p - ``mount``) = distance, n = (cos angle,
    sin angle), and its other figures are those of a `WallLine`; times are NaN where they do not matter. ``sweeps`` say
    when the beam swept over each line: s from the middle of its points to the end of the turn; m along the line, from
    the foot of the lidar's perpendicular to there; s/m, time to the end of the turn per offset along the line; m along
    the line, from the foot of the platform point's perpendicular to that of the lidar's; s, error of the line's angle
    per error of the platform's rate of turn; m s, of the distance at the points' middle likewise.
    """

    lidar: int  # index
    mount: Array  # (2,) m, of the lidar
    points: Array  # (n, 2) m
    angles: Array  # (k,) rad
    distances: Array  # (k,) m
    covariances: Array  # (k, 2, 2)
    variances: Array  # (k,) m^2
    counts: NDArray[np.int64]  # (k,)
    ends: Array  # (k, 2, 2) m
    bias_slopes: Array  # (k, 2)
    source: str = ""  # name of the lidar
    begin: float = math.nan  # s, of the first ray
    end: float = math.nan  # s, of the last one
    sweeps: Array = field(default_factory=lambda: np.empty((0, 6)))  # (k, 6)

    def __len__(self) -> int:
        """Return the number of lines."""
        return len(self.angles)

    @property
    def lengths(self) -> Array:
        """Length from end to end of each line, (k,) m."""
        return np.asarray(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))

    @classmethod
    def of(cls, lidar: int, mount: Array, points: Array, lines: Sequence[Figures]) -> LidarTurn:
        """Return the `LidarTurn` of *points* (n, 2), m, and *lines* in the platform's frame, without times."""
        columns = [np.array(column) for column in zip(*lines, strict=True)] if lines else _NO_LINES
        return cls(lidar, mount, points, *columns)


_NO_LINES: Final = [np.empty((0, *shape)) for shape in ((), (), (2, 2), (), (), (2, 2), (2,))]


def turn_of(
    lidar: LidarModel,
    index: int,
    search: LineSearch,
    angles: ArrayLike,
    ranges: ArrayLike,
    tilt: ArrayLike = (0.0, 0.0),
    drift: ArrayLike | None = None,
) -> LidarTurn:
    """Return the lines and points of a scan of the *lidar* of that *index*, without times; the rest as `levelled`."""
    points, mount = levelled(lidar, angles, ranges, tilt, drift), level_mount(lidar, tilt)
    c, s = math.cos(lidar.yaw), math.sin(lidar.yaw)
    turn = np.array([[c, s], [-s, c]])
    lines = [
        (angle + lidar.yaw, distance, covariance, variance, count, ends @ turn + mount, slopes)
        for angle, distance, covariance, variance, count, ends, slopes in find_lines(points, lidar, search)
    ]
    return LidarTurn.of(index, mount, points[0] @ turn + mount, lines)


def scanned(
    scan: Scan, lidar: LidarModel, index: int, search: LineSearch, attitudes: Array, moved: Array | None, yaw: float
) -> LidarTurn:
    """Return the lines and points of a machine's *scan*, for any estimator.

    *attitudes*: (n, 3) rad, of the platform at each ray: yaw from any direction, and tilt x and y. *moved*: (n, 2) m,
    of the platform at each ray, from the end of the turn, world; None: not known, nor is how it turned. *yaw*: rad,
    world, at the end.
    """
    drift = None if moved is None else drift_of(moved, attitudes[:, 0], yaw)
    turn = turn_of(lidar, index, search, scan.angles, scan.ranges, attitudes[:, 1:], drift)
    sweeps, last = np.empty((len(turn), 6)), scan.first_angle + scan.angle_step * (len(scan.ranges) - 1)
    mount, passed = np.append(turn.mount, lidar.yaw), np.array([last, scan.angle_step, scan.period])
    sweep(turn.angles, turn.distances, turn.ends, mount, passed, sweeps)
    return replace(turn, source=scan.source, begin=scan.begin, end=scan.time, sweeps=sweeps)


def find_lines(points: Levelled, lidar: LidarModel, search: LineSearch) -> list[Figures]:
    """Find straight lines in the lidar's frame in a scan's *points*, sorted by falling number of points."""
    if lidar.sigma_per_metre > 0.0:
        return _fitted(Points(*points), lidar, search)
    xy, ray, far, _ = points
    members, first, size, sums = find_clusters(points, lidar.sigma, search.clustering)
    rules = np.array([
        lidar.sigma, lidar.angle_sigma, search.clustering.reach, search.merge_distance, search.outlier_sigmas,
        search.min_points, search.min_length,
    ], np.float64)  # fmt: skip
    work, marks = np.empty((6, len(xy))), np.empty((2, len(xy)), np.int64)
    found = np.empty((_MAX_LINES, COLUMNS))
    k = draw(xy, ray, far, members, first, size, sums, rules, work, marks, found)
    return _figures(found[:k])


def find_walls(points: Points, lidar: LidarModel, search: LineSearch) -> list[WallLine]:
    """Find straight lines as `find_lines`, more slowly, for noise that grows with range.

    Lines continue past panes and gaps, and a point at a corner is of the nearer line only.
    """
    return [WallLine(*line) for line in _fitted(points, lidar, search)]


def _fitted(points: Points, lidar: LidarModel, search: LineSearch) -> list[Figures]:
    """Return the lines of `find_walls`."""
    rules = Rules(lidar.angle_sigma, search.merge_distance, search.outlier_sigmas, search.min_points, search.min_length)
    return _figures(fit_lines(points, lidar.sigmas(points.distance), search.clustering, rules, _MAX_LINES))


def _figures(found: Array) -> list[Figures]:
    """Return the figures of lines by the kernel's rows (k, COLUMNS), sorted by falling number of points."""
    return sorted(map(_line, found.tolist()), key=lambda line: -line[4])


def _line(row: Sequence[float]) -> Figures:
    """Return the figures of a line by the kernel's row: the normal turned away from the lidar, and the covariance."""
    ax, ay, offset, lever, low, high, count, total, larger, scale, squares, steep, turned = row
    sign = -1.0 if offset < 0.0 else 1.0
    turn = 1.0 / max(larger, 1e-300)  # rad^2, variance of the angle
    # n(angle) p = offset holds at the mean: the offset turns by where that is along the line, its lever.
    both, across = sign * lever * turn, 1.0 / total + lever**2 * turn
    # A bias moves each point by how steeply it is seen, which differs along the line.
    by_bias = turn * turned
    return (
        math.atan2(sign * ax, -sign * ay),
        sign * offset,
        scale**2 * np.array([[turn, both], [both, across]]),
        squares / max(count - 2.0, 1.0),
        int(count),
        np.array([[end * ax - offset * ay, end * ay + offset * ax] for end in (low, high)]),
        np.array([by_bias, sign * (steep / total + lever * by_bias)]),
    )
