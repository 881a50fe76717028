"""A time law with bounded jerk: the running mean of one with bounded acceleration.

Let s(t) be a law with accelerations up to a. Its mean over the last w = 2 a / j seconds follows the same path; its
acceleration is a difference of speeds divided by w, at most a, and its jerk a difference of accelerations divided by w,
at most 2 a / w = j. The mean is late by up to w. It respects a speed limit at a place if s respects the limit over the
distance that it covers in w at that speed, before and after the place. At a stop s waits for w.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array

_NEAR: Final = 1e-9  # m, distance of places that count as one
_STEPS: Final = 60  # maximum of Newton's method in a bracket: as many halvings reach rounding


class Knots(NamedTuple):
    """Pieces of constant acceleration of a time law, one after another."""

    time: Array  # (p,) s, where each begins
    place: Array  # (p,) m
    speed: Array  # (p,) m/s
    acceleration: Array  # (p,) m/s^2
    area: Array  # (p,) m s: the integral of the place from the start


def refined(distance: Array, limit: Array, corner: Array, window: float) -> Array:
    """Return positions (g,), m: *distance* (k,) and the ends of all ranges over which a limit holds in `widened`."""
    changes = np.flatnonzero(np.diff(limit)) + 1
    reach = np.concatenate([np.minimum(limit[changes - 1], limit[changes]), corner]) * window
    about = np.concatenate([distance[changes], distance])
    ends = np.concatenate([about - reach, about + reach])
    ends = np.unique(ends[np.isfinite(ends) & (ends > distance[0]) & (ends < distance[-1])])
    after = np.searchsorted(distance, ends)
    apart = np.minimum(distance[after] - ends, ends - distance[after - 1]) > _NEAR
    apart[1:] &= np.diff(ends) > _NEAR
    return np.sort(np.concatenate([distance, ends[apart]]))


def widened(places: Array, limit: Array, corner: Array, window: float) -> tuple[Array, Array]:
    """Return limits of the segments between *places* (g,) and at the places, m/s, widened by *window*, s.

    A limit then also holds over the distance covered in *window* at that speed. *limit* (g - 1,) is that of each
    segment, *corner* (g,) that at each place: inf for none, 0 for a stop.
    """
    moving = np.flatnonzero(np.isfinite(corner) & (corner > 0.0))
    value = np.concatenate([limit, corner[moving]])
    low = np.concatenate([places[:-1], places[moving]]) - value * window
    high = np.concatenate([places[1:], places[moving]]) + value * window
    last = len(limit)
    first = np.clip(np.searchsorted(places, low + _NEAR, side="right") - 1, 0, last - 1)
    stop = np.clip(np.searchsorted(places, high - _NEAR, side="left"), first + 1, last)
    held = _min_over(value, first, stop, last)
    at = np.minimum(corner, np.minimum(np.append(held, np.inf), np.append(np.inf, held)))
    return held, at


def _min_over(value: Array, first: NDArray[np.int64], stop: NDArray[np.int64], count: int) -> Array:
    """Return for each of (count,) cells the minimum of the values whose ranges, first to stop, contain it; else inf.

    A range is the union of two ranges whose length is a power of two; each is split into halves, level by level.
    """
    power = np.int64(np.log2(stop - first))
    table = np.full((int(power.max()) + 1, count), np.inf)
    np.minimum.at(table, (power, first), value)
    np.minimum.at(table, (power, stop - (1 << power)), value)
    for level in range(len(table) - 1, 0, -1):
        half = 1 << (level - 1)
        np.minimum(table[level - 1], table[level], out=table[level - 1])
        np.minimum(table[level - 1, half:], table[level, :-half], out=table[level - 1, half:])
    return np.asarray(table[0])


def averaged(knots: Knots, arrival: Array, places: Array, window: float) -> tuple[Array, Array]:
    """Return times (k,), s, and speeds (k,), m/s, of the running mean over *window* (s) at *places* (k,), m.

    *arrival* (k,), s: times at which the law of *knots* reaches the places.
    """
    low, high = arrival.copy(), arrival + window
    time, open_ = arrival + 0.5 * window, np.arange(len(places))
    for _ in range(_STEPS):
        at = time[open_]
        mean, speed = _running(knots, at, window)
        off = mean - places[open_]
        low[open_[off <= 0.0]], high[open_[off >= 0.0]] = at[off <= 0.0], at[off >= 0.0]
        better = at - off / np.maximum(speed, 1e-12)
        inside = (better > low[open_]) & (better < high[open_])
        time[open_] = np.where(inside, better, 0.5 * (low[open_] + high[open_]))
        open_ = open_[np.abs(time[open_] - at) > 1e-9 * window]
        if len(open_) == 0:
            break
    return np.maximum.accumulate(time), _running(knots, time, window)[1]


def _running(knots: Knots, time: Array, window: float) -> tuple[Array, Array]:
    """Return the mean place over the *window* before *time* (n,), and its speed."""
    place, area = _evaluated(knots, time)
    before, less = _evaluated(knots, time - window)
    return (area - less) / window, (place - before) / window


def _evaluated(knots: Knots, time: Array) -> tuple[Array, Array]:
    """Return place and its integral at *time* (n,); at rest before the start."""
    row = np.searchsorted(knots.time, time, side="right") - 1
    u = np.where(row < 0, 0.0, time - knots.time[row])
    row = np.maximum(row, 0)
    s, v, a = knots.place[row], knots.speed[row], knots.acceleration[row]
    place = s + u * (v + 0.5 * a * u)
    return place, knots.area[row] + u * (s + u * (0.5 * v + a * u / 6.0))
