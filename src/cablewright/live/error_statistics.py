"""Statistics of an estimator's errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure

CHI2_95: Final = 7.8147
"""95 % quantile of the chi-square distribution with 3 degrees of freedom."""

SLACK: Final = 5e-3
"""Excess from which a line counts as slack in statistics, m."""


@dataclass(frozen=True)
class ErrorStatistics:
    """Count, root mean square, median, 95 % and 99 % quantiles and maximum (``most``) of sizes of errors."""

    count: int
    rms: float
    median: float
    p95: float
    p99: float
    max: float


def statistics_figures(unit: str, shown: str) -> tuple[Figure, ...]:
    """Return declarations of count, rms, median, p95, p99 and max of errors in *unit*, shown to people in *shown*."""
    return (
        Figure("count", "1", "Number of errors.", detail=True),
        Figure("rms", unit, "Root mean square of the errors; null without any.", digits=3, shown=shown),
        Figure("median", unit, "Median of the errors' sizes.", digits=3, shown=shown, detail=True),
        Figure("p95", unit, "95 % quantile of the errors' sizes.", name="95 %", digits=3, shown=shown),
        Figure("p99", unit, "99 % quantile of the errors' sizes.", digits=3, shown=shown, detail=True),
        Figure("max", unit, "Largest size of an error.", digits=3, shown=shown),
    )


def spread(values: Array) -> ErrorStatistics:
    """Return the statistics of the absolute *values* (k,) that are finite; NaN without any."""
    size = np.abs(values[np.isfinite(values)])
    if not len(size):
        return ErrorStatistics(0, *(math.nan,) * 5)
    median, p95, p99 = np.percentile(size, (50.0, 95.0, 99.0)).tolist()
    return ErrorStatistics(len(size), float(np.sqrt((size**2).mean())), median, p95, p99, float(size.max()))


def bound(covariance: Array) -> float:
    """Return the 95 % quantile, m, of the size of an error with that *covariance* (3, 3), m^2.

    Its square is approximated by a chi-square distribution of the same two moments (Satterthwaite 1946), whose quantile
    by Wilson and Hilferty 1931.
    """
    trace, square = float(np.trace(covariance)), float(np.sum(covariance * covariance))
    if not square > 0.0:
        return 0.0
    freedoms = trace * trace / square
    root = 1.0 - 2.0 / (9.0 * freedoms) + 1.645 * math.sqrt(2.0 / (9.0 * freedoms))
    return math.sqrt(trace * root**3)
