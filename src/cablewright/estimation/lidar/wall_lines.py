"""Straight lines through clusters: clusters on one line are merged, outliers rejected, each line has a covariance.

Weighted total least squares: a range's noise is weighted by the angle between its ray and the line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.lidar.clusters import Clustering, find_clusters
from cablewright.estimation.lidar.line_fits import Rules, fit_lines
from cablewright.estimation.lidar.scan import LidarModel, Points
from cablewright.kernels.fitting.scan_lines import COLUMNS, draw

_MAX_LINES = 24


@dataclass(frozen=True)
class LineSearch:
    """When clusters are one line, and when a line is a wall.

    ``merge_distance``: m, of a cluster's ends from the line of another one to be merged with. ``outlier_sigmas``: from
    which a point is rejected. ``min_points`` and ``min_length`` (m): of a wall.
    """

    clustering: Clustering = field(default_factory=Clustering)
    merge_distance: float = 0.012
    outlier_sigmas: float = 3.5
    min_points: int = 10
    min_length: float = 0.4

    @classmethod
    def for_noise(cls, sigma: float) -> LineSearch:
        """Return a search for ranges with that noise, m; the default one up to a good lidar's noise."""
        usual = cls()
        clustering = replace(usual.clustering, reach=max(usual.clustering.reach, 20.0 * sigma))
        return replace(usual, clustering=clustering, merge_distance=max(usual.merge_distance, 4.0 * sigma))


class WallLine(NamedTuple):
    """A line n p = distance in the lidar's frame, n = (cos angle, sin angle) from the lidar towards it."""

    angle: float  # rad
    distance: float  # m, 0 or more
    covariance: Array  # (2, 2) of angle and distance, from the noise, or from the points' scatter if larger
    variance: float  # m^2, of the points' distances from the line
    point_count: int
    ends: Array  # (2, 2) m, the first and last of its points, on the line
    bias_slopes: Array  # (2,) of angle and distance per metre of bias of all ranges

    @property
    def length(self) -> float:
        """From end to end, m."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))


def find_lines(points: Points, lidar: LidarModel, search: LineSearch) -> list[WallLine]:
    """Find straight lines in a scan, sorted by falling number of points."""
    if lidar.sigma_per_metre > 0.0:
        return find_walls(points, lidar, search)
    members, first, size, sums = find_clusters(points, lidar.sigma, search.clustering)
    rules = np.array([
        lidar.sigma, lidar.angle_sigma, search.clustering.reach, search.merge_distance, search.outlier_sigmas,
        search.min_points, search.min_length,
    ], np.float64)  # fmt: skip
    work, marks = np.empty((6, len(points))), np.empty((2, len(points)), np.int64)
    found = np.empty((_MAX_LINES, COLUMNS))
    k = draw(points.xy, points.ray, points.distance, members, first, size, sums, rules, work, marks, found)
    return sorted(map(_line, found[:k].tolist()), key=lambda line: -line.point_count)


def find_walls(points: Points, lidar: LidarModel, search: LineSearch) -> list[WallLine]:
    """Find straight lines as `find_lines`, more slowly, for noise that grows with range.

    Lines continue past panes and gaps, and a point at a corner is of the nearer line only.
    """
    rules = Rules(lidar.angle_sigma, search.merge_distance, search.outlier_sigmas, search.min_points, search.min_length)
    found = fit_lines(points, lidar.sigmas(points.distance), search.clustering, rules, _MAX_LINES)
    return sorted(map(_line, found.tolist()), key=lambda line: -line.point_count)


def _line(row: Sequence[float]) -> WallLine:
    """Return a `WallLine` from the kernel's row: the normal turned away from the lidar, and the covariance."""
    ax, ay, offset, lever, low, high, count, total, larger, scale, squares, steep, turned = row
    sign = -1.0 if offset < 0.0 else 1.0
    turn = 1.0 / max(larger, 1e-300)  # rad^2, variance of the angle
    # n(angle) p = offset holds at the mean: the offset turns by where that is along the line, its lever.
    both, across = sign * lever * turn, 1.0 / total + lever**2 * turn
    # A bias moves each point by how steeply it is seen, which differs along the line.
    by_bias = turn * turned
    return WallLine(
        angle=math.atan2(sign * ax, -sign * ay),
        distance=sign * offset,
        covariance=scale**2 * np.array([[turn, both], [both, across]]),
        variance=squares / max(count - 2.0, 1.0),
        point_count=int(count),
        ends=np.array([[end * ax - offset * ay, end * ay + offset * ax] for end in (low, high)]),
        bias_slopes=np.array([by_bias, sign * (steep / total + lever * by_bias)]),
    )
