"""Polyline of a hanging line, with a bound of its distance from the curve.

An arc of length l with curvature at most k that turns by less than a radian is nowhere farther than k l^2 / 8 from its
chord; any arc is nowhere farther than l / 2. The curvature of a span with weight w per length, compliance c, tension T
and its horizontal component h is w |h| / (T^2 (1 + c T)), largest where T is smallest.
"""

from math import ceil, cos, exp, sin, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import FREE, FREE_COMPLIANCE, PHI, TAU, WEIGHT
from cablewright.kernels.statics.line.catenary import TINY, span

MAX_POINTS = 128  # of a line
EVEN_PIECES = 8  # up to this number, the rest of a section is divided evenly
LOOSER = 4.0  # factor on a tolerance that would require more points
TRIES = 40


@jit
def polyline(row, y, begin, origin, plane, ends, tolerance, points, cuts):
    """Write the free span of a solved line to *points* (MAX_POINTS, 3), world, from its sheave to the platform.

    Two of the points lie *ends* (m) along the cable from either end, or both in its middle; *cuts* (2,) receives their
    indices. *begin*, *origin* (3,), m, world, and *plane* are those of `shape_line`. Returns the number of points and a
    bound of the distance between curve and polyline, m: at most *tolerance* unless that requires too many points.
    """
    t = exp(y[TAU])
    h, v = t * cos(y[PHI]), t * sin(y[PHI])
    x0, z0 = begin
    if row[WEIGHT] == 0.0:
        return _straight(origin, x0, z0, plane, ends, points, cuts), 0.0
    count, bound = 0, 0.0
    for _ in range(TRIES):
        count, bound = _walk(row, h, v, y[FREE], x0, z0, origin, plane, ends, tolerance, points, cuts)
        if bound <= tolerance:
            break
        tolerance *= LOOSER
    return count, bound


@jit
def _walk(row, h, v, length, x0, z0, origin, plane, ends, tolerance, points, cuts):
    """As `polyline`, of a line with weight that starts at (x0, z0) with the force (h, v)."""
    weight, compliance = row[WEIGHT], row[FREE_COMPLIANCE]
    _put(origin, plane, x0, z0, points, 0)
    near = min(ends, 0.5 * length)
    count, done, bound = 1, 0.0, 0.0
    for section in range(3):
        stop = near if section == 0 else (length - near if section == 1 else length)
        while done < stop:
            piece = stop - done
            error = chord_error(h, v + weight * done, piece, weight, compliance)
            while error > tolerance and count < MAX_POINTS - 3 + section:
                parts = ceil(sqrt(error / tolerance))
                piece /= parts if parts <= EVEN_PIECES else 2.0
                error = chord_error(h, v + weight * done, piece, weight, compliance)
                if parts <= EVEN_PIECES:
                    break
            bound = max(bound, error)
            done = stop if piece >= stop - done else done + piece
            x, z, _, _, _, _, _, _ = span(h, v, done, weight, compliance)
            _put(origin, plane, x0 + x, z0 + z, points, count)
            count += 1
        if section < 2:
            cuts[section] = count - 1
    return count, bound


@jit
def chord_error(h, v, length, weight, compliance):
    """Return a bound of the distance, m, between a hanging span and its chord, from the force (h, v) at its start."""
    end = v + weight * length
    first, last = sqrt(h * h + v * v), sqrt(h * h + end * end)
    lowest = abs(h) if v * end < 0.0 else min(first, last)
    arc = length * (1.0 + compliance * max(first, last))
    curvature = weight * abs(h) / (lowest * lowest * (1.0 + compliance * lowest) + TINY)
    if curvature * arc > 1.0:
        return 0.5 * arc
    return 0.125 * curvature * arc * arc


@jit
def _straight(origin, x0, z0, plane, ends, points, cuts):
    """As `polyline`, of a line without weight: four points. Returns their number."""
    x, z = plane[2] - x0, plane[3] - z0
    length = sqrt(x * x + z * z)
    near = min(ends / max(length, TINY), 0.5)
    for k in range(4):
        share = 0.0 if k == 0 else (near if k == 1 else (1.0 - near if k == 2 else 1.0))
        _put(origin, plane, x0 + share * x, z0 + share * z, points, k)
    cuts[0], cuts[1] = 1, 2
    return 4


@jit
def _put(origin, plane, x, z, points, k):
    points[k, 0] = origin[0] + plane[0] * x
    points[k, 1] = origin[1] + plane[1] * x
    points[k, 2] = origin[2] + z
