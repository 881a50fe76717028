"""Timestamped rows with linear interpolation, for readings that arrive late."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering.time_rows import interpolate


class TimeBuffer:
    """The latest rows of numbers, by rising time. Linear interpolation, clamped at both ends."""

    def __init__(self, width: int, capacity: int) -> None:
        """Keep at least the latest *capacity* rows of *width* numbers."""
        self._capacity = capacity
        self._times = np.empty(2 * capacity)
        self._rows = np.empty((2 * capacity, width))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def clear(self) -> None:
        """Remove all rows of the buffer."""
        self._count = 0

    def add(self, time: float, row: ArrayLike) -> None:
        """Append a row at *time*, s. A row of the last one's time replaces it; an earlier one is ignored."""
        if self._count and not time > self._times[self._count - 1]:
            if time == self._times[self._count - 1]:
                self._rows[self._count - 1] = row
            return
        if self._count == len(self._times):
            self._times[: self._capacity] = self._times[self._capacity :]
            self._rows[: self._capacity] = self._rows[self._capacity :]
            self._count = self._capacity
        self._times[self._count] = time
        self._rows[self._count] = row
        self._count += 1

    def at(self, times: ArrayLike) -> Array:
        """Interpolated rows (k, width) at *times* (k,), s; zeros while the buffer is empty."""
        t = np.array(times, dtype=np.float64)
        found = np.zeros((len(t), self._rows.shape[1]))
        if self._count:
            interpolate(self._times[: self._count], self._rows, t, found)
        return found
