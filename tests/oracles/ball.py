"""Oracle: the rounding errors of the series in `kernels.certificates.interval`, bounded with rational arithmetic.

A `Ball` says how large a number is at most and how far its computed value is from it at most. The bounds below follow
the kernels operation by operation over their whole range and give the relative error of the value in units of 2^-53.
The kernels use the constants that follow; u = 2^-53.

Horner. p ← fl(fl(p t) + c), with every coefficient rounded once. Let sizes be at most P and errors at most ε:

product: P P', error P ε' + P' ε + ε ε' + u(P P' + ...)        sum: P + P', error ε + ε' + u(...)

Evaluated at the largest |t| with equal signs, this bounds the polynomial.

Sine and cosine.

An integer k next to 2x/pi is (2x/pi + 1.5 2^52) - 1.5 2^52, with |k| ≤ 637 and |x - k pi/2| ≤ 0.7855. Let pi/2 = A + B
+ C + δ. A is a multiple of 2^-40 below 2, and B one of 2^-82 below 2^-42. C is a double, |C| < 2^-85, |δ| < 2^-141.

* The numbers k A, x - k A and k B are exact.
* Let r = fl(x - kA - kB). Knuth's two-sum gives its exact loss, at most u |r|. Let low = lost - k C. The error of r +
  low is at most |k| 2^-135 + u² |r|.
* sin(r + low): ``r + (r³ S(r²) + low (1 - r²/2))``, S to r^17. The rest is at most |r|^19/19!, the error 1.74 u.
* cos(r + low) = ``w + (((1 - w) - r²/2) + (r⁴ C(r²) - r low))``, w = fl(1 - r²/2). Both differences are exact. C to
  r^16. The rest is at most r^18/18!, the error 1.76 u.
* The code grants |k| 2^-130 for all terms with k. So no lower bound for the distance from a multiple of pi/2 is needed.

Of an interval: the hull of both ends, with 1 or -1 for each multiple of pi/2 of that kind that may lie between.

Exponential.

Let k be next to x / ln 2, |k| ≤ 1010, and ln 2 = H + L + δ. H is a multiple of 2^-42, |L| < 2^-44, |δ| < 2^-102, so k H
and x - k H are exact. Let r = fl(that - k L): |r| ≤ 0.35, within 0.35 u (1 + 2u). The result is ``1 + (r + r² Q(r))``
with powers to r^13. The rest is at most 1.5 |r|^14/14!, the error 2.46 u. The factor 2^k is exact.

Logarithm.

log((1+z)/(1-z)) = 2 atanh z = 2 z (1 + w(z²)), |z| ≤ 0.1716, w = t/3 + .. + t^10/21. The rest of w is at most t^11 /
(23 (1 - t)).

* Near. log1p x: z = x/(2+x) has two roundings, 2u, times at most 1.031. The polynomial w adds 0.05 u, the last
  addition u: 3.12 u.
* Ratio. log1p(d)/d = 2/(2+d) (1 + w): two roundings. The error of t = z² is multiplied by about 0.01.
* Far. log s: s = 2^k m by its bits, and y = fl(k H + tail), tail = fl(2 atanh z + fl(fl(k L) + c)). Errors: 3.12 u
  |2 atanh z| + u |tail| + u |y|, and 1076 (2^-102 + 2u 2^-44). In total 4.12 |tail| and 1.01 |y|, without the rounding
  of the ends.
* log1p far. s = fl(1 + x). The fast two-sum gives its rounding error e exactly, |e| ≤ u s. log(s + e) = log s + c,
  c = fl(e/s), to 1.6 u², counted as 2u².

Of an interval: both ends, by monotonicity.

Rounding of the sums with Y of a certificate.

F(x) and [J] are rounded outward. The products with Y are sums in floats with a bounded error. Let γ_j = j u / (1 - j
u), u = 2^-53. A sum of j products is within γ_j of the sum of the absolute values (Higham 2002, section 3.1). Interval
entries are split in c ± d. With m ≤ 64 lines, N ≤ 6 · 64 + 6 = 390.

* Y F: N products of Y with middles of F have an error of at most γ_391 Σ|y||c| < 4.4e-14 Σ|y||c|. The code adds
  GAMMA = 1e-13 of it.
* I - Y J: a line's column has 12 products at most. A column of the platform has four rows of each line and its own:
  4 · 64 + 6 = 262. With the subtraction from 1: γ_264 (1 + Σ|y||c|) < 3e-14 of it. The code adds GAMMA times r for the
  1, and GAMMA |c| to each d.
* Sums of terms that are not negative: at most 4 · 64 + 6 = 262 roundings of a term in the inner sum, 2 N = 780 in
  the outer one, and 12 others. So the float is at least (1 - 1054 u) of the truth. The factor ROUNDING = 1 + 1e-12 is
  more than 9000 u.
* Underflow: each operation loses 2^-1074 at most, 2^-1022 in a process that flushes subnormals. There are less than
  1e5 in a row, some multiplied by an entry of Y. UNDERFLOW = 1e-290 is more than all, if |Y| < 1e28 (flushing: 1e12).
  Where an entry of Y is 1e12 or more nothing is certified. The largest seen is 4e3 for lines in planes, 4e4 for others.

These counts hold up to 148 lines: 6 · 148 + 7 < 900.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

U = Fraction(1, 2**53)
SINE_RANGE = Fraction(7855, 10000)
EXP_RANGE = Fraction(35, 100)
ATANH_RANGE = Fraction(1716, 10000)
LEAST_FAR = Fraction(345, 1000)  # |log| outside the near range: log(1.4142) = 0.3465..., log(0.7072) = -0.3464...


class Ball(NamedTuple):
    """A number of size at most ``size``, computed with an error of at most ``error``; `+` and `*` round."""

    size: Fraction
    error: Fraction = Fraction(0)

    def __mul__(self, other: Ball) -> Ball:  # type: ignore[override]
        size = self.size * other.size
        error = self.size * other.error + other.size * self.error + self.error * other.error
        return Ball(size, error).rounded()

    def __add__(self, other: Ball) -> Ball:  # type: ignore[override]
        return Ball(self.size + other.size, self.error + other.error).rounded()

    def rounded(self) -> Ball:
        """The same number after one more rounding."""
        return Ball(self.size, self.error + U * (self.size + self.error))


def constant(value: Fraction) -> Ball:
    """A number rounded to a double."""
    return Ball(abs(value), U * abs(value))


def horner(coefficients: Sequence[Fraction], at: Ball) -> Ball:
    """The value of a polynomial, coefficients highest first, by Horner's rule."""
    total = constant(coefficients[0])
    for each in coefficients[1:]:
        total = total * at + constant(each)
    return total


def _inverse_factorials(powers: Sequence[int]) -> list[Fraction]:
    return [Fraction(1, math.factorial(power)) for power in powers]


def sine() -> float:
    """Bound for the sine, all sizes in units of |r|."""
    top = SINE_RANGE**2
    square = Ball(top).rounded()
    body = square * Ball(Fraction(1)) * horner(_inverse_factorials(range(17, 2, -2)), square)
    low = U * (1 + 3 * U)  # what the reduction leaves, less the part that goes with the number of quarter turns
    cosine = Ball(Fraction(1), Ball(top / 2, square.error / 2).rounded().error + U + top**2 / 24)
    total = body + Ball(low) * cosine
    error = total.error + top**9 / math.factorial(19) + low**2
    sinc = 1 - top / 6  # a lower bound of sin(r) / r
    return _with_last_rounding(error / sinc)


def cosine() -> float:
    """Bound for the cosine."""
    r = SINE_RANGE
    top = r**2
    square = Ball(top).rounded()
    half = Ball(top / 2, square.error / 2)
    low = U * (1 + 3 * U) * r
    body = square * square * horner(_inverse_factorials(range(16, 3, -2)), square)
    lost = Ball(U)  # (1 - most) - half, exact, at most half an ulp of most < 1
    cross = Ball(r) * Ball(low, low * top / 6)
    total = lost + (body + cross)
    error = total.error + half.error + top**9 / math.factorial(18) + low**2
    return _with_last_rounding(error / (1 - top / 2))


def exponential() -> float:
    """Bound for exp, for either sign of r."""
    top = EXP_RANGE
    r = Ball(top)
    reduction = U * top * (1 + 2 * U)
    total = r + r * r * horner(_inverse_factorials(range(13, 1, -1)), r)
    error = total.error + top**14 / math.factorial(14) * Fraction(15, 10)
    least = 1 - top + top**2 / 2 - top**3 / 6  # a lower bound of exp(-top)
    return _with_last_rounding(error / least + reduction * (1 + U))


def _series(square: Ball) -> Ball:
    """w in 2 atanh(z) = 2 z (1 + w), with the truncation."""
    tail = horner([Fraction(1, 2 * k + 3) for k in range(9, -1, -1)], square)
    rest = ATANH_RANGE**22 / 23 / (1 - ATANH_RANGE**2)
    product = square * tail
    return Ball(product.size, product.error + rest)


def near() -> float:
    """Bound for 2 atanh(z), whose z comes out of two roundings."""
    top = ATANH_RANGE**2
    w = _series(Ball(top).rounded())
    product = Ball(Fraction(1)) * w  # the errors that z brings along are counted next
    argument = (2 * U + 3 * U**2) / (1 - top * (1 + 5 * U))  # z f'(z) / f(z) <= 1 / (1 - z^2)
    return _with_last_rounding(product.error + argument)


def ratio() -> float:
    """Bound for 2 / (2 + d) (1 + w)."""
    top = ATANH_RANGE**2
    w = _series(Ball(top, top * (4 * U + 10 * U**2)).rounded())
    lead = Ball(Fraction(1), 2 * U + 3 * U**2)
    product = lead * w
    return _with_last_rounding(product.error + lead.error)


def far() -> tuple[float, float]:
    """What the error of k log 2 + (2 atanh(z) + c) leaves of its two allowances, for |tail| and for |value|.

    The first is the factor that |tail| needs. The second is what |value| needs, with the constants in it.
    """
    atanh = Fraction(near())
    constants = 1076 * (Fraction(1, 2**102) + 2 * U * Fraction(1, 2**44))  # of LN2_HIGH + LN2_LOW, and its product
    small = 1076 * Fraction(1, 2**44) + U  # |k LN2_LOW + c|
    spread = constants + U * small + 2 * U**2  # second order of log(1 + c), and the rounding of the small sum
    on_tail = (atanh + 1) * (1 + 10 * U)
    on_value = 1 + (spread / U + atanh * small) / LEAST_FAR
    return float(on_tail), float(on_value)


def _with_last_rounding(error: Fraction) -> float:
    """In units of U, with the last addition, relative to the computed value instead of the true one."""
    total = error + U * (1 + error)
    return float(total / (1 - total) / U)
