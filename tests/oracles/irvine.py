"""Oracle: one hanging elastic span in Irvine's textbook form, with 50 digits.

Lengths are m, forces N, ``w`` is the weight per unstrained length in N/m, ``EA`` the axial stiffness in N (``inf``: it
does not stretch). Tension vectors point along the direction of travel; z is up.
"""

from __future__ import annotations

import math

from mpmath import mp, mpf

DIGITS = 50

Real = mpf | float
Pair = tuple[mpf, mpf]


def span(H: Real, V0: Real, L: Real, w: Real, EA: Real) -> Pair:
    """Return the end (x, z), relative to its start, of a span that starts with the tension vector (H, V0).

    ``L`` is its unstrained length. It ends with the tension vector (H, V0 + w L). H < 0 runs towards -x.
    """
    with mp.workdps(DIGITS):
        H, V0, L, w, EA = (mpf(value) for value in (H, V0, L, w, EA))
        T0 = mp.hypot(H, V0)
        if w == 0:
            return H * L / T0 + H * L / EA, V0 * L / T0 + V0 * L / EA
        lost = math.ceil(max(0, mp.log10(T0 / abs(w * L)))) if T0 and L else 0
    with mp.workdps(DIGITS + 2 * lost):  # the differences below cancel as w goes to 0
        V1 = V0 + w * L
        x = H * L / EA
        if H != 0:
            x += H / w * (mp.asinh(V1 / abs(H)) - mp.asinh(V0 / abs(H)))
        z = V0 * L / EA + w * L**2 / (2 * EA) + (mp.hypot(H, V1) - T0) / w
        return x, z


def start_tension(x: Real, z: Real, L: Real, w: Real, EA: Real, guess: tuple[Real, Real]) -> Pair:
    """Return the tension vector (H, V0) with which a span has to start to end at (x, z): the inverse of `span`."""

    def miss(H: mpf, V0: mpf) -> Pair:
        end = span(H, V0, L, w, EA)
        return end[0] - x, end[1] - z

    with mp.workdps(DIGITS):
        H, V0 = mp.findroot(miss, tuple(mpf(value) for value in guess), tol=mpf(10) ** (4 - 2 * DIGITS), maxsteps=100)
        return H, V0
