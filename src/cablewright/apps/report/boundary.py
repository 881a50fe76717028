"""The boundary of a workspace as faces: one corner in each cell that it passes, one face for each edge that it cuts."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.workspace.boundary_limits import BoundaryLimits

__all__ = ["faces"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_MAX_NODES: Final = 45  # along one side: finer than that no picture shows


def faces(found: BoundaryLimits) -> Array:
    """Return the boundary as faces (F, 4, 3), m. Every k-th node is taken where there are many."""
    kept = [_some(len(axis)) for axis in found.nodes.axes]
    axes = [axis[index] for axis, index in zip(found.nodes.axes, kept, strict=True)]
    inside = np.pad(found.nodes.inside[np.ix_(*kept)], 1)
    corners = _corners(found, axes, inside)
    quads = []
    for axis in range(3):
        # An edge between nodes i and i + 1 along one axis is shared by four cells, which the other two axes tell apart.
        cut = np.moveaxis(inside, axis, 0)
        cells = np.moveaxis(corners, axis, 0)
        i, j, k = np.nonzero(cut[1:] != cut[:-1])
        quads.append(np.stack([cells[i, j - 1, k - 1], cells[i, j, k - 1], cells[i, j, k], cells[i, j - 1, k]], axis=1))
    return np.concatenate(quads)


def _some(count: int) -> NDArray[np.int64]:
    stride = -(-count // _MAX_NODES)
    return np.unique(np.append(np.arange(0, count, stride), count - 1))


def _corners(found: BoundaryLimits, axes: list[Array], inside: Flags) -> Array:
    """Return a point (X, Y, Z, 3) for each cell of the padded grid: the mean of its boundary points, else of cut edges.

    The padding holds the cells beyond the frame, whose points are nodes on its sides.
    """
    shape = tuple(size - 1 for size in inside.shape)
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    framed = np.array([name == "frame" for name in found.limits], dtype=bool)[found.ended_by]
    for side in range(8):
        cell, touched = _cells(axes, found.points, [side & 1, side >> 1 & 1, side >> 2 & 1])
        beyond = ((cell == 0) | (cell == np.array(shape) - 1)).any(axis=1)
        used = touched & (beyond | ~framed)
        np.add.at(total, tuple(cell[used].T), found.points[used])
        np.add.at(count, tuple(cell[used].T), 1.0)
    rough = _rough_corners(axes, inside)
    return np.where(count[..., None] > 0, total / np.maximum(count, 1.0)[..., None], rough)


def _cells(axes: list[Array], points: Array, upper: list[int]) -> tuple[NDArray[np.int64], Flags]:
    """Return the cells (E, 3) that points touch on their lower or *upper* side, and whether that is another cell."""
    cells, touched = np.empty((len(points), 3), dtype=np.int64), np.ones(len(points), dtype=bool)
    for axis, (nodes, up) in enumerate(zip(axes, upper, strict=True)):
        slack = 1e-6 * (nodes[1] - nodes[0])
        # Cell c of the padded grid lies between the nodes c - 1 and c.
        below = np.searchsorted(nodes, points[:, axis] - slack)
        above = np.searchsorted(nodes, points[:, axis] + slack)
        cells[:, axis] = above if up else below
        touched &= (above != below) | (not up)
    return cells, touched


def _rough_corners(axes: list[Array], inside: Flags) -> Array:
    """Return the mean of the middles of the cut edges (X, Y, Z, 3) of each cell; its lowest node where none is cut."""
    padded = [np.concatenate([axis[:1], axis, axis[-1:]]) for axis in axes]
    nodes = np.stack(np.meshgrid(*padded, indexing="ij"), axis=-1)
    shape = tuple(size - 1 for size in inside.shape)
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    for axis in range(3):
        place, held = np.moveaxis(nodes, axis, 0), np.moveaxis(inside, axis, 0)
        cut, middle = held[1:] != held[:-1], 0.5 * (place[1:] + place[:-1])
        sums, counts = np.moveaxis(total, axis, 0), np.moveaxis(count, axis, 0)
        for j in (slice(None, -1), slice(1, None)):
            for k in (slice(None, -1), slice(1, None)):
                sums += np.where(cut[:, j, k, None], middle[:, j, k], 0.0)
                counts += cut[:, j, k]
    lowest = nodes[:-1, :-1, :-1]
    return np.where(count[..., None] > 0, total / np.maximum(count, 1.0)[..., None], lowest)
