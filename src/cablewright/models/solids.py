"""Parts for the kernels: beads or triangles in a tree of boxes, each with the time from which on it exists."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.kernels.collision.clearance import BEADS, PIECE, TRIANGLES, PartTree
from cablewright.printing.deposit import Deposit
from cablewright.triangle_mesh import TriangleMesh

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
        """The word for its pieces."""
        return "bead" if self.solid.kind == BEADS else "triangle"


def nothing() -> Obstacle:
    """Return a part without pieces."""
    none = np.empty((0, PIECE))
    return Obstacle(*_tree(BEADS, none, np.empty(0), np.empty((0, 3)), np.empty((0, 3))), 0.0)


def of_beads(deposit: Deposit) -> Obstacle:
    """Return the strands of a deposit; the time is the number of the sample."""
    a, b, half = deposit.along, deposit.across, deposit.half
    reach = np.abs(a) * half[:, :1] + np.abs(b) * half[:, 1:2] + np.abs(np.cross(a, b)) * half[:, 2:]
    pieces = np.concatenate([deposit.centre, a, b, half], axis=1)
    births = deposit.sample.astype(np.float64)
    tree = _tree(BEADS, pieces, births, deposit.centre - reach, deposit.centre + reach)
    return Obstacle(*tree, float(births.max(initial=0.0)))


def of_mesh(mesh: TriangleMesh) -> Obstacle:
    """Return the triangles of a mesh; the time is the height (m) up to which the part exists."""
    corners = mesh.corners
    low, high = corners.min(axis=1), corners.max(axis=1)
    pieces = np.zeros((len(low), PIECE))
    pieces[:, :9] = corners.reshape(-1, 9)
    return Obstacle(*_tree(TRIANGLES, pieces, low[:, 2], low, high), float(high[:, 2].max()))


def _tree(kind: int, pieces: Array, births: Array, low: Array, high: Array) -> tuple[PartTree, NDArray[np.int64]]:
    """Return the tree of pieces with bounds *low* to *high* (P, 3), and the order of the pieces in it.

    Level by level, each node's pieces are sorted along the longest side of the box of their centres and halved.
    """
    count = len(pieces)
    levels = max(0, int(np.ceil(np.log2(max(count, 1) / _LEAF))))
    order, middle = np.arange(count), 0.5 * (low + high)
    boxes, since = np.zeros(((2 << levels) - 1, 6)), np.full((2 << levels) - 1, np.inf)
    for level in range(levels + 1 if count else 0):
        nodes = slice((1 << level) - 1, (2 << level) - 1)
        starts = np.arange(1 << level) * count >> level
        lowest, highest = np.minimum.reduceat(low[order], starts), np.maximum.reduceat(high[order], starts)
        boxes[nodes] = np.concatenate([0.5 * (lowest + highest), 0.5 * (highest - lowest)], axis=1)
        since[nodes] = np.minimum.reduceat(births[order], starts)
        if level < levels:
            node = np.repeat(np.arange(1 << level), np.diff(np.append(starts, count)))
            own = middle[order]
            extent = np.maximum.reduceat(own, starts) - np.minimum.reduceat(own, starts)
            order = order[np.lexsort((own[np.arange(count), extent.argmax(axis=1)[node]], node))]
    ranges = (np.arange((1 << levels) + 1) * count >> levels).astype(np.int64)
    return PartTree(kind, np.ascontiguousarray(pieces[order]), births[order], boxes, since, ranges), order
