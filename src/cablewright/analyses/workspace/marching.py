"""The zero surface of a function on a lattice as a closed mesh, by marching tetrahedra.

A cell consists of six tetrahedra along one of its diagonals. Neighbouring cells are mirror images, so that they agree
on the diagonals of their common faces and a symmetric function has a symmetric surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.triangle_mesh import TriangleMesh

Keys = NDArray[np.int64]

BITS: Final = 18  # bits of a node's key for each of its three indices

EDGE: Final = 8  # an edge's key is that of its lowest corner times this, plus its steps along x, y, z as bits


def key_of(index: NDArray[np.int64]) -> Keys:
    """Return integer keys (...) of lattice nodes with *index* (..., 3).

    A key on a lattice twice as fine is twice as large.
    """
    return np.asarray((index[..., 0] << 2 * BITS) + (index[..., 1] << BITS) + index[..., 2])


def index_of(keys: Keys) -> NDArray[np.int64]:
    """Return the indices (..., 3) of lattice nodes from their keys."""
    mask = (1 << BITS) - 1
    return np.stack([keys >> 2 * BITS, (keys >> BITS) & mask, keys & mask], axis=-1)


_BITS_OF = np.array([[(code >> 2) & 1, (code >> 1) & 1, code & 1] for code in range(8)])  # corners 0 to 7: x, y, z
CORNERS: Final = key_of(_BITS_OF)
"""(8,) difference between a corner's key and its cell's, which is that of its lowest corner."""

FACES: Final = tuple((axis, side, np.flatnonzero(_BITS_OF[:, axis] == side)) for axis in range(3) for side in range(2))
"""Axis, side and corners of each face of a cell."""


def _tetrahedra() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners (6, 4) of the tetrahedra along the diagonal from 0 to 7, and their orientation (6,), 1 or -1."""
    found, ways = [], []
    for order in permutations((4, 2, 1)):
        found.append([0, order[0], order[0] | order[1], 7])
        ways.append(1 if order in ((4, 2, 1), (2, 1, 4), (1, 4, 2)) else -1)
    return np.array(found), np.array(ways)


def _triangles() -> list[list[tuple[tuple[int, int], ...]]]:
    """The triangles for each set of inside corners (bits), as edges (inside, outside), anticlockwise from outside."""
    even = [(0, 1, 2, 3), (1, 0, 3, 2), (2, 0, 1, 3), (3, 0, 2, 1)]
    pairs = [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1)]
    table: list[list[tuple[tuple[int, int], ...]]] = [[] for _ in range(16)]
    for i, j, k, m in even:
        table[1 << i] = [((i, j), (i, k), (i, m))]
        table[15 ^ (1 << i)] = [((j, i), (m, i), (k, i))]
    for i, j, k, m in pairs:
        table[(1 << i) | (1 << j)] = [((i, k), (i, m), (j, m)), ((i, k), (j, m), (j, k))]
    return table


TETRAHEDRA, WAYS = _tetrahedra()
TABLE = _triangles()


def crossings(cells: Keys, inside: Mask) -> tuple[Keys, Keys, Keys, NDArray[np.int64]]:
    """Return the surface in *cells* (K,), keys, whose corners are *inside* (K, 8).

    Four arrays: the keys (E,) of the crossed lattice edges, the nodes inside (E,) and outside (E,) at their ends, and
    triangles (F, 3) as indices of these edges, anticlockwise as seen from outside.
    """
    mirror = ((cells >> 2 * BITS & 1) << 2) | ((cells >> BITS & 1) << 1) | (cells & 1)  # (K,) axes that are mirrored
    flipped = np.array([0, 1, 1, 0, 1, 0, 0, 1], dtype=bool)[mirror]
    edges, within, without = [], [], []
    for corners, way in zip(TETRAHEDRA, WAYS, strict=True):
        codes = corners ^ mirror[:, None]  # (K, 4)
        flags = np.take_along_axis(inside, codes, axis=1)
        sets = flags @ np.array([1, 2, 4, 8])
        backwards = flipped ^ (way < 0)
        for chosen in range(1, 15):
            rows = np.flatnonzero(sets == chosen)
            if not len(rows):
                continue
            own, base = codes[rows], cells[rows]
            turned = backwards[rows][:, None]
            for triangle in TABLE[chosen]:
                inner, outer = (own[:, [edge[end] for edge in triangle]] for end in (0, 1))  # (R, 3) corner codes
                inner = np.where(turned, inner[:, ::-1], inner)
                outer = np.where(turned, outer[:, ::-1], outer)
                lowest = base[:, None] + CORNERS[inner & outer]
                edges.append(lowest * EDGE + (inner ^ outer))
                within.append(base[:, None] + CORNERS[inner])
                without.append(base[:, None] + CORNERS[outer])
    if not edges:
        none = np.empty(0, dtype=np.int64)
        return none, none, none, none.reshape(0, 3)
    all_edges = np.concatenate(edges)
    keys, first, numbers = np.unique(all_edges.ravel(), return_index=True, return_inverse=True)
    inner, outer = (np.concatenate(ends).ravel()[first] for ends in (within, without))
    return keys, inner, outer, numbers.reshape(-1, 3)


def surface_between(axes: Sequence[Array], inside: Mask, distances: Array) -> TriangleMesh:
    """Return the closed surface around the nodes of a grid that are *inside* (X, Y, Z), at *distances* from it, m.

    *axes*: coordinates of the nodes, m. Where nodes on the sides of the grid are inside, the surface lies on the side.
    """
    held, beside = np.pad(inside, 1), np.pad(inside, 1, mode="edge")
    cells = np.indices([n - 1 for n in held.shape]).reshape(3, -1).T
    flags = held[tuple(np.moveaxis(cells[:, None] + _BITS_OF, -1, 0))]
    mixed = flags.any(axis=1) & ~flags.all(axis=1)
    _, within, without, triangles = crossings(key_of(cells[mixed]), flags[mixed])
    inner, outer = tuple(index_of(within).T), tuple(index_of(without).T)
    far = np.pad(distances, 1, mode="edge")
    share = np.where(beside[outer], 0.5, far[inner] / (far[inner] + far[outer]))[:, None]
    padded = [np.pad(axis, 1, mode="edge") for axis in axes]
    begin, end = (np.stack([axis[at] for axis, at in zip(padded, ends, strict=True)], 1) for ends in (inner, outer))
    return TriangleMesh(begin + share * (end - begin), triangles)
