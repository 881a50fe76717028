"""The growing part as boxes for distances: pieces of strands, each with the sample at which it is complete."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.printing.beads import Bead, Beads
from cablewright.printing.path import Samples

PIECE_LENGTH: Final = 0.25
"""Approximate maximum length (m) of a piece of strand."""

_UPRIGHT: Final = 1e-9  # share of a piece's length across the direction of laying, below which it is along it
_UP: Final = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Deposit:
    """B boxes in the order of printing, m, machine coordinates. Read-only arrays.

    Each is longer than the nozzle's path by half a bead's width at both ends, because strands have round ends, and
    reaches from the path down by the bead's height; on a board, towards the board.
    """

    centre: Array  # (B, 3)
    along: Array  # (B, 3) unit vectors
    across: Array  # (B, 3) unit vectors, level or in the board
    half: Array  # (B, 3) half the sides: along, across, and perpendicular to both
    sample: NDArray[np.int64]  # (B,) the sample from which on it exists
    layer: NDArray[np.int32]  # (B,)

    def __len__(self) -> int:
        """The number of boxes."""
        return len(self.sample)


def deposit(
    samples: Samples, beads: Bead | Beads, room: Room = MEMORY, up: tuple[float, float, float] = _UP
) -> Deposit:
    """Return the material of extruding moves, in pieces of about `PIECE_LENGTH` or shorter.

    A piece exists from the sample at its end on, not while it is being printed; a piece laid below *beads* before
    exists at the first sample. *room*: folder for the pieces. *up*: unit vector from a strand to the nozzle, world.
    """
    if isinstance(beads, Beads) and beads.below is not None and beads.below[0].extruding.any():
        return _joined(deposit(*beads.below, room, up), deposit(samples, replace(beads, below=None), room, up))
    laid = np.flatnonzero(samples.extruding)
    move, begins = samples.move[laid], samples.distance[laid - 1]
    fresh = np.ones(len(laid), dtype=bool)
    fresh[1:] = (np.diff(move) != 0) | (np.diff(laid) != 1)
    since = begins - begins[fresh][np.cumsum(fresh) - 1]
    bucket = np.floor(since / PIECE_LENGTH + 1e-9)
    fresh[1:] |= np.diff(bucket) != 0
    first = np.flatnonzero(fresh)
    last = np.append(first[1:], len(laid)) - 1
    before, ends = laid[first] - 1, laid[last]
    count = len(ends)
    columns = (
        *(room.empty((count, 3)) for _ in range(4)), room.empty((count,), np.int64), room.empty((count,), np.int32)
    )  # fmt: skip
    for at in blocks(count):
        sizes = beads.sizes(samples.move[ends[at]])
        boxes = _boxes(samples.positions[before[at]], samples.positions[ends[at]], *sizes, np.array(up))
        for column, values in zip(columns, (*boxes, ends[at], samples.layer[ends[at]]), strict=True):
            column[at] = values
        let_go((samples, columns))
    for column in columns:
        column.setflags(write=False)
    return Deposit(*columns)


def _joined(below: Deposit, above: Deposit) -> Deposit:
    """Return both deposits as one, of which that *below* exists from the beginning."""
    earlier = replace(below, sample=np.full(len(below), -1))
    pairs = ((getattr(each, name.name) for each in (earlier, above)) for name in fields(Deposit))
    columns = [np.concatenate(list(pair)) for pair in pairs]
    for column in columns:
        column.setflags(write=False)
    return Deposit(*columns)


def _boxes(start: Array, end: Array, wide: Array, high: Array, up: Array) -> tuple[Array, Array, Array, Array]:
    """Centre, directions along and across, and half sides (b, 3) of straight pieces from *start* to *end* (b, 3).

    *wide*, *high*: width and height (b,) of the beads' strands, m; *up* (3,): direction from the strands to the nozzle.
    """
    way = end - start
    length = np.linalg.norm(way, axis=1)
    along = way / length[:, None]
    across = np.cross(up, along)
    level = np.linalg.norm(across, axis=1)
    upright = level < _UPRIGHT
    across /= np.where(upright, 1.0, level)[:, None]
    across[upright] = np.linalg.svd(up[None])[2][1]  # any direction across it
    height = np.where(upright, wide, high)  # the box of a vertical piece is square
    drop = np.where(upright, 0.0, 0.5 * high)
    centre = 0.5 * (start + end) - drop[:, None] * np.cross(along, across)
    half = np.stack([0.5 * (length + wide), 0.5 * wide, 0.5 * height], axis=1)
    return centre, along, across, half
