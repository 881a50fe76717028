"""World positions of the lidar points in a log, from the platform's pose during each scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Scan
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.models.rotation import matrix_of

MOST: Final = 200
"""Points of one scan."""

_TURNS: Final = 2.0  # an older scan is not shown


def seen_points(
    scans: Sequence[Scan],
    lidars: Mapping[Any, LidarSettings],
    now: float,
    way: tuple[Array, Array],
    rotation: Array,
    point: Array,
) -> Array:
    """Return the points (k, 3), m, world, of the *scans* that are recent at time *now*, s.

    *way*: times (j,), s, and positions (j, 3), m, of a *point* (3,), m, platform frame; a ray's is between two of them.
    *rotation* (3,), rad: of the platform, taken as the same for the whole scan. Of each scan every so-many-th ray, at
    most `MOST` of them.
    """
    made = [np.empty((0, 3))]
    for scan in scans:
        lidar = lidars.get(scan.source)
        if lidar is None or scan.time < now - _TURNS * lidar.turn:
            continue
        every = slice(None, None, -(-len(scan.ranges) // MOST))
        arms = np.array(lidar.place) - point + scan.points[every] @ np.array(lidar.axes)
        made.append(_between(way, scan.times[every]) + arms @ matrix_of(rotation).T)
    points = np.vstack(made)
    return points[np.isfinite(points).all(axis=1)]


def _between(way: tuple[Array, Array], times: Array) -> Array:
    """Return places (k, 3) at *times*; what is before or after the way is at its end."""
    begin, end = np.searchsorted(way[0], times[[0, -1]])
    some = slice(max(int(begin) - 1, 0), int(end) + 1)
    return np.column_stack([np.interp(times, way[0][some], own) for own in way[1][some].T])
