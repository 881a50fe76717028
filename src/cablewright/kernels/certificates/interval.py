"""Intervals of real numbers with outward rounding: what an enclosure encloses is a theorem.

An interval is a tuple (lo, hi) of two floats. Each function of intervals encloses all values of its real namesake;
each *_point function encloses the value at one double. What is undefined anywhere on its arguments gives ENTIRE. Only
the correctly rounded + - * / and sqrt of IEEE 754 are trusted. No function of a libm is called: libm promises no error
bound. Every constant is derived in docs/theory/intervals.md. Compile callers with `kernels.jit`, whose options allow
neither reassociation nor fused operations.
"""

from math import ceil, factorial, floor, inf, sqrt

import numpy as np

from cablewright.kernels import jit

ENTIRE = (-inf, inf)
U = 2.0**-53  # the unit roundoff
PHI = U * (1.0 + 2.0**-52)
ETA = 2.0**-1022  # the least normal number, so that a process that flushes subnormals to zero rounds outward as well
GAMMA = 1e-13  # more than 900 roundings, of the sum of absolute values: no sum of a certificate has as many terms
ROUNDING = 1.0 + 1e-12  # of sums and products of terms that are not negative

LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # a multiple of 2^-42: k LN2_HIGH is exact for |k| < 2^11
LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")
PER_LN2 = 1.4426950408889634
SQRT2 = 1.4142135623730951
NEAR_LEFT, NEAR_RIGHT = -0.2928, 0.4142  # within sqrt(1/2) - 1 and sqrt(2) - 1

HALF_PI_HIGH = float.fromhex("0x1.921fb54443000p+0")  # a multiple of 2^-40: k HALF_PI_HIGH is exact for |k| < 2^12
HALF_PI_MID = float.fromhex("-0x1.73dcb3b39a000p-43")  # a multiple of 2^-82: k HALF_PI_MID is exact
HALF_PI_LOW = float.fromhex("0x1.45c06e0e68948p-86")
PER_HALF_PI = 0.6366197723675814
TURNS = 1000.0  # the largest argument of sin and cos
ROUND = 1.5 * 2.0**52  # (x + ROUND) - ROUND is an integer next to x

# Coefficients in powers of the square (of the argument itself for exp), highest first, each correctly rounded.
ATANH = tuple(1.0 / (2 * k + 3) for k in range(9, -1, -1))  # (atanh(z)/z - 1) / z^2
EXP = tuple(1.0 / factorial(k + 2) for k in range(11, -1, -1))  # (exp(r) - 1 - r) / r^2
SINE = tuple((-1.0) ** (k + 1) / factorial(2 * k + 3) for k in range(7, -1, -1))  # (sin(r)/r - 1) / r^2
COSINE = tuple((-1.0) ** k / factorial(2 * k + 4) for k in range(6, -1, -1))  # (cos(r) - 1 + r^2/2) / r^4

# Half-widths in units of U: the error of the value, one for the subtraction that makes the end, and some slack.
TURN_BOUND = 2.9 * U
TURN_LOSS = 2.0**-130  # of the reduction, per quarter turn
EXP_BOUND = 3.6 * U
NEAR_BOUND = 4.25 * U
FAR_BOUND, FAR_TAIL_BOUND = 2.05 * U, 4.25 * U


# --- Rounding outward


@jit
def down(c):
    """A bound below whatever rounds to *c*, however rounded: -inf for NaN and for an overflow."""
    bound = c - (PHI * abs(c) + ETA)
    return bound if bound == bound else -inf


@jit
def up(c):
    """A bound above whatever rounds to *c*: inf for NaN and for an overflow."""
    bound = c + (PHI * abs(c) + ETA)
    return bound if bound == bound else inf


@jit
def _ball(value, radius):
    """Ends of *value* -/+ *radius*, which has in it one U |value| for the rounding of the ends."""
    lo = value - (radius + ETA)
    hi = value + (radius + ETA)
    return (lo if lo == lo else -inf, hi if hi == hi else inf)


# --- Arithmetic. Non-negative operands give a non-negative sum, product and quotient.


@jit
def point(x):
    """The interval of the one number *x*; ENTIRE if it is not finite."""
    return (x, x) if abs(x) < inf else ENTIRE


@jit
def neg(a):
    """-a."""
    return (-a[1], -a[0])


@jit
def add(a, b):
    """A + b."""
    lo = down(a[0] + b[0])
    if lo < 0.0 and a[0] >= 0.0 and b[0] >= 0.0:
        lo = 0.0
    return (lo, up(a[1] + b[1]))


@jit
def sub(a, b):
    """A - b."""
    return (down(a[0] - b[1]), up(a[1] - b[0]))


@jit
def mul(a, b):
    """A b."""
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
    """A / b; ENTIRE if b holds zero."""
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
    """A times the exact number *factor*."""
    if factor >= 0.0:
        lo = down(a[0] * factor)
        return (0.0 if lo < 0.0 and a[0] >= 0.0 else lo, up(a[1] * factor))
    return (down(a[1] * factor), up(a[0] * factor))


@jit
def sqr(a):
    """a^2."""
    least, most = mig(a), mag(a)
    lo = down(least * least)
    return (lo if lo > 0.0 else 0.0, up(most * most))


@jit
def root(a):
    """sqrt(a)."""
    if not (a[0] >= 0.0 and a[1] >= a[0]):
        return ENTIRE
    lo = down(sqrt(a[0]))
    return (lo if lo > 0.0 else 0.0, up(sqrt(a[1])))


# --- Sets


@jit
def hull(a, b):
    """The least interval that holds a and b."""
    return (a[0] if a[0] <= b[0] else b[0], a[1] if a[1] >= b[1] else b[1])


@jit
def intersect(a, b):
    """What a and b share; lo > hi if nothing."""
    return (a[0] if a[0] >= b[0] else b[0], a[1] if a[1] <= b[1] else b[1])


@jit
def inside(a, b):
    """Whether a lies in the interior of b."""
    return b[0] < a[0] and a[1] < b[1]


@jit
def contains_zero(a):
    """Whether a holds zero, as far as is known."""
    return not (a[0] > 0.0 or a[1] < 0.0)


@jit
def width(a):
    """An upper bound of hi - lo."""
    return up(a[1] - a[0])


@jit
def mid(a):
    """A number of a near its middle; finite also for ENTIRE."""
    middle = 0.5 * a[0] + 0.5 * a[1]
    if not abs(middle) < inf:
        middle = 0.0
    if middle < a[0]:
        return a[0]
    return a[1] if middle > a[1] else middle


@jit
def radius(a):
    """An upper bound of the distance of mid(a) from what a holds."""
    middle = mid(a)
    left, right = middle - a[0], a[1] - middle
    return up(right if left < right else left)


@jit
def mag(a):
    """The largest absolute value in a."""
    left, right = abs(a[0]), abs(a[1])
    if left != left or right != right:
        return inf
    return left if left > right else right


@jit
def mig(a):
    """The least absolute value in a."""
    if a[0] > 0.0:
        return a[0]
    return -a[1] if a[1] < 0.0 else 0.0


@jit
def inflate(a, r):
    """A with *r* more on either side."""
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
    back = r + step  # the two-sum of Knuth: what r lost
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
    most = 1.0 - half
    return most + (((1.0 - most) - half) + (square * square * tail - r * low))


@jit
def _wave(a, quarters):
    """sin(a + quarters pi/2): its ends, and each extremum that may lie between them."""
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
    """sin(a); tight within -/+ 1000."""
    return _wave(a, 0)


@jit
def cos(a):
    """cos(a); tight within -/+ 1000."""
    return _wave(a, 1)


# --- Exponential


@jit
def exp_point(x):
    """Enclosure of exp(x); tight for |x| <= 700."""
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
    """exp(a)."""
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
def _log_of_sum(s, rest):
    """Enclosure of log(s + rest) for a positive s outside [0.7072, 1.4142] and |rest| <= U s."""
    shift = 0
    scaled = s
    if s < 2.0**-1022:
        scaled = s * 2.0**54
        shift = 54
    bits = int(np.float64(scaled).view(np.int64))
    k = (bits >> 52) - 1023 - shift
    m = float(np.int64((bits & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64))
    if m > SQRT2:
        m *= 0.5
        k += 1
    tail = _twice_atanh((m - 1.0) / (m + 1.0)) + (k * LN2_LOW + rest / s)
    value = k * LN2_HIGH + tail
    return _ball(value, FAR_TAIL_BOUND * abs(tail) + FAR_BOUND * abs(value))


@jit
def log_point(x):
    """Enclosure of log(x)."""
    if not 0.0 < x < inf:
        return ENTIRE
    if 1.0 + NEAR_LEFT <= x <= 1.0 + NEAR_RIGHT:
        value = _twice_atanh((x - 1.0) / (x + 1.0))
        return _ball(value, NEAR_BOUND * abs(value))
    return _log_of_sum(x, 0.0)


@jit
def log1p_point(x):
    """Enclosure of log(1 + x)."""
    if not -1.0 < x < inf:
        return ENTIRE
    if NEAR_LEFT <= x <= NEAR_RIGHT:
        value = _twice_atanh(x / (2.0 + x))
        return _ball(value, NEAR_BOUND * abs(value))
    s = 1.0 + x
    return _log_of_sum(s, x - (s - 1.0) if x < 1.0 else 1.0 - (s - x))


@jit
def log(a):
    """log(a)."""
    if not 0.0 < a[0] <= a[1]:
        return ENTIRE
    lo, hi = log_point(a[0])
    return (lo, hi) if a[0] == a[1] else (lo, log_point(a[1])[1])


@jit
def log1p(a):
    """log(1 + a)."""
    if not -1.0 < a[0] <= a[1]:
        return ENTIRE
    lo, hi = log1p_point(a[0])
    return (lo, hi) if a[0] == a[1] else (lo, log1p_point(a[1])[1])


@jit
def log1p_ratio_point(d):
    """Enclosure of log(1 + d) / d, which is 1 at d = 0."""
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
    """log(1 + a) / a, decreasing, 1 at 0."""
    if not -1.0 < a[0] <= a[1]:
        return ENTIRE
    lo, hi = log1p_ratio_point(a[0])
    return (lo, hi) if a[0] == a[1] else (log1p_ratio_point(a[1])[0], hi)
