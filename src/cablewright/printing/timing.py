"""The fastest time law of a path within speed limits, an acceleration limit and a rule for corners.

The acceleration limits the change of speed along the path. The rule for corners is the junction deviation of GRBL (S.
Jeon, 2011): the speed at which an arc that touches both moves and passes the corner at a given distance has that
acceleration. As in Klipper, the arc takes at most half of the shorter move; otherwise the many small corners of a
finely divided circle would allow a higher speed than the circle itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.printing.jerk import Knots, averaged, refined, widened
from cablewright.printing.path import Samples


@dataclass(frozen=True, eq=False)
class TimeLaw:
    """The time law of a path: arrival and speed at each of k samples. Read-only arrays."""

    time: Array  # (k,) s, of arrival at the sample; 0 at the first
    speed: Array  # (k,) m/s, 0 at both ends and where the machine dwells
    duration: float  # s, with the dwell at the last sample
    vector: Array | None = None  # (k, 3) m/s^2, at each sample, of a law whose acceleration is continuous; else None


def time_law(
    samples: Samples,
    acceleration: float,
    corner_deviation: float = 5e-3,
    jerk: float | None = None,
    room: Room = MEMORY,
    at_samples: Array | None = None,
) -> TimeLaw:
    """Return the fastest time law from rest to rest.

    ``acceleration`` (m/s^2) limits the change of speed along the path and, with ``corner_deviation`` (m), the speed at
    corners. Between two samples the speed may rise above both and fall again, but never above the segment's limit.
    ``jerk`` (m/s^3) limits the change of acceleration along the path: see `printing/jerk.py`; such a law is computed in
    memory. ``room``: folder for the arrays of any other law. ``at_samples``: (k,) m/s, further limits at the samples,
    inf for none.
    """
    limit = samples.speed_limit[1:]  # (k - 1,)
    corner = corner_speeds(samples, acceleration, corner_deviation, room)
    if at_samples is not None:
        np.minimum(corner, at_samples, out=corner)
    corner[0] = corner[-1] = 0.0
    for at in blocks(len(samples)):
        corner[at][samples.dwell[at] > 0] = 0.0
    if jerk is not None:
        return _smooth(samples, limit, corner, acceleration, 2.0 * acceleration / jerk)
    time, speed = room.empty((len(samples),)), room.empty((len(samples),))
    _square_speeds(samples.distance, limit, corner, acceleration, speed)
    time[0] = 0.0
    for at in blocks(len(samples) - 1):
        ends = slice(at.start, at.stop + 1)
        ride = _ride(samples.distance[ends], limit[at], speed[ends], acceleration)
        speed[at] = ride.speed[:-1]
        time[ends] = np.cumsum(np.concatenate([time[at.start : at.start + 1], ride.spent + samples.dwell[at]]))
        let_go((samples, corner, time, speed))
    speed[-1] = np.sqrt(speed[-1])
    return _frozen(time, speed, samples.dwell[-1])


def times_on_way(samples: Samples, law: TimeLaw, block: slice) -> tuple[Array, Array]:
    """Return the travel time (b,), s, to each of a *block* of samples from the one before, and the dwell there."""
    time, dwell = (each[max(block.start - 1, 0) : block.stop] for each in (law.time, samples.dwell))
    spent = np.diff(time) - dwell[:-1]
    return (spent, dwell[1:]) if block.start else (np.concatenate([[0.0], spent]), dwell)


def _square_speeds(distance: Array, limit: Array, corner: Array, acceleration: float, found: Array) -> None:
    """Write to *found* (k,), m^2/s^2, the greatest squares of speeds at *distance* (k,), m, within all limits.

    These are *limit* (k - 1,) of segments and *corner* (k,) of places, m/s, and a rise and a fall by 2 a per metre.
    """
    least = np.inf
    for at in blocks(len(distance)):
        allowed, slope = _allowed(limit, corner, at), 2 * acceleration * distance[at]
        rising = np.minimum.accumulate(np.minimum(allowed - slope, least))
        found[at], least = rising + slope, rising[-1]
        let_go((distance, limit, corner, found))
    least = np.inf
    for at in reversed(tuple(blocks(len(distance)))):
        allowed, slope = _allowed(limit, corner, at), 2 * acceleration * distance[at]
        falling = np.minimum.accumulate(np.minimum(allowed + slope, least)[::-1])[::-1]
        found[at], least = np.clip(np.minimum(found[at], falling - slope), 0.0, allowed), falling[0]
        let_go((distance, limit, corner, found))


def _allowed(limit: Array, corner: Array, at: slice) -> Array:
    """The greatest squares of speeds (b,) at places, by their corners and the segments about them."""
    allowed = np.asarray(corner[at] ** 2)
    near, first = limit[max(at.start - 1, 0) : at.stop], int(at.start == 0)
    inside = allowed[first : first + len(near) - 1]  # all but the ends of the path
    np.minimum(inside, np.minimum(near[:-1], near[1:]) ** 2, out=inside)
    return allowed


class _Ride(NamedTuple):
    """The fastest speeds along a path within its limits and an acceleration."""

    speed: Array  # (k,) m/s at each place
    peak: Array  # (k - 1,) m/s on each segment
    level: Array  # (k - 1,) m at the peak speed
    spent: Array  # (k - 1,) s on each segment


def _ride(distance: Array, limit: Array, squared: Array, acceleration: float) -> _Ride:
    """Return the speeds by `_square_speeds` (k,), at *distance* (k,), m, and within *limit* (k - 1,), m/s, between."""
    segment, speed = np.diff(distance), np.sqrt(squared)
    begin, end = speed[:-1], speed[1:]
    mean_square = (squared[:-1] + squared[1:]) / 2
    peak = np.sqrt(np.minimum(limit**2, acceleration * segment + mean_square))
    np.maximum(peak, np.maximum(begin, end), out=peak)  # against rounding
    level = np.maximum(0.0, segment - (peak**2 - mean_square) / acceleration)
    spent = (2 * peak - begin - end) / acceleration + level / peak
    return _Ride(speed, peak, level, np.maximum(spent, segment / limit))  # rounding never makes a duration zero


def _smooth(samples: Samples, limit: Array, corner: Array, acceleration: float, window: float) -> TimeLaw:
    """Return the running mean over *window* (s) of a law within limits that are widened by *window*."""
    corner = np.where(corner <= 0.25 * acceleration * window, 0.0, corner)  # a stop is faster
    places = refined(samples.distance, limit, corner, window)
    own = np.searchsorted(places, samples.distance)
    limits = limit[np.clip(np.searchsorted(samples.distance, places[:-1], side="right") - 1, 0, len(limit) - 1)]
    corners = np.full(len(places), np.inf)
    corners[own] = corner
    limits, corners = widened(places, limits, corners, window)
    squared = np.empty(len(places))
    _square_speeds(places, limits, corners, acceleration, squared)
    ride = _ride(places, limits, squared, acceleration)
    pause = np.zeros(len(places))
    pause[own] = np.where(corner == 0.0, window + samples.dwell, 0.0)
    pause[0] = samples.dwell[0]
    knots, arrival, _ = _knots(places, ride, pause, acceleration)
    time, speed = averaged(knots, arrival[own], samples.distance, window)
    stops = corner == 0.0
    time[stops], speed[stops] = arrival[own][stops] + window, 0.0
    time[0] = 0.0
    time = np.maximum.accumulate(time)
    return _frozen(time, np.maximum(speed, 0.0), samples.dwell[-1])


def pieces(samples: Samples, law: TimeLaw, acceleration: float, rows: slice) -> tuple[Knots, NDArray[np.int64]]:
    """Return the motion from the arrival at the first of some *rows* on, and the segment of each piece of it.

    *law*: time law by `time_law` under that *acceleration*, m/s^2, without a limit of the jerk. Places are relative to
    the first row's, and segments are numbered from there.
    """
    places = samples.distance[rows] - samples.distance[rows.start]
    limit = samples.speed_limit[rows][1:]
    ride = _ride(places, limit, law.speed[rows] ** 2, acceleration)
    knots, _, segment = _knots(places, ride, samples.dwell[rows], acceleration)
    return knots._replace(time=knots.time + law.time[rows.start]), segment


def _knots(places: Array, ride: _Ride, pause: Array, acceleration: float) -> tuple[Knots, Array, NDArray[np.int64]]:
    """Return rise, level and fall of each segment with a *pause* (k,), s, at its end; arrival times (k,), s; segments.

    The last are those of the pieces, by number.
    """
    begin, end, peak = ride.speed[:-1], ride.speed[1:], ride.peak
    rise, fall = (peak - begin) / acceleration, (peak - end) / acceleration
    level = ride.spent - rise - fall
    duration = np.stack([rise, level, fall, pause[1:]], axis=1).ravel()
    start = np.concatenate([[pause[0]], pause[0] + np.cumsum(duration)])
    climbed, passed = 0.5 * (begin + peak) * rise, ride.level
    base, none = places[:-1], np.zeros_like(rise)
    place = np.stack([base, base + climbed, base + climbed + passed, places[1:]], axis=1).ravel()
    speed = np.stack([begin, peak, peak, none], axis=1).ravel()
    change = np.stack([none + acceleration, none, none - acceleration, none], axis=1).ravel()
    area = duration * (place + duration * (0.5 * speed + change * duration / 6.0))
    kept = np.append(np.flatnonzero(duration > 0.0), len(duration) - 1)
    knots = Knots(start[kept], place[kept], speed[kept], change[kept], (np.cumsum(area) - area)[kept])
    return knots, np.concatenate([[pause[0]], start[3::4]]), kept // 4


def _frozen(time: Array, speed: Array, last_dwell: float) -> TimeLaw:
    for column in (time, speed):
        column.setflags(write=False)
    return TimeLaw(time, speed, float(time[-1] + last_dwell))


def corner_speeds(samples: Samples, acceleration: float, corner_deviation: float, room: Room = MEMORY) -> Array:
    """Return the maximum speed (k,), m/s, at each sample by the corner there; inf within a move."""
    speeds = room.empty((len(samples),))
    speeds[:] = np.inf
    let_go(speeds)
    corners = _corners(samples.move)
    bounds = samples.distance[np.concatenate([[0], corners, [len(samples) - 1]])]
    for some in blocks(len(corners)):
        at, moves = corners[some], np.diff(bounds[some.start : some.stop + 2])
        before = _direction(samples.positions[at] - samples.positions[at - 1])
        after = _direction(samples.positions[at + 1] - samples.positions[at])
        shorter = np.minimum(moves[:-1], moves[1:])  # of the two moves, m
        sine = np.linalg.norm(after - before, axis=1) / 2  # of half the turning angle
        cosine = np.linalg.norm(after + before, axis=1) / 2
        with np.errstate(divide="ignore"):
            by_deviation = corner_deviation * cosine * (1 + cosine) / sine**2  # radius, m
            by_length = shorter / 2 * cosine / sine
        speeds[at] = np.sqrt(acceleration * np.minimum(by_deviation, by_length))
        let_go((samples, speeds))
    return speeds


def _corners(move: NDArray[np.int64]) -> NDArray[np.int64]:
    """The samples between two moves, in order; *move* (k,): of each sample."""
    found = []
    for at in blocks(len(move) - 2):
        found.append(at.start + 1 + np.flatnonzero(np.diff(move[at.start + 1 : at.stop + 2])))
        let_go(move)
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def _direction(vectors: Array) -> Array:
    """Return unit vectors (n, 3)."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
