"""Selection of few segments of a path, so that their picture resembles that of the whole path."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.memory_mapped import BLOCK, blocks, let_go
from cablewright.printing.path import Samples

_Rows = NDArray[np.integer[Any]]
_CELLS: Final = 1024  # along the plan, of the smallest places


class Pieces:
    """Straight pieces of a path between samples ``begin`` and ``end``, in order."""

    def __init__(self, begin: _Rows, end: _Rows) -> None:
        self.begin = begin
        self.end = end

    def __len__(self) -> int:
        """The number of pieces."""
        return len(self.end)


def worst_of_each_place(samples: Samples, known: _Rows, error: Array, limit: int) -> Pieces:
    """Return one segment for each place of the plan, the one with the largest error, by rising error.

    ``known`` are the samples whose segments may be shown. A place is a square as small as ``limit`` allows, and a
    segment is where its middle is.
    """
    if len(known) == 0:
        return Pieces(known, known)
    corner, extent = _box(samples, known)
    chosen, place, worst = np.zeros(0, dtype=np.intp), np.zeros((0, 2), dtype=np.int64), np.zeros(0)
    for at in blocks(len(known), 4 * BLOCK):
        rows = known[at]
        own = ((_middles(samples, rows) - corner) * (_CELLS / extent)).astype(np.int64)
        chosen, place = np.concatenate([chosen, rows]), np.concatenate([place, own])
        worst = np.concatenate([worst, error[rows]])
        kept = np.sort(_worst_of_each(place, worst))
        chosen, place, worst = chosen[kept], place[kept], worst[kept]
        let_go((samples, error))
    cells, kept = _CELLS, _worst_of_each(place, worst)
    while len(kept) > limit and cells > 2:
        cells //= 2
        kept = _worst_of_each(place // (_CELLS // cells), worst)
    return Pieces(chosen[kept] - 1, chosen[kept])


def _middles(samples: Samples, rows: _Rows) -> Array:
    """Middles (r, 2), m, in plan, of the segments that end at some samples."""
    return np.asarray((samples.positions[rows, :2] + samples.positions[rows - 1, :2]) / 2)


def _box(samples: Samples, known: _Rows) -> tuple[Array, float]:
    """Return the lowest corner (2,), m, of the middles in plan, and the longer side of their rectangle, m."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for at in blocks(len(known)):
        plan = _middles(samples, known[at])
        low, high = np.minimum(low, plan.min(axis=0)), np.maximum(high, plan.max(axis=0))
        let_go(samples.positions)
    return low, max(float((high - low).max()), 1e-9)


def _worst_of_each(place: NDArray[np.int64], error: Array) -> Indices:
    """Return the row with the largest error for each *place* (k, 2), by rising error."""
    order = np.argsort(-error, kind="stable")
    first = np.unique(place[order] @ np.array([1, 2 * _CELLS]), return_index=True)[1]
    return np.asarray(order[np.sort(first)[::-1]])


def coarse_corners(samples: Samples, known: _Rows, limit: int, span: int) -> Pieces:
    """Return at most about ``limit`` pieces of a path, each from corner to corner; whole layers are left out evenly.

    ``known`` are the samples whose segments may be shown. The first and the last layer are always shown. A straight
    move is cut every ``span`` samples, so that colour still changes along the move.
    """
    pieces = _corner_to_corner(samples, known, span)
    if len(pieces) <= limit:
        return pieces
    numbers, inverse = np.unique(samples.layer[pieces.end], return_inverse=True)
    shown = np.arange(len(numbers)) % (-(-len(pieces) // limit)) == 0
    shown[-1] = True
    picked = np.flatnonzero(shown[inverse])
    picked = picked[:: max(1, len(picked) // limit)]
    return Pieces(pieces.begin[picked], pieces.end[picked])


def _corner_to_corner(samples: Samples, known: _Rows, span: int) -> Pieces:
    """Return pieces that end where a move does, where the known path does, and every ``span`` samples."""
    begin, end = [known[:0]], [known[:0]]
    closed, begun = True, 0  # whether a run ended before this block, and the place where the last one began
    for at in blocks(len(known)):
        rows, index = known[at], np.arange(at.start, at.stop)
        moves = samples.move[known[at.start : at.stop + 1]]
        last = np.ones(len(rows), dtype=np.bool_)  # of a run
        last[: len(moves) - 1] = (np.diff(known[at.start : at.stop + 1]) > 1) | (np.diff(moves) != 0)
        since = np.maximum.accumulate(np.where(np.concatenate([[closed], last[:-1]]), index, begun))
        closed, begun = bool(last[-1]), int(since[-1])
        place = index - since
        ends = np.flatnonzero(last | ((place + 1) % span == 0))
        begin.append(rows[ends] - place[ends] % span - 1)
        end.append(rows[ends])
        let_go(samples.move)
    return Pieces(np.concatenate(begin), np.concatenate(end))
