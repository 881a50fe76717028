"""Timestamped rows with linear interpolation, for readings that arrive late."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array


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
        t = np.asarray(times, dtype=np.float64)
        if not self._count:
            return np.zeros((len(t), self._rows.shape[1]))
        known, rows = self._times[: self._count], self._rows
        after = np.minimum(known.searchsorted(t), self._count - 1)
        before = np.maximum(after - 1, 0)
        since, spans = t - known[before], known[after] - known[before]
        share = np.clip(since / np.where(spans > 0.0, spans, 1.0), 0.0, 1.0)
        return np.asarray(rows[before] + share[:, None] * (rows[after] - rows[before]))
