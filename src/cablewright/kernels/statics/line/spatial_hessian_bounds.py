"""Bounds of second derivatives of a line out of the vertical plane, and its unknowns from another solution's.

The equations for the end of a span, and its force on the platform, are taken along its chord and across it, where it is
stiff and soft. Moments are about the platform point at the centre. Nothing here is compiled for a robot without such
lines: see `Packed`.
"""

from math import sqrt

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import ROUNDING, add, div, mag, mul, point, sub
from cablewright.kernels.certificates.jets import BENT, OWN, OWN_BENT, PAIRS, SLOPED, cross, dot, of
from cablewright.kernels.layout import GUIDE, UPRIGHT
from cablewright.kernels.statics.line.hessian_bounds import TURNED
from cablewright.kernels.statics.line.spatial_enclosure import enclose_spatial, frame_of, span_at, tangent_of

LENGTH, MOMENT, FORCE = 2, 4, 5  # rows: of lengths, of a swivel's moment, and the first of the force
GAPS = (0, 1, 3)  # rows: of the span's end along the chord and twice across
PART, PARTS = 0.04, 8  # half width of a relative tension that is enclosed together, and the largest number of parts
LOCAL_PAIRS = np.where(PAIRS < OWN, PAIRS, PAIRS - 3)  # a line's variables: its own unknowns, then three rotations


@jit
def frame_spatial(general, row, y, axes):
    """Write unit vectors along the chord and across it to *axes* (3, 3). False of a planar line, also below."""
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    c, s, ca, sa, _ = tangent_of(row, y)
    axes[0, 0], axes[0, 1], axes[0, 2] = c * ca, c * sa, s
    axes[1, 0], axes[1, 1], axes[1, 2] = -sa, ca, 0.0
    axes[2, 0], axes[2, 1], axes[2, 2] = -s * ca, -s * sa, c
    return True


@jit
def share_spatial(general, row, own, wrench, turned, slack, arm, axes, out):
    """Write the absolute entries of Y at a line's rows to *out*, from those at its equations (k,) and at the balance.

    *turned*: the size of the entries at the moments; *slack*: of all that were added up.
    """
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    out[:] = 0.0
    out[LENGTH], out[TURNED] = abs(own[2]), turned
    if own.shape[0] > MOMENT:
        out[MOMENT] = abs(own[4])
    gap, force = abs(own[0]) + abs(own[1]) + abs(own[3]), slack + abs(wrench[0]) + abs(wrench[1]) + abs(wrench[2])
    a, b, c = (wrench[3], wrench[4], wrench[5]) if turned > 0.0 else (0.0, 0.0, 0.0)
    x, y = wrench[0] + b * arm[2] - c * arm[1], wrench[1] + c * arm[0] - a * arm[2]
    z = wrench[2] + a * arm[1] - b * arm[0]
    for k in range(3):
        e = axes[k]
        out[GAPS[k]] = abs(own[0] * e[0] + own[1] * e[1] + own[3] * e[2]) + 4e-15 * gap
        out[FORCE + k] = abs(x * e[0] + y * e[1] + z * e[2]) + 4e-15 * force
    return True


@jit
def box_spatial(general, row, start, end, first, radius, reach, whole, box):
    """Write *radius*, if *whole* plus *reach*, of a line's unknowns from *start* to *end*, and of the rotations."""
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    box[:] = 0.0
    for k in range(start, end):
        box[k - start] = (radius[k] + (reach[k] if whole else 0.0)) * ROUNDING
    for k in range(first + 3, radius.shape[0]):
        box[OWN + k - first - 3] = (radius[k] + (reach[k] if whole else 0.0)) * ROUNDING
    return True


@jit
def bend_spatial(general, row, y, i, pose, omega, cert, work):
    """Write bounds of the second derivatives of line *i* over its box to work.bends.

    Returns 1, 0 where one is not bounded, or -1 for a planar line.
    """
    if general is None or row[GUIDE] == UPRIGHT:
        return -1
    return 1 if omega <= 1.0 and _bend(row, y, i, pose, omega, cert, work) else 0


@jit(allocates=True)
def _bend(row, y, i, pose, omega, cert, work):
    n, start, end, first = pose.shape[0], cert.offsets[i], cert.offsets[i + 1], cert.offsets[-1]
    rows = OWN_BENT if n == 3 else BENT
    equations, wrench, radius = np.zeros((OWN, rows, 2)), np.zeros((6, rows, 2)), np.zeros(n)
    for k in range(n):
        radius[k] = (work.reach[first + k] + work.margin[first + k]) * ROUNDING
    given = (pose, radius, omega, cert.rotation, 0.0, work.arms[i])
    centre, box, wide = cert.centre[start:end].copy(), work.boxes[i].copy(), work.boxes[i, 1]
    if not wide < np.inf:
        return False
    parts = int(min(PARTS, 1.0 + wide / PART))
    work.bends[i] = 0.0
    for j in range(parts):
        centre[1], box[1] = wide * (2 * j + 1 - parts) / parts, wide / parts * ROUNDING
        enclose_spatial(row, y, centre, box, given, cert.arm, cert.moved, equations, wrench)
        if not _widen(equations, wrench, work.axes[i], n, work.bends[i]):
            return False
    return True


@jit
def _widen(equations, wrench, axes, n, bends):
    """Raise *bends* to the second derivatives in the jets of a line; False where one is not bounded."""
    for k in range(equations.shape[1] - SLOPED):
        at = SLOPED + k
        _raise(bends, LENGTH, k, mag(of(equations[2], at)))
        _raise(bends, MOMENT, k, mag(of(equations[4], at)))
        for j in range(3):
            e = axes[j]
            gap = _along(e, of(equations[0], at), of(equations[1], at), of(equations[3], at))
            _raise(bends, GAPS[j], k, mag(gap))
            _raise(bends, FORCE + j, k, mag(_along(e, of(wrench[0], at), of(wrench[1], at), of(wrench[2], at))))
        if n == 6:
            x, y, z = mag(of(wrench[3], at)), mag(of(wrench[4], at)), mag(of(wrench[5], at))
            _raise(bends, TURNED, k, sqrt(x * x + y * y + z * z) * ROUNDING)
        for j in range(bends.shape[0]):
            if not bends[j, k] < 1e300:
                return False
    return True


@jit
def _raise(bends, row, k, value):
    if not value <= bends[row, k]:  # NaN is not bounded
        bends[row, k] = value


@jit
def _along(e, x, y, z):
    """Component of the vector of intervals along *e*."""
    return add(add(mul(point(e[0]), x), mul(point(e[1]), y)), mul(point(e[2]), z))


@jit
def between_spatial(general, row, other, y, unknowns, bound, centre, out):
    """Write the differences (k, 2) of a line's unknowns from those of the *centre*, in the frame of its state *y*.

    *unknowns*, *bound* (k,): those of another solution, whose state is *other*, and of their errors.
    """
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    _compare(row, other, y, unknowns, bound, centre, out)
    return True


@jit(allocates=True)
def _compare(row, other, y, unknowns, bound, centre, out):
    way, tension, _ = span_at(row, other, unknowns, bound, SLOPED)
    ahead, aside, third = frame_of(row, y)
    along = of(dot(way, cross(aside, third)), 0)  # Cramer's rule: the frame is orthogonal up to rounding alone
    if not along[0] > 0.0:
        along = (-1.0, 1.0)  # a way that may be reversed: no bound
    first, last = of(dot(way, cross(third, ahead)), 0), of(dot(way, cross(ahead, aside)), 0)
    out[0, 0], out[0, 1] = div(first, along)
    out[3, 0], out[3, 1] = div(last, along)
    out[1, 0], out[1, 1] = sub(div(of(tension, 0), point(tangent_of(row, y)[4])), (1.0, 1.0))
    for k in range(unknowns.shape[0]):
        if k == 2 or k == 4:
            far = sub(point(unknowns[k]), point(centre[k]))
            out[k, 0], out[k, 1] = add(far, (-bound[k], bound[k]))
