"""One row per layer: its height, extruded length, travel length and duration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw


@dataclass(frozen=True, eq=False)
class LayerTable:
    """n visits of layers, in the order of the path. Read-only arrays.

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
    changes = np.flatnonzero(np.diff(samples.layer)) + 1
    first = np.concatenate([np.zeros(1, dtype=np.int64), changes])
    stop = np.append(changes, len(samples))
    length = np.diff(samples.distance, prepend=0.0)
    left = law.time + samples.dwell  # when each sample is left
    spent = np.diff(left, prepend=0.0)
    height = np.where(samples.extruding, samples.positions[:, 2], -np.inf)
    z = np.maximum.reduceat(height, first)
    columns = (
        samples.layer[first],
        np.where(np.isfinite(z), z, np.nan),
        np.add.reduceat(np.where(samples.extruding, length, 0.0), first),
        np.add.reduceat(np.where(samples.extruding, 0.0, length), first),
        np.add.reduceat(spent, first),
        first,
        stop,
    )
    kept = [column[samples.layer[first] > 0] for column in columns]
    for column in kept:
        column.setflags(write=False)
    return LayerTable(*kept)
