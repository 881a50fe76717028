"""Interval enclosures of a hanging span in the frame of its start force: end point and compliance.

With T the tension at the start, in the direction phi, l the unstrained length, u = w s / T and q = w l / T, the tension
at s is T (1 + u sin phi, u cos phi) along and across phi. Nothing large cancels in this frame, even for a wide interval
of phi. See `docs/theory/exhaustive.md`.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ONE,
    ZERO,
    add,
    div,
    intersect,
    mul,
    neg,
    point,
    root,
    scale,
    sqr,
    sub,
)

PARTS = ((0.01, 1), (0.1, 4), (0.7, 16), (0.9, 48))  # upper limit of q, number of parts of a span
MAX_PARTS = 128


@jit
def hanging_span(sine, cosine, q):
    """Enclose a span's end point along and across phi, per length and without stretch, and integrals of its compliance.

    *sine*, *cosine* of phi. The integrals are A, B, C: the compliance at fixed length, times T / l and without stretch,
    is [q^2 A, q B; q B, C].
    """
    parts = MAX_PARTS
    for limit, enough in PARTS[::-1]:
        if q[1] < limit:
            parts = enough
    along, across, a, b, c = ZERO, ZERO, ZERO, ZERO, ZERO
    share = div(ONE, point(float(parts)))
    for k in range(parts):
        u = mul(q, div((float(k), float(k + 1)), point(float(parts))))
        forward, side = add(ONE, mul(u, sine)), mul(u, cosine)
        square = intersect(add(sqr(forward), sqr(side)), add(ONE, mul(u, add(scale(sine, 2.0), u))))
        size = root((max(square[0], 0.0), square[1]))
        first = div(point(2.0 * k + 1.0), point(2.0 * parts * parts))
        second = div(point(3.0 * k * k + 3.0 * k + 1.0), point(3.0 * parts * parts * parts))
        over = div(ONE, size)
        along = add(along, mul(share, _component(forward, side, size)))
        linear = mul(mul(q, first), mul(cosine, over))
        across = add(across, intersect(linear, mul(share, _component(side, forward, size))))
        cube = mul(over, sqr(over))
        a = add(a, mul(second, mul(sqr(cosine), cube)))
        b = sub(b, mul(first, mul(mul(forward, cosine), cube)))
        c = add(c, mul(share, mul(sqr(forward), cube)))
    return along, across, a, b, c


@jit
def _component(one, other, size):
    """One / sqrt(one^2 + other^2); *size* encloses the root."""
    if one[0] > 0.0 or one[1] < 0.0:
        share = div(ONE, root(add(ONE, sqr(div(other, one)))))
        return share if one[0] > 0.0 else neg(share)
    return intersect(div(one, size), (-1.0, 1.0))
