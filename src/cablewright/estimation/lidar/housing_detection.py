"""Detection of a lidar's own housing in its scan: short runs of nearly constant range, not on a straight wall."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.lidar.scan import Points
from cablewright.foundation.arrays import Array
from cablewright.kernels.fitting.scan_lines import axis

_FARTHEST: Final = 0.5  # m, of a device's own parts
_SHARE: Final = 0.3  # of the median range, likewise
_MIN_POINTS: Final = 3
_MAX_STEP: Final = 0.05  # m, between successive ranges of one part
_CONSTANT: Final = 0.12  # of the range, scatter of one part about its median
_STRAIGHT: Final = 0.4  # m, length from which a run that a line explains better is a wall


class Housing(NamedTuple):
    """A part of the device itself that hides a range of bearings of its lidar."""

    begin: float  # rad, half a ray before its first point
    end: float  # rad, counter-clockwise from there
    distance: float  # m, median
    points: int


def find_housing(points: Points) -> tuple[Housing, ...]:
    """Return the parts of the device itself in a scan, by bearing from its first point on."""
    n = len(points)
    if n < 2 * _MIN_POINTS:
        return ()
    limit = min(_FARTHEST, _SHARE * float(np.quantile(points.distance, 0.75)))
    step, far = points.bearing_step, points.distance
    usual = float(np.median(step))
    apart = (np.abs(np.diff(far)) > _MAX_STEP) | (step[:-1] > 4.0 * usual + 0.01)
    runs = np.split(np.arange(n), np.flatnonzero(apart) + 1)
    # A run over the seam: the first and the last point are neighbours where the widest gap is a usual one.
    if len(runs) > 1 and step[-1] <= 4.0 * usual + 0.01 and abs(far[0] - far[-1]) <= _MAX_STEP:
        runs[0] = np.concatenate([runs.pop(), runs[0]])
    found = []
    for run in runs:
        if len(run) < _MIN_POINTS or far[run].max() > limit or not _is_own(points.xy[run], far[run]):
            continue
        bearing = np.arctan2(points.ray[run[[0, -1]], 1], points.ray[run[[0, -1]], 0])
        half = 0.5 * usual
        begin = math.degrees(float(bearing[0]) - half) % 360.0
        width = math.degrees(float(bearing[1] - bearing[0]) % math.tau + 2.0 * half)
        found.append(Housing(math.radians(begin), math.radians(begin + width), float(np.median(far[run])), len(run)))
    return tuple(found)


def _is_own(xy: Array, far: Array) -> bool:
    """Whether a run is nearly constant, and no straight wall."""
    middle = float(np.median(far))
    if float(np.median(np.abs(far - middle))) > _CONSTANT * middle:
        return False
    d = xy - xy.mean(axis=0)
    angle, larger = axis(float(d[:, 0] @ d[:, 0]), float(d[:, 0] @ d[:, 1]), float(d[:, 1] @ d[:, 1]))
    along = d @ np.array([math.cos(angle), math.sin(angle)])
    beside = math.sqrt(max(float((d * d).sum()) - larger, 0.0) / len(d))
    straight = float(np.ptp(along)) >= _STRAIGHT and beside < float(np.std(far))
    return not straight
