"""Irvine's elastic catenary of one hanging span: from the force at its start to its end point.

It is rewritten without cancellation: massless, inextensible, slack and vertical spans need no special cases.
"""

from math import log1p, sqrt

from cablewright.kernels import jit

TINY = 1e-290


@jit
def span(h, v, length, weight, compliance):
    """Return end point and flexibility of a hanging span of unstrained *length* with the tension (h, v) at its start.

    Parameters in SI: h, v (N, along the direction from start to end; h of either sign), length (m), weight per
    unstrained length (N/m), compliance 1/EA (1/N). Returns x, z (m, end from start), the flexibility x_h, x_v (= z_h),
    z_v (m/N), the end's motion per unstrained length x_l, z_l, and v1 (N), the vertical tension component at the end.
    Irvine 1981; Paty 2021, Eqs. 16 and 17, in terms of sums of like signs.
    """
    v1 = v + weight * length
    t0 = sqrt(h * h + v * v)
    t1 = sqrt(h * h + v1 * v1)
    s = t0 + t1
    p = t0 + v if v >= 0.0 else h * h / (t0 - v)
    q = h * h / (t1 + v1) if v1 > 0.0 else t1 - v1
    half = 2.0 * length / (p + q + TINY)
    d = weight * half
    g = half * (log1p(d) / d if d > 1e-5 else 1.0 - d * (0.5 - d / 3.0))  # integral of ds / T
    stretch = compliance * length
    slope = _slope_change(h, v, v1, t0, t1, length, weight)
    x = h * (stretch + g)
    z = length * (v + v1) * (0.5 * compliance + 1.0 / s)
    x_v = -h * length * (v + v1) / (s * t0 * t1)
    per_length = compliance + 1.0 / t1
    return x, z, stretch + g - slope, x_v, stretch + slope, h * per_length, v1 * per_length, v1


@jit
def _slope_change(h, v, v1, t0, t1, length, weight):
    """(v1/t1 - v/t0) / weight, the integral of h^2 / T^3, without the cancellation of like signs."""
    if v * v1 > 0.0 or weight == 0.0:
        if v == 0.0 and v1 == 0.0:
            return length / t0
        return h * h * length * (v + v1) / (t0 * t1 * (v1 * t0 + v * t1))
    return (v1 / t1 - v / t0) / weight
