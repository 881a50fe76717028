"""Interval arithmetic with outward rounding: enclosures are guaranteed.

An interval is a tuple (lo, hi) of two floats. Each function of intervals encloses all values of the real function of
that name; each *_point function encloses the value at one double. The result is ENTIRE where the function is undefined
anywhere on its arguments. Only the correctly rounded + - * / and sqrt of IEEE 754 are trusted. No function of a libm is
called, since libm promises no error bound. Every constant is derived in docs/theory/intervals.md. Compile callers with
`kernels.jit`, whose options allow neither reassociation nor fused operations.
"""

from math import ceil, factorial, floor, inf, sqrt

import numpy as np

from cablewright.kernels import jit

ENTIRE = (-inf, inf)
ZERO, ONE = (0.0, 0.0), (1.0, 1.0)
PI = (3.141592653589793, 3.1415926535897936)
HALF_PI = (1.5707963267948966, 1.5707963267948968)
U = 2.0**-53  # the unit roundoff
PHI = U * (1.0 + 2.0**-52)
ETA = 2.0**-1022  # the smallest normal number: rounding is outward even where subnormals are flushed to zero
GAMMA = 1e-13  # of the sum of absolute values: over 900 roundings, more than any sum of a certificate has
ROUNDING = 1.0 + 1e-12  # factor for the rounding of sums and products of nonnegative terms

LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # a multiple of 2^-42: k LN2_HIGH is exact for |k| < 2^11
LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")
PER_LN2 = 1.4426950408889634
SQRT2 = 1.4142135623730951
NEAR_LEFT, NEAR_RIGHT = -0.2928, 0.4142  # within sqrt(1/2) - 1 and sqrt(2) - 1

HALF_PI_HIGH = float.fromhex("0x1.921fb54443000p+0")  # a multiple of 2^-40: k HALF_PI_HIGH is exact for |k| < 2^12
HALF_PI_MID = float.fromhex("-0x1.73dcb3b39a000p-43")  # a multiple of 2^-82: k HALF_PI_MID is exact
HALF_PI_LOW = float.fromhex("0x1.45c06e0e68948p-86")
PER_HALF_PI = 0.6366197723675814
TURNS = 1000.0  # largest argument of sin and cos with a tight enclosure
ROUND = 1.5 * 2.0**52  # (x + ROUND) - ROUND is an integer next to x

# Coefficients in powers of the square (of the argument itself for exp), highest first, each correctly rounded.
ATANH = tuple(1.0 / (2 * k + 3) for k in range(9, -1, -1))  # (atanh(z)/z - 1) / z^2
EXP = tuple(1.0 / factorial(k + 2) for k in range(11, -1, -1))  # (exp(r) - 1 - r) / r^2
SINE = tuple((-1.0) ** (k + 1) / factorial(2 * k + 3) for k in range(7, -1, -1))  # (sin(r)/r - 1) / r^2
COSINE = tuple((-1.0) ** k / factorial(2 * k + 4) for k in range(6, -1, -1))  # (cos(r) - 1 + r^2/2) / r^4

# Half widths: the error of the value, one U for the subtraction that makes the end, and some slack.
TURN_BOUND = 2.9 * U
TURN_LOSS = 2.0**-130  # of the reduction, per quarter turn
EXP_BOUND = 3.6 * U
NEAR_BOUND = 4.25 * U
FAR_BOUND, FAR_TAIL_BOUND = 2.05 * U, 4.25 * U


# --- Rounding outward


@jit
def down(c):
    """Return a lower bound of all numbers that round to *c* in any rounding mode: -inf for NaN and for an overflow."""
    bound = c - (PHI * abs(c) + ETA)
    return bound if bound == bound else -inf


@jit
def up(c):
    """Return an upper bound of all numbers that round to *c*: inf for NaN and for an overflow."""
    bound = c + (PHI * abs(c) + ETA)
    return bound if bound == bound else inf


@jit
def _ball(value, radius):
    """Ends of *value* -/+ *radius*, which includes one U |value| for the rounding of the ends."""
    lo = value - (radius + ETA)
    hi = value + (radius + ETA)
    return (lo if lo == lo else -inf, hi if hi == hi else inf)


# --- Arithmetic. Non-negative operands give a non-negative sum, product and quotient.


@jit
def point(x):
    """Return the interval that contains only the number *x*; ENTIRE if *x* is not finite."""
    return (x, x) if abs(x) < inf else ENTIRE


@jit
def neg(a):
    """Return the interval of -a."""
    return (-a[1], -a[0])


@jit
def add(a, b):
    """Return an interval that contains every sum of a number in *a* and one in *b*."""
    lo = down(a[0] + b[0])
    if lo < 0.0 and a[0] >= 0.0 and b[0] >= 0.0:
        lo = 0.0
    return (lo, up(a[1] + b[1]))


@jit
def sub(a, b):
    """Return the interval of a - b."""
    return (down(a[0] - b[1]), up(a[1] - b[0]))


@jit
def mul(a, b):
    """Return the interval of the product a b."""
    p, q, r, s = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    total = (p + q) + (r + s)
    if total != total:  # 0 times inf
        return ENTIRE
    pq = p if p < q else q
    rs = r if r < s else s
    lo = down(pq if pq < rs else rs)
    if lo < 0.0 and a[0] >= 0.0 and b[0] >= 0.0:
        lo = 0.0
    pq = p if p > q else q
    rs = r if r > s else s
    return (lo, up(pq if pq > rs else rs))


@jit
def div(a, b):
    """Return the interval of a / b; ENTIRE if b contains zero."""
    if b[0] > 0.0:
        lo = down(a[0] / (b[1] if a[0] >= 0.0 else b[0]))
        if lo < 0.0 and a[0] >= 0.0:
            lo = 0.0
        return (lo, up(a[1] / (b[0] if a[1] >= 0.0 else b[1])))
    if b[1] < 0.0:
        return (down(a[1] / (b[1] if a[1] >= 0.0 else b[0])), up(a[0] / (b[0] if a[0] >= 0.0 else b[1])))
    return ENTIRE


@jit
def scale(a, factor):
    """Return the interval of a times the exact number *factor*."""
    if factor >= 0.0:
        lo = down(a[0] * factor)
        return (0.0 if lo < 0.0 and a[0] >= 0.0 else lo, up(a[1] * factor))
    return (down(a[1] * factor), up(a[0] * factor))


@jit
def sqr(a):
    """Return the interval of a^2."""
    smallest, largest = mig(a), mag(a)
    lo = down(smallest * smallest)
    return (lo if lo > 0.0 else 0.0, up(largest * largest))


@jit
def root(a):
    """Return the interval of the square root of a."""
    if not (a[0] >= 0.0 and a[1] >= a[0]):
        return ENTIRE
    lo = down(sqrt(a[0]))
    return (lo if lo > 0.0 else 0.0, up(sqrt(a[1])))


# --- Sets


@jit
def hull(a, b):
    """Return the smallest interval that contains a and b."""
    return (a[0] if a[0] <= b[0] else b[0], a[1] if a[1] >= b[1] else b[1])


@jit
def intersect(a, b):
    """Return the intersection of the intervals a and b; lo > hi if it is empty."""
    return (a[0] if a[0] >= b[0] else b[0], a[1] if a[1] <= b[1] else b[1])


@jit
def contains_zero(a):
    """Return whether the interval a may contain zero; true for NaN."""
    return not (a[0] > 0.0 or a[1] < 0.0)


@jit
def mag(a):
    """Return the largest absolute value in the interval a."""
    left, right = abs(a[0]), abs(a[1])
    if left != left or right != right:
        return inf
    return left if left > right else right


@jit
def mig(a):
    """Return the smallest absolute value in the interval a."""
    if a[0] > 0.0:
        return a[0]
    return -a[1] if a[1] < 0.0 else 0.0


@jit
def inflate(a, r):
    """Return the interval a, widened by *r* at either end."""
    return (down(a[0] - abs(r)), up(a[1] + abs(r)))


# --- Sine and cosine


@jit
def _turned(x, quarters):
    """Enclosure of sin(x + quarters pi/2)."""
    if not abs(x) <= TURNS:
        return (-1.0, 1.0)
    k = (x * PER_HALF_PI + ROUND) - ROUND
    rest = x - k * HALF_PI_HIGH  # exact
    step = k * HALF_PI_MID  # exact
    r = rest - step
    back = r + step  # Knuth's two-sum: the rounding error of r
    lost = (rest - back) - (step - (back - r))
    low = lost - k * HALF_PI_LOW
    turn = (int(k) + quarters) & 3
    value = _cosine(r, low) if turn & 1 else _sine(r, low)
    if turn & 2:
        value = -value
    lo, hi = _ball(value, TURN_BOUND * abs(value) + TURN_LOSS * abs(k))
    return (lo if lo > -1.0 else -1.0, hi if hi < 1.0 else 1.0)


@jit
def _sine(r, low):
    """sin(r + low) for |r| <= 0.7855 and a tiny low."""
    square = r * r
    tail = 0.0
    for c in SINE:
        tail = tail * square + c
    return r + (square * r * tail + low * (1.0 - 0.5 * square))


@jit
def _cosine(r, low):
    """cos(r + low) for |r| <= 0.7855 and a tiny low."""
    square = r * r
    tail = 0.0
    for c in COSINE:
        tail = tail * square + c
    half = 0.5 * square
    head = 1.0 - half
    return head + (((1.0 - head) - half) + (square * square * tail - r * low))


@jit
def _wave(a, quarters):
    """sin(a + quarters pi/2), from its ends and the extrema that may lie between them."""
    ends = _turned(a[0], quarters)
    if a[0] == a[1]:
        return ends
    if not (-TURNS <= a[0] <= a[1] <= TURNS):
        return (-1.0, 1.0)
    ends = hull(ends, _turned(a[1], quarters))
    quarter = (PER_HALF_PI - U, PER_HALF_PI + U)  # 2/pi is between
    span = mul(a, quarter)
    lo, hi = ends
    for multiple in range(ceil(span[0]), floor(span[1]) + 1):  # of pi/2, that may lie in a
        turn = (multiple + quarters) & 3
        if turn == 1:
            hi = 1.0
        elif turn == 3:
            lo = -1.0
    return (lo, hi)


@jit
def sin(a):
    """Return the interval of sin(a); tight for angles within -/+ 1000 rad."""
    return _wave(a, 0)


@jit
def cos(a):
    """Return the interval of cos(a); tight for angles within -/+ 1000 rad."""
    return _wave(a, 1)


# --- Exponential


@jit
def exp_point(x):
    """Return an interval that contains exp(x) of the number *x*; tight for |x| <= 700."""
    if not abs(x) <= 700.0:
        if x > 700.0:
            return (1e304, inf)
        return (0.0, 1e-304 if x < -700.0 else inf)
    k = (x * PER_LN2 + ROUND) - ROUND
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    tail = 0.0
    for c in EXP:
        tail = tail * r + c
    value = 1.0 + (r + r * r * tail)
    power = float(np.int64((int(k) + 1023) << 52).view(np.float64))
    value *= power
    return _ball(value, EXP_BOUND * value)


@jit
def exp(a):
    """Return the interval of exp(a)."""
    lo, hi = exp_point(a[0])
    return (lo, hi) if a[0] == a[1] else (lo, exp_point(a[1])[1])


# --- Logarithm


@jit
def _twice_atanh(z):
    """2 atanh(z) for |z| <= 0.1716."""
    square = z * z
    tail = 0.0
    for c in ATANH:
        tail = tail * square + c
    return 2.0 * z + 2.0 * z * (square * tail)


@jit
def log1p_point(x):
    """Return an interval that contains log(1 + x) of the number *x*."""
    if not -1.0 < x < inf:
        return ENTIRE
    if NEAR_LEFT <= x <= NEAR_RIGHT:
        value = _twice_atanh(x / (2.0 + x))
        return _ball(value, NEAR_BOUND * abs(value))
    s = 1.0 + x  # a normal number, since 1 + x >= 2^-53
    rest = x - (s - 1.0) if x < 1.0 else 1.0 - (s - x)
    bits = int(np.float64(s).view(np.int64))
    k = (bits >> 52) - 1023
    m = float(np.int64((bits & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64))
    if m > SQRT2:
        m *= 0.5
        k += 1
    tail = _twice_atanh((m - 1.0) / (m + 1.0)) + (k * LN2_LOW + rest / s)
    value = k * LN2_HIGH + tail
    return _ball(value, FAR_TAIL_BOUND * abs(tail) + FAR_BOUND * abs(value))


@jit
def log1p_ratio_point(d):
    """Return an interval that contains log(1 + d) / d of the number *d*; it is 1 at d = 0."""
    if not d > -1.0:
        return ENTIRE
    if d == inf:
        return (0.0, 1.0)
    if not NEAR_LEFT <= d <= NEAR_RIGHT:
        return div(log1p_point(d), (d, d))
    whole = 2.0 + d
    z = d / whole
    square = z * z
    tail = 0.0
    for c in ATANH:
        tail = tail * square + c
    value = 2.0 / whole
    value += value * (square * tail)
    lo, hi = _ball(value, NEAR_BOUND * value)
    return (lo, 1.0 if d >= 0.0 and hi > 1.0 else hi)


@jit
def log1p_ratio(a):
    """Return the interval of log(1 + a) / a, a decreasing function that is 1 at 0."""
    if not -1.0 < a[0] <= a[1]:
        return ENTIRE
    lo, hi = log1p_ratio_point(a[0])
    return (lo, hi) if a[0] == a[1] else (log1p_ratio_point(a[1])[0], hi)
