"""Data for the viewer: arrays packed into text, and polylines at several levels of detail."""

from __future__ import annotations

import base64
import zlib
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Indices, Mask

Packed = dict[str, Any]
"""``type`` (u8, u16, u32 or f32), ``shape``, ``delta``: whether rows are differences from the row before, ``data``."""

_TYPES: Final = {"u8": "<u1", "u16": "<u2", "u32": "<u4", "f32": "<f4"}
_LEVEL: Final = 6  # of zlib


def packed(values: NDArray[Any], kind: str, *, delta: bool = False) -> Packed:
    """Return *values* as an array packed into text, of a type of `Packed`.

    *delta*: whether to write differences, which wrap, for whole numbers that change little. Raises `OverflowError` for
    a whole number that the type does not hold.
    """
    given = np.asarray(values)
    made = given.astype(_TYPES[kind])
    if kind != "f32" and not np.array_equal(made, given):
        raise OverflowError(f"numbers that {kind} does not hold")
    if delta and len(made):
        made = np.concatenate([made[:1], np.diff(made, axis=0)])  # modulo its size
    data = base64.b64encode(zlib.compress(made.tobytes(), _LEVEL)).decode("ascii")
    return {"type": kind, "shape": list(made.shape), "delta": delta, "data": data}


def unpacked(given: Packed) -> NDArray[Any]:
    """Return the array that `packed` has written as text."""
    data = zlib.decompress(base64.b64decode(given["data"]))
    values = np.frombuffer(data, dtype=_TYPES[given["type"]]).reshape(given["shape"])
    return np.cumsum(values, axis=0, dtype=values.dtype) if given["delta"] else values


LEFT_OUT: Final = 255
_AT_ONCE: Final = 1 << 16  # points whose distances are in memory
_BREAK: Final = 512  # vertices after which one is kept in any case, which keeps pieces short
PIECE: Final = 128 * _BREAK
"""Vertices after which a long path may be cut, with the next one in both: the levels are the same."""


def levels(points: Array, fixed: Mask, tolerances: Array) -> NDArray[np.uint8]:
    """Return the level of detail (k,) of each of *points* (k, d): the index of the first tolerance that needs it.

    *fixed* (k,): those that every level has; *tolerances* (L,), falling, in the unit of the points. `LEFT_OUT`: none
    needs it.
    """
    level = np.full(len(points), LEFT_OUT, dtype=np.uint8)
    level[fixed] = 0
    level[::_BREAK] = 0
    level[-1:] = 0
    for number, tolerance in enumerate(tolerances):
        kept = np.flatnonzero(level != LEFT_OUT)
        begin, end = kept[:-1], kept[1:]
        open_ = end - begin > 1
        begin, end = begin[open_], end[open_]
        while len(begin):
            farthest, distance = _farthest_by_turns(points, begin, end)
            split = distance > tolerance
            middle = farthest[split]
            level[middle] = number
            begin, end = np.concatenate([begin[split], middle]), np.concatenate([middle, end[split]])
            open_ = end - begin > 1
            order = np.argsort(begin[open_], kind="stable")
            begin, end = begin[open_][order], end[open_][order]
    return level


def _farthest_by_turns(points: Array, begin: Indices, end: Indices) -> tuple[Indices, Array]:
    """As `_farthest`, of so many pieces at a time that memory does not grow with the path."""
    total = np.cumsum(end - begin)
    cuts = np.searchsorted(total, np.arange(_AT_ONCE, total[-1], _AT_ONCE))
    turns = [
        _farthest(points, *ends)
        for ends in zip(np.split(begin, cuts), np.split(end, cuts), strict=True)
        if len(ends[0])
    ]
    at, distance = zip(*turns, strict=True)
    return np.concatenate(at), np.concatenate(distance)


def _farthest(points: Array, begin: Indices, end: Indices) -> tuple[Indices, Array]:
    """Return the point farthest from each chord from *begin* to *end* (s,), and how far; there is one between."""
    counts = end - begin - 1
    starts = np.cumsum(counts) - counts
    piece = np.repeat(np.arange(len(begin)), counts)
    at = np.arange(int(counts.sum())) - starts[piece] + begin[piece] + 1
    chord = points[end] - points[begin]
    size = np.maximum(np.einsum("ij,ij->i", chord, chord), 1e-300)
    away = points[at] - points[begin][piece]
    share = np.clip(np.einsum("ij,ij->i", away, chord[piece]) / size[piece], 0.0, 1.0)
    away -= share[:, None] * chord[piece]
    square = np.einsum("ij,ij->i", away, away)
    largest = np.maximum.reduceat(square, starts)
    hits = np.flatnonzero(square == largest[piece])
    return at[hits[np.unique(piece[hits], return_index=True)[1]]], np.sqrt(largest)
