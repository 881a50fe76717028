"""The path of the nozzle in machine coordinates: a toolpath scaled, shifted and sampled along its length."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.toolpath import Toolpath

MAX_SAMPLES: Final = 5_000_000  # 0.4 GB, in memory
MAX_IN_FILES: Final = 20_000_000
_SHORTEST_MOVE: Final = 1e-9  # m, shorter moves are rounding


@dataclass(frozen=True, eq=False)
class Samples:
    """k points along the path: its start, then the end of each straight segment. Read-only arrays.

    ``extruding``, ``layer``, ``line``, ``move`` and ``speed_limit`` are those of the segment that ends at the sample;
    the first sample has those of the first segment, but is not extruding.
    """

    positions: Array  # (k, 3) m, machine
    distance: Array  # (k,) m, along the path from its start
    speed_limit: Array  # (k,) m/s, may be inf
    dwell: Array  # (k,) s waited at the sample
    move: NDArray[np.int64]  # (k,) row of the toolpath
    extruding: Mask  # (k,)
    layer: NDArray[np.int32]  # (k,) from 1; 0 before the first layer
    line: NDArray[np.int32]  # (k,) line of the file, from 1

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.distance)

    def where(self, sample: int) -> str:
        """Return the layer and G-code line of a path sample, in words."""
        layer = int(self.layer[sample])
        return f"in layer {layer}" if layer else "before layer 1"

    @property
    def extruded_length(self) -> float:
        """Length (m) of the path with extrusion."""
        return self._length(laid=True)

    @property
    def travel_length(self) -> float:
        """Length (m) of the path without extrusion."""
        return self._length(laid=False)

    def lengths(self, at: slice) -> Array:
        """Return lengths (b,), m, of the segments that end at a block of samples; 0 at the first of all."""
        return np.diff(self.distance[at], prepend=self.distance[at.start - 1] if at.start else 0.0)

    def _length(self, *, laid: bool) -> float:
        found = 0.0
        for segments in blocks(len(self) - 1):
            at = slice(segments.start + 1, segments.stop + 1)
            found += float(self.lengths(at)[self.extruding[at] == laid].sum())
            let_go((self.distance, self.extruding))
        return found


def sample(
    toolpath: Toolpath,
    scale: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    step: float = 0.05,
    print_speed: float = float("inf"),
    travel_speed: float = float("inf"),
    room: Room = MEMORY,
) -> Samples:
    """Sample ``toolpath`` at the end of every move and in steps of at most ``step`` (m, machine).

    Lengths of the file are multiplied by ``scale``, then shifted by ``origin`` (m, machine). A move's speed limit is
    its feed times ``scale``, but at most ``print_speed`` where it extrudes and ``travel_speed`` where not (m/s). Moves
    of zero length (a nanometre or less) give no sample; their dwell is that of the last sample before. ``room``: folder
    for the samples.

    Raises `InputError` for more than `MAX_SAMPLES`, or with room in files `MAX_IN_FILES`, for a path beyond
    `MAX_COORDINATE`, or for one without length.
    """
    length = np.empty(len(toolpath.start))
    for at in blocks(len(length)):
        start, end = toolpath.start[at] * scale + origin, toolpath.end[at] * scale + origin
        if not max(np.abs(start).max(), np.abs(end).max()) <= MAX_COORDINATE:
            raise InputError(f"the scaled path leaves the {MAX_COORDINATE:.0f} m about the machine's zero")
        length[at] = np.linalg.norm(end - start, axis=1)
        let_go(toolpath)
    moves = np.flatnonzero(length > _SHORTEST_MOVE)
    if len(moves) == 0:
        raise InputError(f"the scaled path has no move longer than {_SHORTEST_MOVE} m")
    with np.errstate(over="ignore"):
        pieces = np.maximum(1.0, np.ceil(length[moves] / step - 1e-9))
    most = MAX_SAMPLES if room.folder is None else MAX_IN_FILES
    if not pieces.sum() < most:
        raise InputError(f"step = {step:g} m: more than {most} samples; give a longer step")
    count = pieces.astype(np.int64)
    last = np.cumsum(count)  # the sample at the end of each move that has a length
    samples = _empty(int(last[-1]) + 1, room)
    speeds = scale, print_speed, travel_speed
    _write(samples, slice(0, 1), toolpath, moves[:1], speeds)
    samples.positions[0], samples.distance[0] = toolpath.start[moves[0]] * scale + origin, 0.0
    samples.extruding[0] = False
    for at in blocks(int(last[-1])):
        rows = np.arange(at.start, at.stop)
        own = np.searchsorted(last, rows, side="right")  # of `moves`: where each sample is
        move, into = moves[own], slice(at.start + 1, at.stop + 1)
        _write(samples, into, toolpath, move, speeds)
        start, end = toolpath.start[move] * scale + origin, toolpath.end[move] * scale + origin
        fraction = (rows - (last - count)[own] + 1) / count[own]
        ends = rows + 1 == last[own]
        samples.positions[into] = start + fraction[:, None] * (end - start)
        samples.positions[into][ends] = end[ends]  # exactly, without rounding of the fractions
        steps = length[move] / count[own]
        samples.distance[into] = np.cumsum(np.concatenate([samples.distance[at.start : at.start + 1], steps]))[1:]
        let_go((samples, toolpath))
    waits = np.flatnonzero(toolpath.dwell)
    before = np.searchsorted(moves, waits, side="right")  # moves with a length until each that waits
    np.add.at(samples.dwell, np.concatenate([[0], last])[before], toolpath.dwell[waits])
    for each in fields(samples):
        getattr(samples, each.name).setflags(write=False)
    return samples


def _write(
    samples: Samples, at: slice, toolpath: Toolpath, move: NDArray[np.int64], speeds: tuple[float, float, float]
) -> None:
    """Write what samples have of their *move* (b,); *speeds*: scale of the feed, most while printing and between."""
    scale, printing, travelling = speeds
    samples.move[at], samples.layer[at], samples.line[at] = move, toolpath.layer[move], toolpath.line[move]
    samples.extruding[at] = toolpath.extruding[move]
    samples.speed_limit[at] = np.minimum(
        toolpath.feed[move] * scale, np.where(samples.extruding[at], printing, travelling)
    )
    samples.dwell[at] = 0.0


def _empty(rows: int, room: Room) -> Samples:
    """Samples without numbers."""
    return Samples(
        positions=room.empty((rows, 3)),
        distance=room.empty((rows,)),
        speed_limit=room.empty((rows,)),
        dwell=room.empty((rows,)),
        move=room.empty((rows,), np.int64),
        extruding=room.empty((rows,), np.bool_),
        layer=room.empty((rows,), np.int32),
        line=room.empty((rows,), np.int32),
    )
