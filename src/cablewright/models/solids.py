"""Parts as kernels take them: beads or triangles in a tree of boxes, each there from its birth on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.kernels.collision.clearance import BEADS, PIECE, TRIANGLES, PartTree
from cablewright.printing.deposit import Deposit
from cablewright.triangle_mesh import TriangleMesh

_LEAF: Final = 2  # pieces of a leaf at most: 1 and 8 are slower (benchmarks/interference.py)


@dataclass(frozen=True, eq=False)
class Obstacle:
    """What lines may touch besides the machine. `whole` is the time at which all of it is there.

    `order` (P,): which bead or triangle each piece of the solid is, as they were given.
    """

    solid: PartTree
    order: NDArray[np.int64]
    whole: float

    @property
    def noun(self) -> str:
        """What it is made of."""
        return "bead" if self.solid.kind == BEADS else "triangle"


def nothing() -> Obstacle:
    """A part of no pieces."""
    none = np.empty((0, PIECE))
    return Obstacle(
        _planted(BEADS, none, np.empty(0), np.empty((0, 3)), np.empty((0, 3)))[0], np.empty(0, np.int64), 0.0
    )


def of_beads(deposit: Deposit) -> Obstacle:
    """The strands of a deposit; time counts its samples."""
    a, b, half = deposit.along, deposit.across, deposit.half
    reach = np.abs(a) * half[:, :1] + np.abs(b) * half[:, 1:2] + np.abs(np.cross(a, b)) * half[:, 2:]
    pieces = np.concatenate([deposit.centre, a, b, half], axis=1)
    births = deposit.sample.astype(np.float64)
    solid, order = _planted(BEADS, pieces, births, deposit.centre - reach, deposit.centre + reach)
    return Obstacle(solid, order, float(births.max(initial=0.0)))


def of_mesh(mesh: TriangleMesh) -> Obstacle:
    """The triangles of a mesh; time is the height (m) up to which they are there."""
    corners = mesh.corners
    low, high = corners.min(axis=1), corners.max(axis=1)
    pieces = np.zeros((len(low), PIECE))
    pieces[:, :9] = corners.reshape(-1, 9)
    solid, order = _planted(TRIANGLES, pieces, low[:, 2], low, high)
    return Obstacle(solid, order, float(high[:, 2].max()))


def _planted(kind: int, pieces: Array, births: Array, low: Array, high: Array) -> tuple[PartTree, NDArray[np.int64]]:
    """A solid of pieces within their bounds (P, 3), and the order in which it has them.

    Level by level, each node's pieces are sorted along the longest side of the box about their middles and halved.
    """
    count = len(pieces)
    levels = max(0, int(np.ceil(np.log2(max(count, 1) / _LEAF))))
    order, middle = np.arange(count), 0.5 * (low + high)
    for level in range(levels):
        starts = np.arange(1 << level) * count >> level
        node = np.repeat(np.arange(1 << level), np.diff(np.append(starts, count)))
        own = middle[order]
        extent = np.maximum.reduceat(own, starts) - np.minimum.reduceat(own, starts)
        order = order[np.lexsort((own[np.arange(count), extent.argmax(axis=1)[node]], node))]
    leaves = 1 << levels
    ranges = (np.arange(leaves + 1) * count >> levels).astype(np.int64)
    boxes, since = np.zeros((2 * leaves - 1, 6)), np.full(2 * leaves - 1, np.inf)
    if count:
        lows, highs = np.empty((2 * leaves - 1, 3)), np.empty((2 * leaves - 1, 3))
        lows[leaves - 1 :] = np.minimum.reduceat(low[order], ranges[:-1])
        highs[leaves - 1 :] = np.maximum.reduceat(high[order], ranges[:-1])
        since[leaves - 1 :] = np.minimum.reduceat(births[order], ranges[:-1])
        for level in reversed(range(levels)):
            nodes = slice((1 << level) - 1, (2 << level) - 1)
            pairs = slice((2 << level) - 1, (4 << level) - 1)
            lows[nodes] = lows[pairs].reshape(-1, 2, 3).min(axis=1)
            highs[nodes] = highs[pairs].reshape(-1, 2, 3).max(axis=1)
            since[nodes] = since[pairs].reshape(-1, 2).min(axis=1)
        boxes = np.concatenate([0.5 * (lows + highs), 0.5 * (highs - lows)], axis=1)
    return PartTree(kind, np.ascontiguousarray(pieces[order]), births[order], boxes, since, ranges), order
