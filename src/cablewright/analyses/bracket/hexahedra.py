"""Hexahedral meshes of plates and blocks with bores, for finite elements.

The mesh is built on a *logical* grid, in which each element is a box and a bore a square hole. Regions are selected on
the logical grid; then the nodes of the second-order mesh are moved, so that the middles of edges lie on the bores too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask

if TYPE_CHECKING:
    from skfem import Basis, MeshHex2

Index = NDArray[np.int64]

_NEAR = 1e-9  # m; positions closer than this coincide
_APART = 0.02  # of the largest element: smallest distance of an optional plane from a required one


@dataclass(frozen=True)
class Bore:
    """A bore along an *axis* of the grid, around *centre* in the other two coordinates.

    Only the square with half side *room* around it is deformed; the logical hole has the half side `half`.
    """

    axis: int
    centre: tuple[float, float]
    radius: float
    room: float

    @property
    def half(self) -> float:
        """Half side of the logical hole, whose corners are not moved."""
        return self.radius / math.sqrt(2.0)

    @property
    def across(self) -> list[int]:
        """Indices of the two coordinates across the bore's axis."""
        return [k for k in range(3) if k != self.axis]

    def marks(self, k: int) -> list[float]:
        """Return the planes that the grid needs along the *k*-th coordinate across."""
        c = self.centre[k]
        return [c - self.room, c - self.half, c + self.half, c + self.room]

    def bend(self, points: Array) -> None:
        """Move logical *points* (3, N) in place: those on the square hole are moved to the circle."""
        u, v = (points[k] - c for k, c in zip(self.across, self.centre, strict=True))
        swap = np.abs(u) > np.abs(v)
        along, out = np.where(swap, v, u), np.where(swap, u, v)  # out: the coordinate farther from the centre
        inside = (np.abs(out) < self.room - _NEAR) & (np.abs(out) > self.half - _NEAR)
        side = inside & (np.abs(along) <= self.half + _NEAR)
        a, b, r = self.half, self.room, self.radius
        t = np.clip((np.abs(out) - a) / (b - a), 0.0, 1.0)
        angle = 0.25 * np.pi * np.clip(along / a, -1.0, 1.0)
        bent_along = np.where(side, (1.0 - t) * r * np.sin(angle) + t * along, along)
        bent_out = np.where(side, np.sign(out) * ((1.0 - t) * r * np.cos(angle) + t * b), out)
        points[self.across[0]] = self.centre[0] + np.where(swap, bent_out, bent_along)
        points[self.across[1]] = self.centre[1] + np.where(swap, bent_along, bent_out)


@dataclass(frozen=True, eq=False)
class HexMesh:
    """A mesh of hexahedra with 20 nodes, and the positions of its parts on the logical grid.

    `basis` has the N corners and middles of edges, at which displacements are solved. `points` has these first, then
    the middles of faces and elements, P in all, at which stress is recovered. `nodes` (3, P), `facets` (3, F) and
    `cells` (3, E) are positions on the logical grid, m.
    """

    mesh: MeshHex2
    basis: Basis
    points: Basis
    nodes: Array
    facets: Array
    cells: Array

    @property
    def places(self) -> Array:
        """Positions (3, P) of the mesh's points, m."""
        return np.asarray(self.points.doflocs)

    def boundary(self, chosen: Callable[[Array], Mask]) -> Index:
        """Return the boundary facets whose logical middles (3, F) are *chosen*."""
        own = self.mesh.boundary_facets()
        return np.asarray(own[chosen(self.facets[:, own])])


def levels(values: Array) -> Index:
    """Return the rank (n,) of each of *values* (n,) among the distinct ones; values within rounding count as equal."""
    order = np.argsort(values, kind="stable")
    found = np.empty(len(values), dtype=np.int64)
    found[order] = np.cumsum(np.diff(values[order], prepend=values[order[:1]]) > _NEAR)
    return found


def ticks(marks: Sequence[float], size: float, times: int, finer: Sequence[float] = ()) -> Array:
    """Return rising grid planes at all *marks* (m), with others between, no further than *size* apart, times *times*.

    *finer* are optional marks, left out where they nearly coincide with one of *marks*. Between marks planes are evenly
    spaced, so that meshes with different *times* are refinements of one.
    """
    needed = np.asarray(marks)
    more = [mark for mark in finer if np.abs(needed - mark).min() > _APART * size]
    ends = np.unique(np.round(np.append(needed, more) / _NEAR) * _NEAR)
    counts = np.maximum(1, np.ceil(np.diff(ends) / size - 1e-6).astype(np.int64)) * times
    pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], counts, strict=True)]
    return np.append(np.concatenate(pieces), ends[-1])


def build(planes: Sequence[Array], kept: Callable[[Array], Mask], bores: Sequence[Bore]) -> HexMesh:
    """Mesh the cells whose middles (3, E) are *kept*, without the *bores*, between *planes* along x, y and z, m."""
    from skfem import Basis, MeshHex, MeshHex2
    from skfem.element import ElementHex2, ElementHexS2

    whole = MeshHex.init_tensor(*planes)
    middles = whole.p[:, whole.t].mean(axis=1)
    stays = kept(middles)
    for bore in bores:
        u, v = (np.abs(middles[k] - c) for k, c in zip(bore.across, bore.centre, strict=True))
        stays &= np.maximum(u, v) > bore.half
    logical = MeshHex2.from_mesh(whole.remove_elements(np.flatnonzero(~stays)))
    nodes = np.array(logical.doflocs)
    facets = logical.p[:, logical.facets].mean(axis=1)
    cells = logical.p[:, logical.t].mean(axis=1)
    moved = np.array(logical.doflocs)
    for bore in bores:
        bore.bend(moved)
    points = Basis(logical, ElementHex2(), intorder=2)
    _serendipity(moved, np.asarray(points.element_dofs))
    mesh = MeshHex2(moved, logical.t)
    shapes = Basis(mesh, ElementHexS2(), intorder=4)
    return HexMesh(mesh, shapes, Basis(mesh, ElementHex2(), intorder=4), nodes, facets, cells)


def _serendipity(places: Array, members: Index) -> None:
    """Move the middles of faces and elements (in place) to where the 20 other nodes map them.

    scikit-fem stores second-order meshes with 27 nodes; this makes them equal to elements with 20 nodes, which
    reproduce a uniform strain. *members* (27, E): the nodes of each element.
    """
    from skfem.element import ElementHex2, ElementHexS2

    element, inner = ElementHexS2(), ElementHex2.doflocs[20:].T
    shares = np.stack([element.lbasis(inner, a)[0] for a in range(20)])  # (20, 7)
    middles = np.einsum("ap,cae->cpe", shares, places[:, members[:20]])
    places[:, members[20:]] = middles
