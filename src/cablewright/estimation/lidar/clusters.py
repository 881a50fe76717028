"""Clusters of a scan's points: by the distance of successive points, and by the alignment of three."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.estimation.lidar.scan import Points
from cablewright.kernels.fitting.scan_lines import SUMS, cut

Index = NDArray[np.int64]


@dataclass(frozen=True)
class Clustering:
    """When points belong to one cluster.

    ``min_incidence``: rad, smallest angle between ray and wall at which the next point of a wall is expected.
    ``max_missing``: rays without an echo between two points of a cluster. ``reach``: m, distance to the two outer ones
    of three aligned points: noise hides a corner between successive points of a near wall. ``alignment``: m, distance
    of the middle point from the line of the outer two, besides three sigma of noise. ``min_points``: of a cluster.
    """

    min_incidence: float = math.radians(10.0)
    max_missing: int = 4
    reach: float = 0.12
    alignment: float = 4e-3
    min_points: int = 5


class Clusters(NamedTuple):
    """k clusters with their sums; points of cluster i are ``members[first[i]:first[i] + size[i]]``."""

    members: Index
    first: Index  # (k,)
    size: Index  # (k,)
    sums: Array  # (k, SUMS): means, ends and scatters

    def __len__(self) -> int:
        return len(self.first)


def find_clusters(points: Points, sigma: float, settings: Clustering) -> Clusters:
    """Cut a scan into clusters. ``sigma``: m, of one range."""
    n, c = len(points), settings
    rules = np.array([sigma, c.min_incidence, c.max_missing, c.reach, c.alignment, c.min_points], np.float64)
    work, marks, sums = np.empty((4, n)), np.empty((5, n), np.int64), np.empty((n // 2, SUMS))
    members, first, size = marks[2:]
    k = cut(points.xy, points.distance, points.bearing_step, rules, work, marks[:2], members, first, size, sums)
    return Clusters(members, first[:k], size[:k], sums[:k])
