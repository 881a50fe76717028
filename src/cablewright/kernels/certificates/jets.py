"""Interval arithmetic of values together with their derivatives (automatic differentiation).

A jet is an array (k, 2): the enclosure of a quantity over a box, then those of its derivatives by a line's own unknowns
(slots 0 to 4) and by the pose (position 5 to 7, rotation 8 to 10), then those of its second derivatives by PAIRS of
slots. Rows that a jet lacks are zero: a constant has one row, and the variables decide whether there are second
derivatives. The position is in no pair, as it enters no equation but linearly. Where a value is not defined somewhere
in the box, the jet is unbounded. Moore 1966; Griewank and Walther 2008, chapters 3 and 10.
"""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ENTIRE,
    ONE,
    PI,
    ZERO,
    add,
    cos,
    div,
    mag,
    mul,
    neg,
    root,
    sin,
    sqr,
    sub,
    up,
)

OWN = 5  # slots of a line's unknowns
SLOTS = OWN + 6
BENDING = (0, 1, 2, 3, 4, 8, 9, 10)  # slots of second derivatives
PAIRS = np.array([(p, q) for k, q in enumerate(BENDING) for p in BENDING[: k + 1]])
SLOPED = 1 + SLOTS  # rows of a jet with first derivatives
BENT = SLOPED + len(PAIRS)  # rows of one with second derivatives too
OWN_BENT = SLOPED + OWN * (OWN + 1) // 2  # rows where no rotation counts
NEAR = 0.4  # sine of the largest angle from a guess: arcsin u is within u and u (1 + u^2) there
REFINEMENTS = 5  # each cubes the error of an angle's guess, at first below 0.34 rad


@jit
def of(a, k):
    """Return interval *k* of a jet: 0 is its value, 1 + s its derivative by slot s, then those by PAIRS."""
    if k < a.shape[0]:
        return a[k, 0], a[k, 1]
    return ZERO


@jit
def pair(k):
    """Return the rows of the two first derivatives that belong to row *k* of a second one."""
    return 1 + PAIRS[k - SLOPED, 0], 1 + PAIRS[k - SLOPED, 1]


@jit(allocates=True)
def constant(value):
    """Return the jet of an interval whose derivatives are all zero."""
    out = np.empty((1, 2))
    out[0, 0], out[0, 1] = value
    return out


@jit(allocates=True)
def variable(value, slot, rows):
    """Return the jet, of *rows* intervals, of the unknown in *slot*, whose range in the box is the interval *value*."""
    out = np.zeros((rows, 2))
    out[0, 0], out[0, 1] = value
    out[1 + slot, 0] = out[1 + slot, 1] = 1.0
    return out


@jit(allocates=True)
def unbounded():
    """Return the jet of a quantity that is not defined everywhere in the box: all of its intervals are unbounded."""
    out = np.empty((BENT, 2))
    out[:, 0], out[:, 1] = ENTIRE
    return out


@jit
def put(a, out):
    """Write a jet to the rows of *out*."""
    for k in range(out.shape[0]):
        out[k, 0], out[k, 1] = of(a, k)


@jit(allocates=True)
def _room(a, b, value):
    """Jet with the rows of *a* or *b*, and a value."""
    out = np.empty((max(a.shape[0], b.shape[0]), 2))
    out[0, 0], out[0, 1] = value
    return out


@jit(allocates=True)
def plus(a, b):
    """Return the jet of a + b."""
    out = _room(a, b, ZERO)
    for k in range(out.shape[0]):
        out[k, 0], out[k, 1] = add(of(a, k), of(b, k))
    return out


@jit(allocates=True)
def minus(a, b):
    """Return the jet of a - b."""
    out = _room(a, b, ZERO)
    for k in range(out.shape[0]):
        out[k, 0], out[k, 1] = sub(of(a, k), of(b, k))
    return out


@jit(allocates=True)
def scaled(a, factor):
    """Return the jet of a times the interval *factor*."""
    out = np.empty_like(a)
    for k in range(a.shape[0]):
        out[k, 0], out[k, 1] = mul(of(a, k), factor)
    return out


@jit(allocates=True)
def times(a, b):
    """Return the jet of the product a b."""
    out = _room(a, b, mul(of(a, 0), of(b, 0)))
    for k in range(1, out.shape[0]):
        value = add(mul(of(a, k), of(b, 0)), mul(of(a, 0), of(b, k)))
        if k >= SLOPED:
            p, q = pair(k)
            value = add(value, add(mul(of(a, p), of(b, q)), mul(of(a, q), of(b, p))))
        out[k, 0], out[k, 1] = value
    return out


@jit(allocates=True)
def over(a, b):
    """Return the jet of a / b; unbounded if b contains zero."""
    out = _room(a, b, div(of(a, 0), of(b, 0)))
    for k in range(1, out.shape[0]):
        value = sub(of(a, k), mul(of(out, 0), of(b, k)))
        if k >= SLOPED:
            p, q = pair(k)
            value = sub(value, add(mul(of(out, p), of(b, q)), mul(of(out, q), of(b, p))))
        out[k, 0], out[k, 1] = div(value, of(b, 0))
    return out


@jit(allocates=True)
def chained(a, value, slope, bend):
    """Return the jet of f(a), from enclosures of f, f' and f'' over *a*."""
    out = np.empty_like(a)
    out[0, 0], out[0, 1] = value
    for k in range(1, a.shape[0]):
        own = mul(slope, of(a, k))
        if k >= SLOPED:
            p, q = pair(k)
            own = add(own, mul(bend, mul(of(a, p), of(a, q))))
        out[k, 0], out[k, 1] = own
    return out


@jit(allocates=True)
def square_root(a):
    """Return the jet of the square root of a."""
    value = root(of(a, 0))
    slope = div((0.5, 0.5), value)
    return chained(a, value, slope, neg(div(slope, add(of(a, 0), of(a, 0)))))


@jit(allocates=True)
def cosine(a):
    """Return the jet of cos(a)."""
    value = cos(of(a, 0))
    return chained(a, value, neg(sin(of(a, 0))), neg(value))


@jit(allocates=True)
def sine(a):
    """Return the jet of sin(a)."""
    value = sin(of(a, 0))
    return chained(a, value, cos(of(a, 0)), neg(value))


@jit(allocates=True)
def angle(x, y):
    """Return the jet of the angle of the vector (x, y), rad.

    The angle is continuous in the box, and between -pi and pi at the middle of the box.
    """
    out = _room(x, y, _angle(of(x, 0), of(y, 0)))
    square = add(sqr(of(x, 0)), sqr(of(y, 0)))
    for k in range(1, out.shape[0]):
        value = _turn(x, y, 0, k)
        if k >= SLOPED:
            p, q = pair(k)
            grown = add(mul(of(x, 0), of(x, q)), mul(of(y, 0), of(y, q)))
            value = sub(add(value, _turn(x, y, q, p)), mul(of(out, p), add(grown, grown)))
        out[k, 0], out[k, 1] = div(value, square)
    return out


@jit
def _turn(x, y, i, j):
    """Vector product of rows *i* and *j* of (x, y)."""
    return sub(mul(of(x, i), of(y, j)), mul(of(y, i), of(x, j)))


@jit
def _angle(x, y):
    """Enclose the angle of (x, y): a guess by plain floats, and a proof of how far the angle is from it."""
    size = root(add(sqr(x), sqr(y)))
    c, s = div(x, size), div(y, size)
    ahead, aside = 0.5 * (c[0] + c[1]), 0.5 * (s[0] + s[1])
    if not abs(ahead) + abs(aside) < 3.0:
        return ENTIRE
    guess = 0.5 * PI[0] * (1.0 - ahead)
    guess = guess if aside >= 0.0 else -guess
    for _ in range(REFINEMENTS):
        guess += aside * cos((guess, guess))[0] - ahead * sin((guess, guess))[0]
    cg, sg = cos((guess, guess)), sin((guess, guess))
    off, along = sub(mul(s, cg), mul(c, sg)), add(mul(c, cg), mul(s, sg))
    if not (mag(off) < NEAR and along[0] > 0.0):
        return ENTIRE
    return add((guess, guess), mul(off, (1.0, up(1.0 + up(mag(off) * mag(off))))))


@jit(allocates=True)
def dot(a, b):
    """Scalar product of two vectors, each a tuple of three jets."""
    return plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))


@jit(allocates=True)
def cross(a, b):
    """Vector product of two vectors, each a tuple of three jets."""
    return (
        minus(times(a[1], b[2]), times(a[2], b[1])),
        minus(times(a[2], b[0]), times(a[0], b[2])),
        minus(times(a[0], b[1]), times(a[1], b[0])),
    )


@jit(allocates=True)
def along(a, factor):
    """Return the vector *a*, a tuple of three jets, times the jet *factor*."""
    return times(a[0], factor), times(a[1], factor), times(a[2], factor)


@jit(allocates=True)
def unit(a):
    """Return the vector *a*, a tuple of three jets, divided by its length."""
    return along(a, over(constant(ONE), square_root(dot(a, a))))


@jit(allocates=True)
def added(a, b):
    """Sum of two vectors, each a tuple of three jets."""
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


@jit(allocates=True)
def less(a, b):
    """Difference of two vectors, each a tuple of three jets."""
    return minus(a[0], b[0]), minus(a[1], b[1]), minus(a[2], b[2])


@jit(allocates=True)
def fixed(a, b, c):
    """Return a constant vector of three numbers as a tuple of three jets."""
    return constant((a, a)), constant((b, b)), constant((c, c))
