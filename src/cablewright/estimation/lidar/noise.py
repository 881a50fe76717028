"""Noise of a lidar's ranges, and its growth with range, from the differences of neighbours in one scan."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.lidar.scan import Points
from cablewright.foundation.arrays import Array

_MEDIAN_OF_NORMAL: Final = 0.6745  # of the size of a normal number, in sigmas
_THIRDS: Final = math.sqrt(20.0)  # standard deviation of third differences, in that of one value
_PER_GROUP: Final = 30  # differences, at least
_GROUPS: Final = 10
_SIGNIFICANT: Final = 2.0  # sigmas, from which growth with range counts
_TOO_LARGE: Final = 0.75  # share of a first estimate from which errors on walls replace it
_MAX_GROWTH: Final = 0.05  # m/m


class Noise(NamedTuple):
    """Standard deviation of a lidar range r: ``at_zero + per_metre * r``."""

    at_zero: float  # m
    per_metre: float  # m/m


def estimate_noise(points: Points, low: float = 5e-4, high: float = 0.05) -> float:
    """Return the standard deviation of one range, m, by third differences of neighbours, from ``low`` to ``high``.

    In steps of two degrees or less a straight wall has hardly any third difference. Their median ignores corners and
    small objects.
    """
    if len(points) < 4:
        return low
    thirds = np.abs(np.diff(points.distance, 3))
    return float(np.clip(np.median(thirds) / (_MEDIAN_OF_NORMAL * _THIRDS), low, high))


def estimate_noise_by_range(points: Points, low: float = 5e-4, high: float = 0.05) -> Noise:
    """Return the noise as a linear function of range, fitted to one scan.

    The medians of third differences, grouped by range, are fitted robustly. Without growth, or where the scan does not
    show it with two sigma, ``per_metre`` is 0 and ``at_zero`` is that of `estimate_noise`.
    """
    constant = Noise(estimate_noise(points, low, high), 0.0)
    if len(points) < 3 + 3 * _PER_GROUP:
        return constant
    far, thirds = _neighbours(points)
    # Of four neighbours in a difference about two are new.
    return _by_range(far, thirds / _THIRDS, 0.5, constant, low, high)


def refine_noise(far: Array, errors: Array, first: Noise, low: float = 5e-4, high: float = 0.05) -> Noise:
    """Return a lidar's noise from the *errors* (n,), m, of ranges *far* (n,), m, of points on walls.

    *first* is that of all points, before walls were known. It stays where there is no growth with range, unless it is
    far too large: rays a degree apart see steps on a straight wall at a grazing angle.
    """
    sizes = np.abs(errors)
    if not first.per_metre and len(sizes) >= _PER_GROUP:
        constant = float(np.median(sizes)) / _MEDIAN_OF_NORMAL
        first = first if constant > _TOO_LARGE * first.at_zero else Noise(max(constant, low), 0.0)
    return _by_range(far, sizes, 1.0, first, low, high)


def _by_range(far: Array, sizes: Array, fresh: float, otherwise: Noise, low: float, high: float) -> Noise:
    """Fit the noise to the *sizes* of errors; ``fresh``: share of them that are independent."""
    groups = min(_GROUPS, len(far) // _PER_GROUP)
    if groups < 3:
        return otherwise
    order = np.array_split(np.argsort(far, kind="stable"), groups)
    middle = np.array([np.median(far[group]) for group in order])
    spread = np.array([np.median(sizes[group]) for group in order]) / _MEDIAN_OF_NORMAL
    relative = 1.17 / np.sqrt(np.array([len(group) for group in order]) * fresh)  # of a median of normal sizes
    return _line(middle, np.maximum(spread, 0.5 * low), relative, otherwise, low, high)


def _neighbours(points: Points) -> tuple[Array, Array]:
    """Ranges and sizes of third differences of four successive rays, none of them missing in between."""
    step = points.bearing_step[:-1]
    close = step <= 2.5 * np.median(step) + 1e-6
    whole = close[:-2] & close[1:-1] & close[2:]
    windows = np.lib.stride_tricks.sliding_window_view(points.distance, 4)
    return np.median(windows[whole], axis=1), np.abs(np.diff(points.distance, 3))[whole]


def _line(r: Array, s: Array, relative: Array, constant: Noise, low: float, high: float) -> Noise:
    """Fit ``s = a + b r`` with few outliers among the groups; *constant* where b is not significant."""
    columns = np.stack([np.ones_like(r), r], axis=1)
    robust, model = np.ones_like(r), np.full_like(r, np.median(s))
    for _ in range(20):
        weights = robust / (relative * model)
        x = np.linalg.lstsq(columns * weights[:, None], s * weights, rcond=None)[0]
        if x[0] < low:  # what grows from nothing
            x = np.array([low, max(0.0, float(np.median((s - low) / np.maximum(r, 1e-3))))])
        model = np.maximum(columns @ x, low)
        robust = 1.0 / np.sqrt(np.maximum(1.0, np.abs(s - model) / (relative * model)))
    covariance = np.linalg.pinv((columns / (relative * model)[:, None]).T @ (columns / (relative * model)[:, None]))
    a, b = float(x[0]), float(x[1])
    if not b > _SIGNIFICANT * math.sqrt(covariance[1, 1]):
        return constant
    return Noise(min(a, high), min(b, _MAX_GROWTH))
