"""Where something was a little while ago: rows of numbers by time, for readings that tell of the past."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Trail"]

Array = NDArray[np.float64]


class Trail:
    """The last rows of some numbers, with their times, which rise. Between two it goes evenly, beyond it stands."""

    def __init__(self, width: int, length: int) -> None:
        """Keep at least the last *length* rows of *width* numbers."""
        self._length = length
        self._times = np.empty(2 * length)
        self._rows = np.empty((2 * length, width))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def clear(self) -> None:
        """Forget all."""
        self._count = 0

    def add(self, time: float, row: ArrayLike) -> None:
        """Add a row. One of the last's time takes its place, one from before it is left out."""
        if self._count and not time > self._times[self._count - 1]:
            if time == self._times[self._count - 1]:
                self._rows[self._count - 1] = row
            return
        if self._count == len(self._times):
            self._times[: self._length] = self._times[self._length :]
            self._rows[: self._length] = self._rows[self._length :]
            self._count = self._length
        self._times[self._count] = time
        self._rows[self._count] = row
        self._count += 1

    def at(self, times: ArrayLike) -> Array:
        """Rows at *times* (k,): (k, width); zeros where nothing was added yet."""
        wanted = np.asarray(times, dtype=np.float64)
        if not self._count:
            return np.zeros((len(wanted), self._rows.shape[1]))
        known, rows = self._times[: self._count], self._rows
        after = np.minimum(known.searchsorted(wanted), self._count - 1)
        before = np.maximum(after - 1, 0)
        since, lasts = wanted - known[before], known[after] - known[before]
        share = np.clip(since / np.where(lasts > 0.0, lasts, 1.0), 0.0, 1.0)
        return np.asarray(rows[before] + share[:, None] * (rows[after] - rows[before]))
