"""Table of layers: height, extruded length, travel length and duration, one row per layer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw


@dataclass(frozen=True, eq=False)
class LayerTable:
    """Table of n visits of layers, in the order of the path. Read-only arrays.

    A file that prints several parts one after the other visits the same layer number again: each visit is a row. Moves
    before the first layer are in no row.
    """

    number: NDArray[np.int32]  # (n,) the layer's number
    z: Array  # (n,) m, machine: the greatest height with material; NaN without
    extruded_length: Array  # (n,) m
    travel_length: Array  # (n,) m
    duration: Array  # (n,) s, including dwells
    first: NDArray[np.int64]  # (n,) first sample
    stop: NDArray[np.int64]  # (n,) one beyond the last sample

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.number)


def layer_table(samples: Samples, law: TimeLaw) -> LayerTable:
    """Return the sums over each layer of ``samples`` timed by ``law``. The segment before a sample is of its layer."""
    first = np.concatenate([np.zeros(1, dtype=np.int64), _changes(samples.layer)])
    stop = np.append(first[1:], len(samples))
    z = np.full(len(first), -np.inf)
    extruded, travelled, spent = np.zeros((3, len(first)))
    before = 0.0  # when the sample before a block is left
    for at in blocks(len(samples)):
        visits = np.arange(np.searchsorted(first, at.start, side="right") - 1, np.searchsorted(first, at.stop))
        begin = np.maximum(first[visits], at.start) - at.start  # of each visit, in this block
        laid, length = samples.extruding[at], samples.lengths(at)
        height = np.where(laid, samples.positions[at, 2], -np.inf)
        z[visits] = np.maximum(z[visits], np.maximum.reduceat(height, begin))
        extruded[visits] += np.add.reduceat(np.where(laid, length, 0.0), begin)
        travelled[visits] += np.add.reduceat(np.where(laid, 0.0, length), begin)
        left = law.time[at] + samples.dwell[at]
        spent[visits] += np.add.reduceat(np.diff(left, prepend=before), begin)
        before = left[-1]
        let_go((samples, law))
    number = samples.layer[first]
    columns = (number, np.where(np.isfinite(z), z, np.nan), extruded, travelled, spent, first, stop)
    kept = [column[number > 0] for column in columns]
    for column in kept:
        column.setflags(write=False)
    return LayerTable(*kept)


def _changes(layer: NDArray[np.int32]) -> NDArray[np.int64]:
    """The samples whose layer is not that of the one before, in order."""
    changed = [np.flatnonzero(np.diff(layer[at.start : at.stop + 1])) + at.start for at in blocks(len(layer) - 1)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *changed]) + 1
