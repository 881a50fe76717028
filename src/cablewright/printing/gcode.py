"""From a G-code file to a `Toolpath`: straight moves in metres, at the scale of the file.

The file is read in blocks, so that memory depends on the number of moves only. `cablewright.printing.modal` defines the
meaning of the words.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.errors import InputError
from cablewright.printing.modal import COLUMNS, Controller
from cablewright.progress import Progress
from cablewright.toml_input import open_regular

MAX_BYTES: Final = 1 << 30
MAX_LINE: Final = 4096  # bytes
SHORTEST_ARC_STEP: Final = 1e-6  # m

_BLOCK = 1 << 18
_HEIGHT_GRAIN = 1e-6  # m, resolution of heights in files without layer markers


@dataclass(frozen=True, eq=False)
class Toolpath:
    """The k straight moves of a file, each from the end of the previous one. Read-only arrays.

    A move of zero length is kept where the file extrudes or dwells on the spot.
    """

    start: Array  # (k, 3) m, file scale
    end: Array  # (k, 3) m, file scale
    extrusion: Array  # (k,) m of filament; negative: retracted
    feed: Array  # (k,) m/s, file scale; inf before the first F
    dwell: Array  # (k,) s waited at the end of the move
    layer: NDArray[np.int32]  # (k,) -1 before the first layer
    line: NDArray[np.int32]  # (k,) line of the file, from 1
    unknown: dict[str, int]  # ignored words, and how often each occurs

    @cached_property
    def length(self) -> Array:
        """(k,) length of each move, m, file scale."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    @cached_property
    def extruding(self) -> Mask:
        """(k,) whether the move lays material: it has a length and a positive extrusion."""
        return np.asarray((self.extrusion > 0) & (self.length > 0))

    @property
    def layer_count(self) -> int:
        """Number of layers with material."""
        numbers = np.unique(self.layer[self.extruding])
        return int(np.count_nonzero(numbers >= 0))


def parse(source: str | Path | BinaryIO, arc_step: float = 1e-3, progress: Progress | None = None) -> Toolpath:
    """Read G-code from a path or an open binary file.

    ``arc_step`` (m, file scale) is the maximum length of the pieces of an arc; their distance from the arc is at most a
    fiftieth of it. Layers come from the markers ``;LAYER:3``, ``;LAYER_CHANGE`` and ``; layer 3``; negative numbers (of
    a raft) shift all so that the lowest is 0. A file without markers has one layer per height at which it extrudes,
    counted upwards; a travel move then belongs to the last extruded layer.

    Raises `InputError`, with the line and what is allowed, for a file that cannot be read, is no G-code, is empty, too
    large, truncated, or lays no material.
    """
    if not SHORTEST_ARC_STEP <= arc_step < float("inf"):
        raise InputError(f"arc_step = {arc_step!r}: must be a length of at least {SHORTEST_ARC_STEP} m")
    if not isinstance(source, str | Path):
        return _parse_stream(source, str(getattr(source, "name", "G-code")), arc_step, None, progress)
    with open_regular(Path(source)) as stream:
        return _parse_stream(stream, str(source), arc_step, os.fstat(stream.fileno()).st_size, progress)


def _parse_stream(
    stream: BinaryIO, origin: str, arc_step: float, size: int | None, progress: Progress | None
) -> Toolpath:
    """Read an open file of ``size`` bytes; None: unknown."""
    controller = Controller(origin, arc_step)
    number = 1
    for lines, unterminated in _blocks_of_lines(stream, origin, size, progress):
        controller.run(lines, number, unterminated)
        number += len(lines)
    return _toolpath(controller, origin)


def _blocks_of_lines(
    stream: BinaryIO, origin: str, size: int | None, progress: Progress | None
) -> Iterator[tuple[list[bytes], bool]]:
    """Yield lists of lines without line ends, and whether the list is an unterminated last line."""
    rest = b""
    number = 1
    read = 0
    while block := stream.read(_BLOCK):
        if read == 0:
            _refuse_binary(block, origin)
            block = block.removeprefix(b"\xef\xbb\xbf")
        read += len(block)
        if read > MAX_BYTES:
            raise InputError(f"{origin}: larger than {MAX_BYTES} bytes, the most a G-code file may hold")
        if b"\0" in block:
            raise InputError(f"{origin}: holds NUL bytes: a binary file, no G-code")
        lines = (rest + block).split(b"\n")
        if max(map(len, lines)) > MAX_LINE:
            at = next(at for at, line in enumerate(lines, number) if len(line) > MAX_LINE)
            raise InputError(f"{origin}, line {at}: longer than {MAX_LINE} bytes, the most a line may hold")
        rest = lines.pop()
        number += len(lines)
        yield lines, False
        if progress is not None:
            progress("reading G-code", read, size or read)
    if read == 0:
        raise InputError(f"{origin}: the file is empty")
    if rest:
        yield [rest], True


def _refuse_binary(block: bytes, origin: str) -> None:
    """Raise `InputError` if more than a tenth of a file's first block is no text."""
    text = block.decode("utf-8", "replace")
    strange = sum(1 for character in text if character == "\ufffd" or (character < " " and character not in "\t\r\n\f"))
    if strange > 0.1 * len(text):
        raise InputError(f"{origin}: a binary file, no G-code")


def _toolpath(controller: Controller, origin: str) -> Toolpath:
    """Return the moves that the controller recorded. Raises `InputError` where nothing is extruded."""
    rows = np.asarray(controller.rows).reshape(-1, COLUMNS)
    line = np.array(controller.lines, dtype=np.int32)
    k = len(line)
    bad = np.flatnonzero(~np.isfinite(rows[:, 3]))
    if len(bad) > 0:
        raise InputError(f"{origin}, line {line[bad[0]]}: E is too large")
    points = np.zeros((k + 1, 3))
    points[1:] = rows[:, :3]
    extrusion = rows[:, 3].copy()
    extruding = (extrusion > 0) & (np.linalg.norm(np.diff(points, axis=0), axis=1) > 0)
    if not extruding.any():
        raise InputError(f"{origin}: no extruding move; at least one move must increase E")
    dwell = np.zeros(k)
    for row, seconds in controller.dwells:
        dwell[row] = seconds
    layer = _marked_layers(controller.marks, k) if controller.marks else _layers_by_height(points[1:, 2], extruding)
    feed = rows[:, 4].copy()
    for column in (points, extrusion, feed, dwell, layer, line):
        column.setflags(write=False)
    return Toolpath(points[:-1], points[1:], extrusion, feed, dwell, layer, line, dict(controller.unknown))


def _marked_layers(marks: list[tuple[int, int]], k: int) -> NDArray[np.int32]:
    """Return the layer of each move (k,), from the row at which each layer begins."""
    starts = np.array([0, *(row for row, _ in marks), k])
    numbers = np.array([-1, *(number for _, number in marks)], dtype=np.int32)
    numbers[1:] -= min(0, int(numbers[1:].min()))
    return np.repeat(numbers, np.diff(starts))


def _layers_by_height(height: Array, extruding: Mask) -> NDArray[np.int32]:
    """Return the layer of each move (k,), from the distinct heights (m) at which extruding moves end."""
    grains = np.round(height[extruding] / _HEIGHT_GRAIN)
    layer = np.full(len(height), -1, dtype=np.int32)
    layer[extruding] = np.unique(grains, return_inverse=True)[1]
    last = np.maximum.accumulate(np.where(extruding, np.arange(len(height)), -1))
    return np.asarray(np.where(last >= 0, layer[last], -1), dtype=np.int32)
