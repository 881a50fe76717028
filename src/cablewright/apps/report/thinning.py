"""Fewer segments than the path has, chosen so that a picture of them looks like the whole."""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array, Indices
from cablewright.printing.path import Samples


class Pieces:
    """Straight pieces of the path between samples ``begin`` and ``end``, in the order of the path."""

    def __init__(self, begin: Indices, end: Indices) -> None:
        self.begin = begin
        self.end = end

    def __len__(self) -> int:
        """The number of pieces."""
        return len(self.end)


def worst_of_each_place(samples: Samples, known: Indices, error: Array, limit: int) -> Pieces:
    """Return one segment for each place of the plan, the one with the largest error, by rising error.

    ``known`` are the samples whose segments may be shown. A place is a square as small as ``limit`` allows, and a
    segment is where its middle is.
    """
    if len(known) == 0:
        return Pieces(known, known)
    order = known[np.argsort(-error[known], kind="stable")]
    plan = (samples.positions[order, :2] + samples.positions[order - 1, :2]) / 2
    corner, extent = plan.min(axis=0), max(float(np.ptp(plan, axis=0).max()), 1e-9)
    chosen = order
    cells = 1024
    while cells > 1:
        keys = ((plan - corner) * (cells / extent)).astype(np.int64) @ np.array([1, 2 * cells])
        first = np.unique(keys, return_index=True)[1]
        chosen = order[np.sort(first)[::-1]]
        if len(chosen) <= limit:
            break
        cells //= 2
    return Pieces(chosen - 1, chosen)


def coarse_corners(samples: Samples, known: Indices, limit: int, span: int) -> Pieces:
    """Return at most about ``limit`` pieces: corner to corner of whole layers, every so manyth layer.

    ``known`` are the samples whose segments may be shown. The first and the last layer always are. A straight move is
    cut every ``span`` samples, so that colour still changes along it.
    """
    pieces = _corner_to_corner(samples, known, span)
    if len(pieces) <= limit:
        return pieces
    numbers, inverse = np.unique(samples.layer[pieces.end], return_inverse=True)
    every = -(-len(pieces) // limit)
    shown = np.arange(len(numbers)) % every == 0
    shown[-1] = True
    picked = np.flatnonzero(shown[inverse])
    stride = max(1, len(picked) // limit)  # few and very long layers: gaps show
    picked = picked[::stride]
    return Pieces(pieces.begin[picked], pieces.end[picked])


def _corner_to_corner(samples: Samples, known: Indices, span: int) -> Pieces:
    """Return pieces that end where a move does, where the known path does, and every ``span`` samples."""
    if len(known) == 0:
        return Pieces(known, known)
    moves = samples.move[known]
    broken = np.flatnonzero((np.diff(known) > 1) | (np.diff(moves) != 0))  # a piece ends at these of the known
    firsts = np.concatenate([[0], broken + 1])
    lengths = np.diff(np.append(firsts, len(known)))
    place = np.arange(len(known)) - np.repeat(firsts, lengths)  # within the run
    last = place == np.repeat(lengths, lengths) - 1
    at = np.flatnonzero(last | ((place + 1) % span == 0))
    begin = known[at] - (place[at] % span) - 1
    return Pieces(begin, known[at])
