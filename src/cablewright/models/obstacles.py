"""Obstacles for the distance kernels: beads or triangles in a tree of boxes, each with the time when it appears."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.kernels.collision.clearance import BEADS, PIECE, TRIANGLES, PartTree
from cablewright.printing.growing_part import Deposit

_LEAF: Final = 2  # maximum pieces per leaf; 1 and 8 are slower (benchmarks/interference.py)


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A part that lines may touch. `whole`: time from which on all of it exists.

    `order` (P,): index of each piece of the solid in the given beads or triangles.
    """

    solid: PartTree
    order: NDArray[np.int64]
    whole: float

    @property
    def noun(self) -> str:
        """Word for the pieces of the obstacle, as "bead"."""
        return "bead" if self.solid.kind == BEADS else "triangle"


def nothing() -> Obstacle:
    """Return an obstacle without any shape."""
    return _obstacle(
        BEADS, lambda rows: np.empty((len(rows), PIECE)), np.empty(0), _Bounds.empty(0, MEMORY), 0.0, MEMORY
    )


def of_beads(deposit: Deposit, room: Room = MEMORY) -> Obstacle:
    """Return the strands of a deposit as an obstacle; the time is the number of the sample.

    *room*: folder for their arrays.
    """

    def pieces(rows: Indices) -> Array:
        taken = [column[rows] for column in (deposit.centre, deposit.along, deposit.across, deposit.half)]
        let_go(deposit)
        return np.concatenate(taken, axis=1)

    bounds = _Bounds.empty(len(deposit), room)
    for at in blocks(len(deposit)):
        a, b, half, centre = deposit.along[at], deposit.across[at], deposit.half[at], deposit.centre[at]
        reach = np.abs(a) * half[:, :1] + np.abs(b) * half[:, 1:2] + np.abs(np.cross(a, b)) * half[:, 2:]
        bounds.low[at], bounds.high[at] = centre - reach, centre + reach
        let_go((deposit, bounds))
    births = deposit.sample.astype(np.float64)
    return _obstacle(BEADS, pieces, births, bounds, float(births.max(initial=0.0)), room)


def of_mesh(mesh: TriangleMesh) -> Obstacle:
    """Return the triangles of a mesh as an obstacle; the time is the height (m) up to which the part exists."""
    corners = mesh.corners
    bounds = _Bounds(corners.min(axis=1), corners.max(axis=1))
    pieces = np.zeros((len(corners), PIECE))
    pieces[:, :9] = corners.reshape(-1, 9)
    whole = float(bounds.high[:, 2].max())
    return _obstacle(TRIANGLES, pieces.__getitem__, bounds.low[:, 2], bounds, whole, MEMORY)


class _Bounds(NamedTuple):
    """Lowest and highest corners (P, 3) of pieces, m."""

    low: Array
    high: Array

    @classmethod
    def empty(cls, count: int, room: Room) -> Self:
        return cls(room.empty((count, 3)), room.empty((count, 3)))


def _obstacle(
    kind: int, pieces: Callable[[Indices], Array], births: Array, bounds: _Bounds, whole: float, room: Room
) -> Obstacle:
    """Return the tree of *pieces*, which says those of some rows, with their *births* (P,) and *bounds*.

    Level by level, each node's pieces are sorted along the longest side of the box of their centres and halved.
    """
    count = len(births)
    levels = max(0, int(np.ceil(np.log2(max(count, 1) / _LEAF))))
    order, middle = np.arange(count), 0.5 * (bounds.low + bounds.high)
    boxes, since = room.empty(((2 << levels) - 1, 6)), room.empty(((2 << levels) - 1,))
    boxes[:], since[:] = 0.0, np.inf
    for level in range(levels + 1 if count else 0):
        nodes = slice((1 << level) - 1, (2 << level) - 1)
        starts = np.arange(1 << level) * count >> level
        lowest = np.minimum.reduceat(bounds.low[order], starts)
        highest = np.maximum.reduceat(bounds.high[order], starts)
        boxes[nodes] = np.concatenate([0.5 * (lowest + highest), 0.5 * (highest - lowest)], axis=1)
        since[nodes] = np.minimum.reduceat(births[order], starts)
        let_go((bounds, boxes, since))
        if level < levels:
            node = np.repeat(np.arange(1 << level), np.diff(np.append(starts, count)))
            own = middle[order]
            extent = np.maximum.reduceat(own, starts) - np.minimum.reduceat(own, starts)
            order = order[np.lexsort((own[np.arange(count), extent.argmax(axis=1)[node]], node))]
    ranges = (np.arange((1 << levels) + 1) * count >> levels).astype(np.int64)
    ordered = room.empty((count, PIECE))
    for at in blocks(count):
        ordered[at] = pieces(order[at])
        let_go(ordered)
    return Obstacle(PartTree(kind, ordered, births[order], boxes, since, ranges), order, whole)
