"""Statistics of millions of numbers that arrive in portions: exact moments, histograms, and thinned rows to plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array

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
        """Standard deviation."""
        return math.sqrt(self.variance)

    @property
    def size(self) -> float:
        """Largest absolute value."""
        return max(abs(self.min), abs(self.max))


class Moments:
    """Exact moments of w columns of numbers without NaN, portion by portion (Chan, Golub, LeVeque 1979)."""

    def __init__(self, width: int = 1) -> None:
        """Start with no numbers."""
        self.count = np.zeros(width, dtype=np.int64)
        self._mean, self._squares = np.zeros(width), np.zeros(width)
        self._min, self._max = np.full(width, np.inf), np.full(width, -np.inf)

    def add(self, values: Array) -> None:
        """Add *values*, (k,) of one column or (k, w)."""
        if not len(values):
            return
        rows = values.reshape(len(values), -1)
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
        self._min = np.minimum(self._min, np.where(known, rows, np.inf).min(axis=0))
        self._max = np.maximum(self._max, np.where(known, rows, -np.inf).max(axis=0))

    @property
    def mean(self) -> Array:
        """(w,); NaN for none."""
        return np.where(self.count > 0, self._mean, np.nan)

    @property
    def variance(self) -> Array:
        """(w,) population variance; NaN for none."""
        return np.where(self.count > 0, self._squares / np.maximum(self.count, 1), np.nan)

    @property
    def max(self) -> Array:
        """(w,); NaN for none."""
        return np.where(self.count > 0, self._max, np.nan)

    @property
    def min(self) -> Array:
        """(w,); NaN for none."""
        return np.where(self.count > 0, self._min, np.nan)

    def summary(self, column: int = 0) -> Summary:
        """Return the summary of one column."""
        columns = (self.mean, self.variance, self.min, self.max)
        return Summary(int(self.count[column]), *(float(each[column]) for each in columns))


class Histogram:
    """Counts between evenly spaced edges; numbers beyond count at the ends."""

    def __init__(self, low: float, high: float, bins: int) -> None:
        """Start with no numbers."""
        self.edges = np.linspace(low, high, bins + 1)
        self.counts = np.zeros(bins, dtype=np.int64)

    def add(self, values: Array) -> None:
        """Add *values* (k,)."""
        known = values[np.isfinite(values)]
        share = (known - self.edges[0]) / (self.edges[-1] - self.edges[0])
        bins = len(self.counts)
        at = np.clip((share * bins).astype(np.int64), 0, bins - 1)
        self.counts += np.bincount(at, minlength=bins)


class ThinnedRows:
    """Every n-th row of numbers, with n growing so that there are never more than *capacity* rows."""

    def __init__(self, width: int, capacity: int = MAX_ROWS) -> None:
        """Keep at most *capacity* rows of *width* numbers."""
        self.every = 1
        self._kept = np.empty((capacity, width))
        self._count = self._seen = 0

    def add(self, rows: Array) -> None:
        """Add *rows* (k, width), which follow the earlier ones."""
        while True:
            first = -self._seen % self.every
            picked = rows[first :: self.every]
            if self._count + len(picked) <= len(self._kept):
                break
            self._halve()
        self._kept[self._count : self._count + len(picked)] = picked
        self._count += len(picked)
        self._seen += len(rows)

    def _halve(self) -> None:
        half = self._kept[: self._count : 2].copy()
        self._kept[: len(half)] = half
        self._count = len(half)
        self.every *= 2

    @property
    def rows(self) -> Array:
        """Kept rows (k, width), in order."""
        return self._kept[: self._count]
