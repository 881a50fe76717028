"""Clusters of a scan's points: by how near successive points are, and by how well three of them are aligned."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.scan import Points

__all__ = ["Clustering", "Clusters", "clusters_of"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_CLEAR_OF_NOISE = 5.0  # sigmas apart from which points tell how far it is from one to the next


@dataclass(frozen=True)
class Clustering:
    """When points belong together.

    ``grazing``: rad, the flattest angle between ray and wall at which the next point of a wall is still expected.
    ``skip``: rays without an echo that may lie between two points of a cluster. ``reach``: m, how far before and after
    a point the two others of three aligned points are looked for: successive points of a near wall are nearer to each
    other than their noise allows to tell a corner by. ``alignment``: m, by how much a point may be beside the line of
    the other two, besides three sigma of its noise. ``least_points``: of a cluster.
    """

    grazing: float = math.radians(10.0)
    skip: int = 4
    reach: float = 0.12
    alignment: float = 4e-3
    least_points: int = 5


class Clusters(NamedTuple):
    """k clusters with their sums; points of cluster i are ``members[first[i]:first[i] + size[i]]``."""

    members: Index
    first: Index  # (k,)
    size: Index  # (k,)
    mean: Array  # (k, 2) m
    scatter: Array  # (k, 3) m^2, sums of xx, xy, yy about the mean

    def __len__(self) -> int:
        return len(self.first)


def clusters_of(points: Points, sigma: float, settings: Clustering) -> Clusters:
    """Cut a scan into clusters. ``sigma``: m, of one range."""
    keep = _without_strays(points, sigma, settings)
    xy = points.xy[keep]
    n = len(keep)
    if n < settings.least_points:
        return _summed(xy, keep, np.empty(0, np.intp), np.empty(0, np.intp))
    bearing = np.concatenate([[0.0], np.cumsum(points.step)])[keep]
    gap = np.hypot(*np.diff(xy, axis=0).T)
    near = gap <= _expected(points.distance[keep], np.diff(bearing), _usual(points.step), sigma, settings)
    way = _way(xy, gap, sigma, float(np.median(points.distance[keep])) * _usual(points.step))
    aligned = _aligned(xy, way, near, 3.0 * math.sqrt(1.5) * sigma + settings.alignment, settings.reach)
    joined = near & aligned[1:] & aligned[:-1]  # (n - 1,) point i and the next
    edges = np.flatnonzero(np.diff(np.concatenate([[False], joined, [False]]).astype(np.int8)))
    first, count = edges[::2], edges[1::2] - edges[::2] + 1
    large = count >= settings.least_points
    return _summed(xy, keep, first[large], count[large])


def _usual(step: Array) -> float:
    """Return the usual bearing between two rays."""
    return float(np.median(step)) if len(step) else 0.0


def _expected(distance: Array, step: Array, usual: float, sigma: float, settings: Clustering) -> Array:
    """Return how far apart two successive points of one wall may be, seen as flatly as allowed; -1: they are not."""
    turned = np.minimum(step, 0.5 * settings.grazing)
    # The next point of a wall at the grazing angle, by the law of sines.
    reach = np.minimum(distance[:-1], distance[1:]) * np.sin(turned) / np.sin(settings.grazing - turned)
    # Half a degree more than the usual: rays of several turns do not lie evenly.
    return np.where(step <= (settings.skip + 1) * usual + 0.01, reach + 6.0 * sigma, -1.0)


def _without_strays(points: Points, sigma: float, settings: Clustering) -> Index:
    """Return the points but those which are far from both neighbours while these are near each other."""
    everything = np.arange(len(points))
    if len(points) < 3:
        return everything
    xy, usual = points.xy, _usual(points.step)
    step = points.step[:-1]
    apart = np.hypot(*np.diff(xy, axis=0).T) > _expected(points.distance, step, usual, sigma, settings)
    over = np.hypot(*(xy[2:] - xy[:-2]).T)
    wide = step[1:] + step[:-1]
    ends = np.minimum(points.distance[2:], points.distance[:-2])
    turned = np.minimum(wide, 0.5 * settings.grazing)
    bridged = over <= ends * np.sin(turned) / np.sin(settings.grazing - turned) + 6.0 * sigma
    stray = np.zeros(len(points), dtype=np.bool_)
    stray[1:-1] = apart[1:] & apart[:-1] & bridged
    return everything[~stray]


def _way(xy: Array, gap: Array, sigma: float, usual: float) -> Array:
    """Return the way along the points (n,), m. Where they are nearer than their noise, only some of them tell it."""
    few = math.ceil(_CLEAR_OF_NOISE * sigma / max(usual, 1e-9))
    if few <= 1:
        return np.concatenate([[0.0], np.cumsum(gap)])
    at = np.append(np.arange(0, len(xy) - 1, min(few, len(xy))), len(xy) - 1)
    chords = np.hypot(*np.diff(xy[at], axis=0).T)
    way: Array = np.interp(np.arange(len(xy)), at, np.concatenate([[0.0], np.cumsum(chords)]))
    return way


def _aligned(xy: Array, way: Array, near: NDArray[np.bool_], tolerance: float, reach: float) -> NDArray[np.bool_]:
    """Say which points lie on the line of two others, one before and one after, ``reach`` away along the points."""
    n = len(xy)
    run = np.concatenate([[0], np.cumsum(~near)])  # (n,) of successive points that are near each other
    begin = np.searchsorted(run, run, side="left")
    end = np.searchsorted(run, run, side="right") - 1
    before = np.maximum(np.searchsorted(way, way - reach, side="right") - 1, begin)
    after = np.minimum(np.searchsorted(way, way + reach, side="left"), end)
    chord = xy[np.minimum(after, n - 1)] - xy[np.maximum(before, 0)]
    own = xy - xy[np.maximum(before, 0)]
    length = np.maximum(np.hypot(*chord.T), 1e-12)
    beside = np.abs(chord[:, 0] * own[:, 1] - chord[:, 1] * own[:, 0])
    inner = (before < np.arange(n)) & (after > np.arange(n))
    aligned: NDArray[np.bool_] = ~inner | (beside <= tolerance * length)
    return aligned


def _summed(xy: Array, keep: Index, first: Index, count: Index) -> Clusters:
    """Add up each cluster's points, about their mean."""
    k = len(first)
    if not k:
        return Clusters(keep[:0], first, count, np.empty((0, 2)), np.empty((0, 3)))
    owner = np.repeat(np.arange(k), count)
    starts = np.concatenate([[0], np.cumsum(count)[:-1]])
    chosen = np.arange(count.sum()) - np.repeat(starts, count) + np.repeat(first, count)
    own = xy[chosen]
    mean = np.add.reduceat(own, starts, axis=0) / count[:, None]
    off = own - mean[owner]
    products = np.stack([off[:, 0] ** 2, off[:, 0] * off[:, 1], off[:, 1] ** 2], axis=1)
    return Clusters(keep[chosen], starts, count, mean, np.add.reduceat(products, starts, axis=0))
