"""Statistics of millions of numbers that arrive in blocks: exact moments, histograms, and thinned rows to plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array

MAX_ROWS: Final = 20_000


@dataclass(frozen=True)
class Summary:
    """Count, mean, variance, minimum and maximum of some numbers; NaN for none."""

    count: int
    mean: float
    variance: float
    min: float
    max: float

    @property
    def deviation(self) -> float:
        """Standard deviation of the numbers."""
        return math.sqrt(self.variance)

    @property
    def size(self) -> float:
        """Largest absolute value of the numbers."""
        return max(abs(self.min), abs(self.max))


class Moments:
    """Exact moments of the finite numbers of w columns, block by block (Chan, Golub, LeVeque 1979).

    ``count``, ``min`` and ``max`` are (w,); where there are no numbers, all moments are NaN.
    """

    def __init__(self, width: int = 1) -> None:
        """Start with no numbers."""
        self.count = np.zeros(width, dtype=np.int64)
        self._mean, self._squares = np.zeros(width), np.zeros(width)
        self.min, self.max = np.full(width, np.nan), np.full(width, np.nan)

    def add(self, values: Array) -> None:
        """Add *values*, (k,) of one column or (k, w)."""
        rows = values.reshape(-1, len(self.count))
        known = np.isfinite(rows)
        count = known.sum(axis=0)
        if not count.any():
            return
        divisor = np.maximum(count, 1)
        mean = np.where(known, rows, 0.0).sum(axis=0) / divisor
        squares = (np.where(known, rows - mean, 0.0) ** 2).sum(axis=0)
        total = np.maximum(self.count + count, 1)
        shift = np.where(count > 0, mean - self._mean, 0.0)
        self._mean += shift * count / total
        self._squares += squares + shift**2 * self.count * count / total
        self.count += count
        finite = np.where(known, rows, np.nan)
        self.min = np.fmin(self.min, np.fmin.reduce(finite))
        self.max = np.fmax(self.max, np.fmax.reduce(finite))

    @property
    def mean(self) -> Array:
        """Mean (w,) of each column so far."""
        return np.where(self.count > 0, self._mean, np.nan)

    @property
    def variance(self) -> Array:
        """Population variance (w,) of each column so far."""
        return np.where(self.count > 0, self._squares / np.maximum(self.count, 1), np.nan)

    def summary(self, column: int = 0) -> Summary:
        """Return the summary of one column."""
        moments = (self.mean, self.variance, self.min, self.max)
        return Summary(int(self.count[column]), *(float(each[column]) for each in moments))


class Histogram:
    """Counts between evenly spaced edges; numbers outside count in the first or last bin."""

    def __init__(self, low: float, high: float, bins: int) -> None:
        """Start with no numbers."""
        self.edges = np.linspace(low, high, bins + 1)
        self.counts = np.zeros(bins, dtype=np.int64)

    def add(self, values: Array) -> None:
        """Add *values* (k,) to the histogram."""
        inside = np.clip(values[np.isfinite(values)], self.edges[0], self.edges[-1])
        self.counts += np.histogram(inside, self.edges)[0]


class ThinnedRows:
    """Every n-th row of numbers, with n growing so that there are never more than *capacity* rows."""

    def __init__(self, width: int, capacity: int = MAX_ROWS) -> None:
        """Keep at most *capacity* rows of *width* numbers."""
        self.every = 1
        self._kept = np.empty((capacity, width))
        self._count = self._seen = 0

    def add(self, rows: Array) -> None:
        """Add *rows* (k, width), which follow the earlier ones."""
        while self._count + len(picked := rows[-self._seen % self.every :: self.every]) > len(self._kept):
            half = self._kept[: self._count : 2].copy()
            self._count = len(half)
            self._kept[: self._count] = half
            self.every *= 2
        self._kept[self._count : self._count + len(picked)] = picked
        self._count += len(picked)
        self._seen += len(rows)

    @property
    def rows(self) -> Array:
        """Rows (k, width) that are kept of a long sequence, in order."""
        return self._kept[: self._count]
