"""Straight lines through clusters: pieces of one line put together, outliers left out, each line with its covariance.

Total least squares, weighted: a range's noise counts by how steeply its ray meets the line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.clusters import Clustering, Clusters, clusters_of
from cablewright.estimation.scan import Lidar, Points

__all__ = ["LineSearch", "WallLine", "lines_of"]

Array = NDArray[np.float64]

_ROUNDS = 3
_LEAST_STEEPNESS = 0.3  # of a ray on a line: a flatter one is not trusted more
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


def lines_of(points: Points, lidar: Lidar, search: LineSearch) -> list[WallLine]:
    """Find straight lines in a scan, those with most points first."""
    clusters = clusters_of(points, lidar.sigma, search.clustering)
    found = [_fitted(points, lidar, search, group, clusters) for group in _groups(clusters, search)]
    walls = [line for line in found if line is not None]
    return sorted(walls, key=lambda line: -line.points)


class _Axes(NamedTuple):
    """Lines through k sets of points."""

    normal: Array  # (k, 2)
    along: Array  # (k, 2)
    half: Array  # (k,) m, half the length of evenly spread points


def _axes(count: Array, scatter: Array) -> _Axes:
    """Total least squares from sums: the direction of the larger axis of each scatter."""
    xx, xy, yy = scatter.T
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    larger = 0.5 * (xx + yy + np.hypot(xx - yy, 2.0 * xy))
    return _Axes(normal, along, np.sqrt(3.0 * larger / count))


def _groups(clusters: Clusters, search: LineSearch) -> list[NDArray[np.intp]]:
    """Put clusters on one line together, the largest first."""
    k = len(clusters)
    count = clusters.size.astype(float)
    axes = _axes(count, clusters.scatter) if k else _Axes(*np.empty((3, 0)))
    reach = axes.half[:, None] * axes.along if k else np.empty((0, 2))
    ends = np.stack([clusters.mean - reach, clusters.mean + reach], axis=1)  # (k, 2, 2)
    free = np.ones(k, dtype=np.bool_)
    groups: list[NDArray[np.intp]] = []
    for seed in np.argsort(-count, kind="stable"):
        if not free[seed] or len(groups) == _MOST_LINES:
            continue
        group = np.array([seed])
        for _ in range(_ROUNDS):
            weight, mean, scatter = _pooled(clusters, group)
            line = _axes(weight, scatter)
            off = np.abs((ends - mean) @ line.normal[0]).max(axis=1)
            joined = np.flatnonzero(free & (off <= search.merge))
            joined = np.union1d(joined, [seed])
            if np.array_equal(joined, group):
                break
            group = joined
        free[group] = False
        groups.append(group)
    return groups


def _pooled(clusters: Clusters, group: NDArray[np.intp]) -> tuple[Array, Array, Array]:
    """Return number, mean and scatter of several clusters' points."""
    count = clusters.size[group].astype(float)
    total = count.sum()
    mean = count @ clusters.mean[group] / total
    x, y = (clusters.mean[group] - mean).T
    between = np.array([count @ (x * x), count @ (x * y), count @ (y * y)])
    return np.array([total]), mean, (clusters.scatter[group].sum(axis=0) + between)[None, :]


def _fitted(
    points: Points, lidar: Lidar, search: LineSearch, group: NDArray[np.intp], clusters: Clusters
) -> WallLine | None:
    """Fit a line to all points near it between its ends; None if it is no wall."""
    weight, mean, scatter = _pooled(clusters, group)
    axes = _axes(weight, scatter)
    normal, along = axes.normal[0], axes.along[0]
    parts = [clusters.members[clusters.first[i] : clusters.first[i] + clusters.size[i]] for i in group]
    members = np.concatenate(parts)
    offset = float(normal @ mean)
    position = points.xy @ along
    low, high = position[members].min(), position[members].max()
    if weight[0] < search.least_points // 2 or high - low < 0.5 * search.least_length:
        return None
    between = np.flatnonzero((position >= low - search.clustering.reach) & (position <= high + search.clustering.reach))
    xy, ray, far = points.xy[between], points.ray[between], points.distance[between]
    most = max(search.merge, search.outlier * lidar.sigma)
    scale = math.inf  # the first line is rough: every near point counts
    for _ in range(_ROUNDS):
        noise = _noise(ray, far, normal, along, lidar)
        good = np.abs(xy @ normal - offset) <= np.minimum(search.outlier * scale * noise, most)
        if np.count_nonzero(good) < search.least_points:
            return None
        line = _weighted(xy[good], 1.0 / noise[good] ** 2, normal)
        normal, along, offset = line.normal, line.along, line.offset
        ratio = (xy[good] @ normal - offset) / noise[good]
        scale = max(1.0, math.sqrt(ratio @ ratio / max(len(ratio) - 2, 1)))
    own = xy[good]
    way = np.sort(own @ along)
    if way[-1] - way[0] < search.least_length or len(own) < search.least_points:
        return None
    return _line(own, ray[good], 1.0 / noise[good] ** 2, line, scale, (way[0], way[-1]))


def _line(xy: Array, ray: Array, weight: Array, line: _Weighted, scale: float, ends: tuple[float, float]) -> WallLine:
    """Turn the normal away from the lidar."""
    sign = -1.0 if line.offset < 0 else 1.0
    flip = np.array([1.0, sign])
    foot = line.offset * line.normal
    off = xy @ line.normal - line.offset
    # A bias moves each point by how steeply it is seen, which differs along the line.
    steep, place = ray @ line.normal, xy @ line.along + line.lever
    turned = line.turn * (weight @ (place * steep))
    moved = weight @ steep / weight.sum() + line.lever * turned
    return WallLine(
        angle=math.atan2(sign * line.normal[1], sign * line.normal[0]),
        distance=sign * line.offset,
        covariance=scale**2 * line.covariance * np.outer(flip, flip),
        variance=float(off @ off / max(len(off) - 2, 1)),
        points=len(xy),
        ends=np.array([foot + ends[0] * line.along, foot + ends[1] * line.along]),
        per_bias=flip * np.array([turned, moved]),
    )


def _noise(ray: Array, far: Array, normal: Array, along: Array, lidar: Lidar) -> Array:
    """(n,) m, sigma of each point across the line."""
    steep = np.maximum(np.abs(ray @ normal), _LEAST_STEEPNESS)
    across = far * lidar.angle_sigma * (ray @ along)
    return np.sqrt((lidar.sigma * steep) ** 2 + across**2)


class _Weighted(NamedTuple):
    """A line through weighted points."""

    normal: Array  # (2,)
    along: Array  # (2,)
    offset: float  # m
    lever: float  # m: the offset per radian that the normal turns
    turn: float  # rad^2, variance of its angle
    covariance: Array  # (2, 2) of angle and offset, for noise of the weights' size


def _weighted(xy: Array, weight: Array, like: Array) -> _Weighted:
    """Fit a line; its normal is on the side of ``like``."""
    total = weight.sum()
    mean = weight @ xy / total
    x, y = (xy - mean).T
    xx, cross, yy = weight @ (x * x), weight @ (x * y), weight @ (y * y)
    angle = 0.5 * math.atan2(2.0 * cross, xx - yy)
    along = np.array([math.cos(angle), math.sin(angle)])
    normal = np.array([-along[1], along[0]])
    if normal @ like < 0:
        normal, along = -normal, -along
    turn = float(1.0 / max(0.5 * (xx + yy + math.hypot(xx - yy, 2.0 * cross)), 1e-300))
    # n(angle) p = offset holds at the mean: the offset turns by where the mean is along the line.
    lever = float(-(along @ mean))
    covariance = np.array([[turn, lever * turn], [lever * turn, 1.0 / total + lever**2 * turn]])
    return _Weighted(normal, along, float(normal @ mean), lever, turn, covariance)
