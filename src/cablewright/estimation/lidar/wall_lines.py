"""Straight lines through clusters: pieces of one line put together, outliers left out, each line with its covariance.

Total least squares, weighted: a range's noise counts by how steeply its ray meets the line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.lidar.clusters import Clustering, clusters_of
from cablewright.estimation.lidar.scan import LidarModel, Points
from cablewright.kernels.fitting.scan_lines import COLUMNS, draw

__all__ = ["LineSearch", "WallLine", "lines_of"]

Array = NDArray[np.float64]

_MOST_LINES = 24


@dataclass(frozen=True)
class LineSearch:
    """When clusters are one line, and when a line is long enough to be a wall.

    ``merge``: m, how far the ends of a cluster may be from another one's line. ``outlier``: sigmas from which a point
    does not count. ``least_points`` and ``least_length`` (m): of a wall.
    """

    clustering: Clustering = field(default_factory=Clustering)
    merge: float = 0.012
    outlier: float = 3.5
    least_points: int = 10
    least_length: float = 0.4

    @classmethod
    def of_noise(cls, sigma: float) -> LineSearch:
        """Return a search that suits ranges of that noise, m; that of a good lidar or less leaves all as it is."""
        usual = cls()
        clustering = replace(usual.clustering, reach=max(usual.clustering.reach, 20.0 * sigma))
        return replace(usual, clustering=clustering, merge=max(usual.merge, 4.0 * sigma))


class WallLine(NamedTuple):
    """A line n p = distance in the lidar's frame, n = (cos angle, sin angle) from the lidar towards it."""

    angle: float  # rad
    distance: float  # m, 0 or more
    covariance: Array  # (2, 2) of angle and distance, from the noise; more if the points scatter more
    variance: float  # m^2, of the points' distances from the line
    points: int
    ends: Array  # (2, 2) m, the first and last of its points, on the line
    per_bias: Array  # (2,) what angle and distance change by per metre that all ranges are off

    @property
    def length(self) -> float:
        """From end to end, m."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))


def lines_of(points: Points, lidar: LidarModel, search: LineSearch) -> list[WallLine]:
    """Find straight lines in a scan, those with most points first."""
    members, first, size, sums = clusters_of(points, lidar.sigma, search.clustering)
    rules = np.array([
        lidar.sigma, lidar.angle_sigma, search.clustering.reach, search.merge, search.outlier, search.least_points,
        search.least_length,
    ], np.float64)  # fmt: skip
    work, marks = np.empty((6, len(points))), np.empty((2, len(points)), np.int64)
    found = np.empty((_MOST_LINES, COLUMNS))
    k = draw(points.xy, points.ray, points.distance, members, first, size, sums, rules, work, marks, found)
    return sorted(map(_line, found[:k].tolist()), key=lambda line: -line.points)


def _line(row: Sequence[float]) -> WallLine:
    """Turn the normal away from the lidar, and say how well the line is known."""
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
        points=int(count),
        ends=np.array([[end * ax - offset * ay, end * ay + offset * ax] for end in (low, high)]),
        per_bias=np.array([by_bias, sign * (steep / total + lever * by_bias)]),
    )
