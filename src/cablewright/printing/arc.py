"""Arcs of G2 and G3 as straight pieces: the centre from I and J or from R, then equal sub-arcs."""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.arrays import Array

_ROUNDING = 5e-6  # m, tolerance for files with three decimals of a millimetre, as in GRBL
_SAME_POINT = 1e-9  # m, distance from start to end below which an arc is a full circle
_WIDEST_PIECE = math.pi / 32  # rad, so that a circle of any size keeps its shape, and its length to 0.04 %

Point2 = tuple[float, float]


class ArcError(ValueError):
    """Error: the words of an arc describe no arc; the message has the allowed forms."""


def centre_from_offset(start: Point2, end: Point2, offset: Point2) -> Point2:
    """Return the centre (m) at ``offset`` (I, J) from the start. Raises `ArcError` where the end misses the circle."""
    radius = math.hypot(*offset)
    if radius == 0:
        raise ArcError("an arc of zero radius; I and J must not both be 0")
    centre = (start[0] + offset[0], start[1] + offset[1])
    miss = abs(math.dist(end, centre) - radius)
    if miss > max(_ROUNDING, 1e-3 * radius):
        raise ArcError(f"the end is {miss * 1e3:.6g} mm off the circle about I, J; 0.005 mm or 0.1 % is allowed")
    return centre


def centre_from_radius(start: Point2, end: Point2, radius: float, clockwise: bool) -> Point2:
    """Return the centre (m) of the arc of ``radius``; a negative one is the arc of more than half a turn.

    Raises `ArcError` for a zero radius, a full circle (undefined by R) and a radius too small for the end.
    """
    chord = math.dist(start, end)
    if radius == 0:
        raise ArcError("an arc of zero radius; R must not be 0")
    if chord <= _SAME_POINT:
        raise ArcError("a full circle has no centre by R; give I and J")
    half = chord / 2
    if half > abs(radius) + _ROUNDING:
        raise ArcError(f"R is too small to reach the end: at least {half * 1e3:.6g} mm (half the chord) is needed")
    height = math.sqrt(max(0.0, (abs(radius) - half) * (abs(radius) + half)))
    left = height if clockwise == (radius < 0) else -height  # side of the centre, in the direction of the chord
    along = ((end[0] - start[0]) / chord, (end[1] - start[1]) / chord)
    return ((start[0] + end[0]) / 2 - left * along[1], (start[1] + end[1]) / 2 + left * along[0])


def swept_angle(start: Point2, end: Point2, centre: Point2, clockwise: bool) -> float:
    """Return the angle (rad) from ``start`` to ``end``: positive anticlockwise, a full turn where they coincide."""
    full = -math.tau if clockwise else math.tau
    if math.dist(start, end) <= _SAME_POINT:
        return full
    from_angle = math.atan2(start[1] - centre[1], start[0] - centre[0])
    to_angle = math.atan2(end[1] - centre[1], end[0] - centre[0])
    return math.fmod(to_angle - from_angle + full, full) or full


def piece_count(radius: float, sweep: float, rise: float, arc_step: float, arc_error: float) -> int:
    """Return the number of equal sub-arcs that replace an arc.

    They are at most ``arc_step`` (m) long, at most a 64th of a turn, and their chords deviate by at most ``arc_error``
    (m).
    """
    length = math.hypot(radius * sweep, rise)
    flattest = math.acos(max(0.0, 1 - arc_error / radius))
    widest = min(2 * flattest, _WIDEST_PIECE)
    return max(1, math.ceil(length / arc_step - 1e-9), math.ceil(abs(sweep) / widest - 1e-9) if widest > 0 else 1)


def pieces(
    start: tuple[float, float, float], end: tuple[float, float, float], centre: Point2, sweep: float, count: int
) -> Array:
    """Return the end points (count, 3), m, of equal sub-arcs, the last exactly ``end``.

    Where rounding puts the end on a slightly different circle than the start, the radius varies linearly.
    """
    fraction = np.arange(1, count + 1) / count
    first = math.dist(start[:2], centre)
    radius = first + (math.dist(end[:2], centre) - first) * fraction
    angle = math.atan2(start[1] - centre[1], start[0] - centre[0]) + sweep * fraction
    points = np.empty((count, 3))
    points[:, 0] = centre[0] + radius * np.cos(angle)
    points[:, 1] = centre[1] + radius * np.sin(angle)
    points[:, 2] = start[2] + (end[2] - start[2]) * fraction
    points[-1] = end
    return points
