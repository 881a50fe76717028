"""Target point of a control loop on a path with a time law, and distances from the path in plan view."""

from math import copysign, inf, nan, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit

SAME = 1e-12  # m^2: of points at equal squared distances the one nearest along the path counts

# Numbers of a target: its place, m, with the height offset, and mean velocity, m/s; accelerations at both ends of the
# step, m/s^2; the places of the path there; distance along the path, m, speed along it and of the strand, m/s; layer;
# and whether material is laid.
PLACE, VELOCITY, ACCELERATIONS, HERE, THERE = 0, 3, 6, 12, 15
DISTANCE, SPEED, FLOW, LAYER, LAYS = 18, 19, 20, 21, 22
TARGET = 23


class TrackArrays(NamedTuple):
    """A path of k - 1 straight pieces between k points, as arrays; see `cablewright.printing.arc_length_path.Track`.

    Read-only.
    """

    positions: NDArray[np.float64]  # (k, 3) m
    distance: NDArray[np.float64]  # (k,) m
    layer: NDArray[np.int32]  # (k - 1,)
    laying: NDArray[np.bool_]  # (k - 1,)
    along_x: NDArray[np.float64]  # (k - 1,)
    along_y: NDArray[np.float64]  # (k - 1,)
    level: NDArray[np.float64]  # (k - 1,) m


class LawArrays(NamedTuple):
    """The time law of a path at its k points: times of arrival and departure, s, and speeds, m/s. Read-only arrays."""

    start: NDArray[np.float64]  # (k,)
    arrival: NDArray[np.float64]  # (k,)
    speed: NDArray[np.float64]  # (k,)
    vector: NDArray[np.float64]  # (k, 3) m/s^2, of a shaped path; (0, 3): none


@jit
def count_until(values, limit):
    """Return how many of the rising *values* (k,) are at most *limit*."""
    low, high = 0, values.shape[0]
    while low < high:
        middle = (low + high) // 2
        if limit < values[middle]:
            high = middle
        else:
            low = middle + 1
    return low


@jit
def count_below(values, limit):
    """Return how many of the rising *values* (k,) are less than *limit*."""
    low, high = 0, values.shape[0]
    while low < high:
        middle = (low + high) // 2
        if values[middle] < limit:
            low = middle + 1
        else:
            high = middle
    return low


@jit
def piece_at(track, distance):
    """Return the index of the piece of the path at a *distance*, m, along it.

    At a point between two pieces it is the one that begins there; beyond the ends the first or last.
    """
    return min(max(count_until(track.distance, distance) - 1, 0), track.layer.shape[0] - 1)


@jit
def distance_at(track, law, time):
    """Return the distance along the path, m, at a *time*, s, of the time law.

    Cubic Hermite interpolation between two points: exact for constant acceleration or speed.
    """
    i = min(max(count_until(law.arrival, time) - 1, 0), law.arrival.shape[0] - 2)
    left, begin = law.start[i], track.distance[i]
    if time <= left:
        return begin
    whole, rise = law.arrival[i + 1] - left, track.distance[i + 1] - begin
    u = min((time - left) / whole, 1.0)
    a, b = law.speed[i] * whole, law.speed[i + 1] * whole
    along = u * (a + u * (3.0 * rise - 2.0 * a - b + u * (a + b - 2.0 * rise)))
    return begin + min(max(along, 0.0), rise)


@jit
def accelerate(law, time, found):
    """Write the acceleration vector (3,), m/s^2, at a *time*, s, of the time law to *found*.

    It is linear between two points.
    """
    i = min(max(count_until(law.arrival, time) - 1, 0), law.arrival.shape[0] - 2)
    left, reached = law.start[i], law.arrival[i + 1]
    share = min(max((time - left) / (reached - left), 0.0), 1.0)
    for k in range(3):
        found[k] = law.vector[i, k] + share * (law.vector[i + 1, k] - law.vector[i, k])


@jit
def put_place(track, distance, found):
    """Write the position (3,), m, at a *distance*, m, along the path to *found*; clamped at both ends of the path."""
    i = piece_at(track, distance)
    begin = track.distance[i]
    whole = track.distance[i + 1] - begin
    into = min(max(distance - begin, 0.0), whole)
    for k in range(3):
        found[k] = track.positions[i, k] + (track.positions[i + 1, k] - track.positions[i, k]) / whole * into


@jit
def advance(track, law, begin, end, dt, lead, factor, height, found):
    """Write the target (TARGET,) on the path that moves from *begin* to *end*, s, of the time law in *dt*, s.

    *lead*: s, of the pressure advance; *factor*: of the law's speed; *height*: m, above the path.
    """
    now, then = distance_at(track, law, begin), distance_at(track, law, end)
    put_place(track, now, found[HERE:])
    put_place(track, then, found[THERE:])
    piece = piece_at(track, 0.5 * (now + then))
    for k in range(3):
        found[PLACE + k] = found[HERE + k]
        found[VELOCITY + k] = (found[THERE + k] - found[HERE + k]) / dt
        found[ACCELERATIONS + k] = found[ACCELERATIONS + 3 + k] = 0.0
    found[PLACE + 2] += height
    if law.vector.shape[0] > 0:
        accelerate(law, begin, found[ACCELERATIONS:])
        accelerate(law, end, found[ACCELERATIONS + 3 :])
        for k in range(6):
            found[ACCELERATIONS + k] *= factor * factor
    found[DISTANCE], found[SPEED] = now, (then - now) / dt
    found[LAYER], found[LAYS] = track.layer[piece], 1.0 if track.laying[piece] else 0.0
    found[FLOW] = found[SPEED] if track.laying[piece] else 0.0
    if lead != 0.0:
        early, late = distance_at(track, law, begin + lead), distance_at(track, law, end + lead)
        found[FLOW] = (late - early) / dt if track.laying[piece_at(track, 0.5 * (early + late))] else 0.0


@jit
def nearest(track, x, y, around, within):
    """Return the distance along the path, m, of its point nearest to (x, y), m, in plan view, and the offset, m.

    Only pieces up to *within* (m) along the path from the distance *around* (m) count. Beyond the path's ends the
    offset is from the path's straight continuation. A point above a vertical piece is at its lower end.
    """
    first = piece_at(track, around - within)
    stop = max(first + 1, min(count_below(track.distance, around + within), track.layer.shape[0]))
    least = inf
    for i in range(first, stop):
        squared = _beside(track, i, x, y)[3]
        if squared < least:
            least = squared
    chosen, nearby = first, inf
    for i in range(first, stop):
        along, _, _, squared = _beside(track, i, x, y)
        if squared <= least + SAME:
            away = abs(_reached(track, i, along) - around)
            if away < nearby:
                chosen, nearby = i, away
    along, off_x, off_y, squared = _beside(track, chosen, x, y)
    return _reached(track, chosen, along), _signed(track, chosen, along, off_x, off_y, squared)


@jit
def nearest_rows(track, points, around, within, distances, offsets):
    """Write `nearest` of *points* (k, 2 or more), m, to *distances* and *offsets* (k,); NaN of unknown points."""
    for j in range(points.shape[0]):
        distances[j] = offsets[j] = nan
        if points[j, 0] - points[j, 0] == 0.0 and points[j, 1] - points[j, 1] == 0.0 and around[j] - around[j] == 0.0:
            distances[j], offsets[j] = nearest(track, points[j, 0], points[j, 1], around[j], within)


@jit
def _beside(track, i, x, y):
    """Return how far into piece *i* the point nearest to (x, y) is, m, the offset from it, and that squared, m^2."""
    ux, uy = track.along_x[i], track.along_y[i]
    off_x, off_y = x - track.positions[i, 0], y - track.positions[i, 1]
    along = min(max(off_x * ux + off_y * uy, 0.0), track.level[i])
    off_x -= along * ux
    off_y -= along * uy
    return along, off_x, off_y, off_x * off_x + off_y * off_y


@jit
def _reached(track, i, along):
    """Return the distance along the path of the point *along* m, in plan view, into piece *i*."""
    whole, begin = track.level[i], track.distance[i]
    return begin + along * (track.distance[i + 1] - begin) / whole if whole != 0.0 else begin


@jit
def _signed(track, i, along, x, y, squared):
    """Return the offset (x, y) from a point of piece *i* with its sign: at a corner, left of the mean direction."""
    ux, uy = track.along_x[i], track.along_y[i]
    if along <= 0.0:
        if i == 0:
            return ux * y - uy * x
        ux, uy = ux + track.along_x[i - 1], uy + track.along_y[i - 1]
    elif along >= track.level[i]:
        if i + 1 == track.layer.shape[0]:
            return ux * y - uy * x
        ux, uy = ux + track.along_x[i + 1], uy + track.along_y[i + 1]
    return copysign(sqrt(squared), ux * y - uy * x)
