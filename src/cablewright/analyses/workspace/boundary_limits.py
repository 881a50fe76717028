"""The limits of the hardware that bound the static workspace.

Paty 2021, section 4.1: tension limits, swing and elevation of the sheaves, no collision in them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from cablewright.analyses.workspace.criterion import BLOCK, Criterion
from cablewright.analyses.workspace.marching import surface_between
from cablewright.analyses.workspace.workspace import NodeCount
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.triangle_mesh import TriangleMesh

Point = tuple[float, float, float]

CLOSE = 1e-3  # m; tolerance of the bisection for boundary points
MAX_NODES = 32  # along one side, in `BoundaryLimits.surface`: a picture shows no finer detail


@dataclass(frozen=True)
class EndingLimit:
    """A limit that ends the workspace: its number of boundary points, and their lowest and highest height, m."""

    limit: str
    ends: int
    lowest: Point
    highest: Point


@dataclass(frozen=True, eq=False)
class BoundaryLimits:
    """Points on the boundary of a static workspace, and the limit that is violated beyond each.

    Points lie between neighbouring nodes of the grid, one inside and one outside. Nodes that are inside and on a side
    of the box are points too; their limit is ``frame``, the last of `limits`.
    """

    nodes: NodeCount
    points: Array  # (E, 3) m, accurate to CLOSE
    ended_by: NDArray[np.int64]  # (E,) index into `limits`
    limits: tuple[str, ...]

    @property
    def by_limit(self) -> tuple[EndingLimit, ...]:
        """Each limit that bounds the workspace somewhere, the most frequent first."""
        counts = np.bincount(self.ended_by, minlength=len(self.limits))
        order = [int(limit) for limit in np.argsort(-counts, kind="stable") if counts[limit]]
        return tuple(self._ending(limit) for limit in order)

    def surface(self) -> TriangleMesh:
        """Return the boundary as a closed mesh, m, for display: of every k-th node where there are more than MAX_NODES.

        Between two nodes it is interpolated by their distances from the plane through the boundary points next to them.
        """
        kept = [np.unique(np.append(np.arange(0, n, -(-n // MAX_NODES)), n - 1)) for n in self.nodes.inside.shape]
        axes = [axis[rows] for axis, rows in zip(self.nodes.axes, kept, strict=True)]
        return surface_between(axes, self.nodes.inside[np.ix_(*kept)], self._distances()[np.ix_(*kept)])

    def _distances(self) -> Array:
        """Approximate distance of each node from the boundary, m, (X, Y, Z)."""
        inside, low = self.nodes.inside, self.nodes.box.low
        step = (self.nodes.box.high - low) / (np.array(inside.shape) - 1)
        steepness = np.zeros(inside.shape)  # sum of 1/t^2 over the boundary points at t along x, y, z: 1/distance^2
        for ends in _pairs(self.nodes):
            away = np.linalg.norm(self.points[: len(ends)] - ends, axis=1)
            np.add.at(steepness, tuple(np.rint((ends - low) / step).astype(int).T), 1.0 / np.maximum(away, CLOSE) ** 2)
        far = distance_transform_edt(inside, step) + distance_transform_edt(~inside, step)
        return np.where(steepness > 0.0, 1.0 / np.sqrt(np.maximum(steepness, 1e-300)), far)

    def _ending(self, limit: int) -> EndingLimit:
        own = self.points[self.ended_by == limit]
        (x, y, z), (a, b, c) = own[own[:, 2].argmin()].tolist(), own[own[:, 2].argmax()].tolist()
        return EndingLimit(self.limits[limit], len(own), (x, y, z), (a, b, c))


def boundary_limits(nodes: NodeCount) -> BoundaryLimits:
    """Find the boundary points of the workspace *nodes*, counted by the criterion ``static``, and the limits there.

    Between neighbours of which one is inside, bisection finds the boundary to CLOSE. The limit is the first, in the
    order of `limits`, that the point just outside violates. Raises `InputError` for another criterion.
    """
    if nodes.criterion.name != "static":
        raise InputError(f"criterion {nodes.criterion.name}: only the criterion static reports which limit is violated")
    if not nodes.counted:
        return BoundaryLimits(nodes, np.empty((0, 3)), np.empty(0, dtype=np.int64), ())
    inner, outer = _bisected(nodes.criterion, *_pairs(nodes))
    limits, ended_by = _first_broken(nodes.criterion, outer)
    on_sides = np.ones_like(nodes.inside)
    on_sides[1:-1, 1:-1, 1:-1] = False
    sides = nodes.places[on_sides[nodes.inside]]
    ended_by = np.append(ended_by, np.full(len(sides), len(limits)))
    return BoundaryLimits(nodes, np.concatenate([inner, sides]), ended_by, (*limits, "frame"))


def _pairs(nodes: NodeCount) -> tuple[Array, Array]:
    """Pairs of neighbouring nodes of which one is inside: the points (E, 3) inside and those outside, m."""
    places = nodes.box.grid(nodes.inside.shape)
    within, without = [np.empty((0, 3))], [np.empty((0, 3))]
    for axis in range(3):
        along, inside = np.moveaxis(places, axis, 0), np.moveaxis(nodes.inside, axis, 0)
        last, first = inside[:-1] & ~inside[1:], inside[1:] & ~inside[:-1]
        within += [along[:-1][last], along[1:][first]]
        without += [along[1:][last], along[:-1][first]]
    return np.concatenate(within), np.concatenate(without)


def _bisected(criterion: Criterion, inner: Array, outer: Array) -> tuple[Array, Array]:
    """Points (E, 3) inside and outside, at most CLOSE apart, between *inner* and *outer* ones, m."""
    longest = float(np.linalg.norm(outer - inner, axis=1).max(initial=CLOSE))
    for _ in range(max(1, int(np.ceil(np.log2(longest / CLOSE))))):
        middle = 0.5 * (inner + outer)
        good = (criterion.margin(middle) >= 0.0)[:, None]
        inner, outer = np.where(good, middle, inner), np.where(good, outer, middle)
    return inner, outer


def _first_broken(criterion: Criterion, places: Array) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """Names of the limits, and the index (N,) of the first that *places* (N, 3) violate under any orientation."""
    names: tuple[str, ...] = ()
    first = []
    for block in np.array_split(places, 1 + len(places) // BLOCK):
        each = [criterion.broken_limits(criterion.poses(block, turn)) for turn in criterion.orientations]
        names = each[0][0]
        first.append(np.any([broken for _, broken in each], axis=0).argmax(axis=1))
    return names, np.concatenate(first)
