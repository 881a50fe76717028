"""The path of the nozzle in machine coordinates: a toolpath scaled, shifted and sampled along its length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.errors import InputError
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.toolpath import Toolpath

MAX_SAMPLES: Final = 5_000_000  # about 1 GB while they are computed
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
        """The layer of a sample, in words."""
        layer = int(self.layer[sample])
        return f"in layer {layer}" if layer else "before layer 1"

    @property
    def extruded_length(self) -> float:
        """Length (m) with extrusion."""
        return float(np.diff(self.distance)[self.extruding[1:]].sum())

    @property
    def travel_length(self) -> float:
        """Length (m) without extrusion."""
        return float(np.diff(self.distance)[~self.extruding[1:]].sum())


def sample(
    toolpath: Toolpath,
    scale: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    step: float = 0.05,
    print_speed: float = float("inf"),
    travel_speed: float = float("inf"),
) -> Samples:
    """Sample ``toolpath`` at the end of every move and in steps of at most ``step`` (m, machine).

    Lengths of the file are multiplied by ``scale``, then shifted by ``origin`` (m, machine). A move's speed limit is
    its feed times ``scale``, but at most ``print_speed`` where it extrudes and ``travel_speed`` where not (m/s). Moves
    of zero length (a nanometre or less) give no sample; their dwell is that of the last sample before.

    Raises `InputError` for more than `MAX_SAMPLES`, a path beyond `MAX_COORDINATE`, or one without length.
    """
    start = toolpath.start * scale + origin
    end = toolpath.end * scale + origin
    if not max(np.abs(start).max(), np.abs(end).max()) <= MAX_COORDINATE:
        raise InputError(f"the scaled path leaves the {MAX_COORDINATE:.0f} m about the machine's zero")
    length = np.linalg.norm(end - start, axis=1)
    moves = np.flatnonzero(length > _SHORTEST_MOVE)
    if len(moves) == 0:
        raise InputError(f"the scaled path has no move longer than {_SHORTEST_MOVE} m")
    with np.errstate(over="ignore"):
        pieces = np.maximum(1.0, np.ceil(length[moves] / step - 1e-9))
    if not pieces.sum() < MAX_SAMPLES:
        raise InputError(f"step = {step:g} m: more than {MAX_SAMPLES} samples; give a longer step")
    count = pieces.astype(np.int64)
    last = np.cumsum(count)  # the sample at the end of each move that has a length
    move = np.repeat(moves, count)

    fraction = (np.arange(len(move)) - np.repeat(last - count, count) + 1) / np.repeat(count, count)
    positions = np.empty((len(move) + 1, 3))
    positions[0] = start[moves[0]]
    positions[1:] = start[move] + fraction[:, None] * (end - start)[move]
    positions[last] = end[moves]  # exactly, without rounding of the fractions

    reached = np.zeros(len(length) + 1, dtype=np.int64)  # last sample after each move, of zero length or not
    reached[moves + 1] = count
    dwell = np.bincount(np.cumsum(reached)[1:], weights=toolpath.dwell, minlength=len(positions))
    extruding = toolpath.extruding
    limit = np.minimum(toolpath.feed * scale, np.where(extruding, print_speed, travel_speed))
    with_first = np.concatenate([move[:1], move])
    laying = extruding[with_first]
    laying[0] = False
    return _frozen(
        positions=positions,
        distance=np.concatenate([[0.0], np.cumsum(np.repeat(length[moves] / count, count))]),
        speed_limit=limit[with_first],
        dwell=dwell,
        move=with_first,
        extruding=laying,
        layer=toolpath.layer[with_first],
        line=toolpath.line[with_first],
    )


def _frozen(**columns: NDArray[Any]) -> Samples:
    """Build `Samples` of read-only arrays."""
    for column in columns.values():
        column.setflags(write=False)
    return Samples(**columns)
