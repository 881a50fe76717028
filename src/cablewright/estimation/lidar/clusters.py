"""Clusters of a scan's points: by how near successive points are, and by how well three of them are aligned."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.lidar.scan import Points
from cablewright.kernels.fitting.scan_lines import SUMS, cut

__all__ = ["Clustering", "Clusters", "clusters_of"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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
    sums: Array  # (k, SUMS): means, ends and scatters

    def __len__(self) -> int:
        return len(self.first)


def clusters_of(points: Points, sigma: float, settings: Clustering) -> Clusters:
    """Cut a scan into clusters. ``sigma``: m, of one range."""
    n, c = len(points), settings
    rules = np.array([sigma, c.grazing, c.skip, c.reach, c.alignment, c.least_points], np.float64)
    work, marks, sums = np.empty((4, n)), np.empty((5, n), np.int64), np.empty((n // 2, SUMS))
    members, first, size = marks[2:]
    k = cut(points.xy, points.distance, points.step, rules, work, marks[:2], members, first, size, sums)
    return Clusters(members, first[:k], size[:k], sums[:k])
