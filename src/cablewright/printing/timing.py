"""When the nozzle is where: the fastest time law within speed limits, an acceleration and a rule for corners.

The acceleration bounds the change of speed along the path. At a corner the rule is the junction deviation of GRBL (S.
Jeon, 2011): the speed at which that acceleration would carry the nozzle round an arc that touches both moves and passes
the corner at a given distance. As in Klipper, that arc may take at most half of the shorter move, else the many small
corners of a finely cut circle would be passed faster than the circle itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.printing.path import Samples

__all__ = ["TimeLaw", "corner_speeds", "time_law"]


@dataclass(frozen=True, eq=False)
class TimeLaw:
    """Arrival and speed at each of k samples. Read-only arrays."""

    time: NDArray[np.float64]  # (k,) s, when the sample is reached; 0 at the first
    speed: NDArray[np.float64]  # (k,) m/s, 0 at both ends and where the machine dwells
    duration: float  # s, with the dwell at the last sample


def time_law(samples: Samples, acceleration: float, corner_deviation: float = 5e-3) -> TimeLaw:
    """Return the fastest time law from rest to rest.

    ``acceleration`` (m/s^2) bounds the change of speed along the path and, by ``corner_deviation`` (m), the speed at
    corners. Between two samples the speed may rise above both and fall again, but never above the segment's limit.
    """
    segment = np.diff(samples.distance)  # (k - 1,)
    limit = samples.speed_limit[1:]  # (k - 1,)
    allowed = np.zeros(len(samples))  # of the squared speed at each sample
    allowed[1:-1] = np.minimum(limit[:-1], limit[1:]) ** 2
    np.minimum(allowed, corner_speeds(samples, acceleration, corner_deviation) ** 2, out=allowed)
    allowed[samples.dwell > 0] = 0.0

    # The squared speed may rise and fall by 2 a per metre: the greatest such curve below `allowed`.
    slope = 2 * acceleration * samples.distance
    rising = np.minimum.accumulate(allowed - slope) + slope
    falling = np.minimum.accumulate((allowed + slope)[::-1])[::-1] - slope
    squared = np.clip(np.minimum(rising, falling), 0.0, allowed)
    speed = np.sqrt(squared)

    begin, end = speed[:-1], speed[1:]
    mean_square = (squared[:-1] + squared[1:]) / 2
    peak = np.sqrt(np.minimum(limit**2, acceleration * segment + mean_square))
    np.maximum(peak, np.maximum(begin, end), out=peak)  # what rounding took
    level = np.maximum(0.0, segment - (peak**2 - mean_square) / acceleration)  # length passed at the peak speed
    spent = (2 * peak - begin - end) / acceleration + level / peak
    spent = np.maximum(spent, segment / limit)  # so that rounding never makes a segment free

    time = np.zeros(len(samples))
    np.cumsum(spent + samples.dwell[:-1], out=time[1:])
    for column in (time, speed):
        column.setflags(write=False)
    return TimeLaw(time, speed, float(time[-1] + samples.dwell[-1]))


def corner_speeds(samples: Samples, acceleration: float, corner_deviation: float) -> NDArray[np.float64]:
    """(k,) the greatest speed (m/s) at each sample by the corner there; inf where the path runs on straight."""
    speeds = np.full(len(samples), np.inf)
    at = np.flatnonzero(np.diff(samples.move[1:])) + 1  # samples between two moves
    if len(at) == 0:
        return speeds
    before = _direction(samples.positions[at] - samples.positions[at - 1])
    after = _direction(samples.positions[at + 1] - samples.positions[at])
    bounds = samples.distance[np.concatenate([[0], at, [len(samples) - 1]])]
    shorter = np.minimum(np.diff(bounds)[:-1], np.diff(bounds)[1:])  # of the two moves, m

    sine = np.linalg.norm(after - before, axis=1) / 2  # of half the angle turned through
    cosine = np.linalg.norm(after + before, axis=1) / 2
    with np.errstate(divide="ignore"):
        by_deviation = corner_deviation * cosine * (1 + cosine) / sine**2  # radius, m
        by_length = shorter / 2 * cosine / sine
    speeds[at] = np.sqrt(acceleration * np.minimum(by_deviation, by_length))
    return speeds


def _direction(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) unit vectors."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
