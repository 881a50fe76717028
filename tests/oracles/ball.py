"""Oracle: the rounding errors of the series in `kernels.certificates.interval`, bounded with rational arithmetic.

A `Ball` says how large a number is at most and how far its computed value is from it at most. The bounds below follow
the kernels operation by operation over their whole range and give the relative error of the value in units of 2^-53.
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
