"""Intervals enclose: against exact rational arithmetic and against 300 bits and more, and by a count of the errors."""

from __future__ import annotations

import math
import platform
import random
import re
from fractions import Fraction
from math import inf, nan

import mpmath
import numba
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from cablewright.kernels import jit
from cablewright.kernels.certificates import interval as iv
from oracles import ball

FEW = settings(max_examples=400, deadline=None)
TINY = 1e-280  # below, ETA is more than rounding
FINITE = st.floats(allow_nan=False, allow_infinity=False)
MODERATE = st.floats(-1e3, 1e3) | st.floats(-1e-300, 1e-300)
ENDS = st.tuples(FINITE | MODERATE, FINITE | MODERATE).map(lambda pair: (min(pair), max(pair)))


def exact(x: float) -> Fraction:
    return Fraction(x)


def holds(a: tuple[float, float], value: Fraction) -> bool:
    return (a[0] == -inf or exact(a[0]) <= value) and (a[1] == inf or value <= exact(a[1]))


def samples(a: tuple[float, float]) -> list[Fraction]:
    lo, hi = exact(a[0]), exact(a[1])
    return [lo, hi, lo + (hi - lo) / 3]


# --- Arithmetic, exactly


@FEW
@given(ENDS, ENDS)
def test_arithmetic_encloses_the_exact_result(a, b) -> None:
    for x in samples(a):
        for y in samples(b):
            assert holds(iv.add(a, b), x + y)
            assert holds(iv.sub(a, b), x - y)
            assert holds(iv.mul(a, b), x * y)
            assert holds(iv.div(a, b), x / y) if y else iv.div(a, b) == iv.ENTIRE
        assert holds(iv.sqr(a), x * x)
        assert holds(iv.scale(a, b[0]), x * exact(b[0]))
        assert holds(iv.neg(a), -x)
        assert iv.mig(a) <= abs(x) <= iv.mag(a)
        assert holds(iv.inflate(a, 0.5), x - Fraction(1, 2))
        assert holds(iv.inflate(a, 0.5), x + Fraction(1, 2))
        assert holds(iv.hull(a, b), x)


@FEW
@given(ENDS)
def test_root_encloses_the_exact_root(a) -> None:
    a = (abs(a[0]), abs(a[1])) if abs(a[0]) <= abs(a[1]) else (abs(a[1]), abs(a[0]))
    lo, hi = iv.root(a)
    assert lo >= 0.0
    assert exact(lo) ** 2 <= exact(a[0])
    assert exact(hi) ** 2 >= exact(a[1])


@FEW
@given(FINITE)
def test_rounding_reaches_at_least_the_neighbours_and_at_most_the_next_but_one(c) -> None:
    lo, hi = iv.down(c), iv.up(c)
    assert lo <= math.nextafter(c, -inf)
    assert hi >= math.nextafter(c, inf)
    if abs(c) > TINY and abs(c) < 1e308:
        assert lo >= math.nextafter(math.nextafter(c, -inf), -inf)
        assert hi <= math.nextafter(math.nextafter(c, inf), inf)


@FEW
@given(ENDS, ENDS)
def test_what_is_not_negative_stays_so(a, b) -> None:
    a, b = ((iv.mig(each), iv.mag(each)) for each in (a, b))
    assume(b[0] > 0.0)
    for each in (iv.add(a, b), iv.mul(a, b), iv.div(a, b), iv.scale(a, b[0]), iv.sqr(a)):
        assert each[0] >= 0.0


def test_what_is_undefined_is_anything() -> None:
    one, entire = (1.0, 1.0), iv.ENTIRE
    assert iv.div(one, (-1.0, 1.0)) == iv.div(one, (0.0, 1.0)) == iv.div(one, (-1.0, 0.0)) == entire
    assert iv.point(nan) == iv.point(inf) == iv.root((-1.0, 4.0)) == entire
    assert iv.log1p_point(-1.0) == iv.log1p_ratio((-1.5, 1.0)) == iv.log1p_ratio((2.0, 1.0)) == entire
    for each in (iv.add, iv.sub, iv.mul, iv.div):
        assert each(entire, (1.0, 2.0)) == entire
        assert each((nan, nan), (1.0, 2.0)) == entire
        assert each((1.0, 2.0), (nan, nan)) == entire
    assert iv.mul((0.0, 0.0), entire) == entire
    assert iv.mul((1e200, 1e300), (1e200, 1e300))[1] == iv.sqr((1e200, 1e300))[1] == inf
    assert iv.exp(entire) == (0.0, inf)
    assert iv.sin(entire) == iv.cos((-1e9, 2.0)) == (-1.0, 1.0)
    assert iv.exp((-800.0, 800.0)) == (0.0, inf)
    assert iv.log1p_ratio((0.0, inf)) == (0.0, 1.0)
    assert iv.mag((nan, 1.0)) == inf


def test_sets() -> None:
    assert iv.intersect((0.0, 2.0), (1.0, 3.0)) == (1.0, 2.0)
    assert iv.contains_zero((-1.0, 0.0))
    assert iv.contains_zero((nan, 1.0))
    assert not iv.contains_zero((1e-300, 1.0))


# --- Elementary functions at a double, with many bits


def scattered(rng: random.Random, count: int, low: float, high: float) -> list[float]:
    """Numbers of either sign and of all powers of ten between."""
    return [rng.choice((-1, 1)) * 10.0 ** rng.uniform(low, high) for _ in range(count)]


def turns() -> list[float]:
    rng = random.Random(1)
    with mp.workprec(200):
        edges = [float(k * mpmath.pi / 4) for k in range(-1273, 1274)]
    edges += [math.nextafter(x, inf) for x in edges]
    return [0.0, *scattered(rng, 1500, -323, 3), *[rng.uniform(-1e3, 1e3) for _ in range(1500)], *edges]


def exponents() -> list[float]:
    rng = random.Random(2)
    halves = [math.nextafter((k + 0.5) * math.log(2.0), inf) for k in range(-1009, 1009, 3)]
    return [
        0.0,
        700.0,
        -700.0,
        *scattered(rng, 1500, -323, 2.8),
        *[rng.uniform(-700, 700) for _ in range(1500)],
        *halves,
    ]


def ratios() -> list[float]:
    """Arguments of log1p: all scales, near -1, and about the ends of its ranges."""
    rng = random.Random(3)
    wide = [abs(x) for x in scattered(rng, 1500, -323, 308)] + [-abs(x) for x in scattered(rng, 700, -323, 0)]
    left = [-1.0 + 2.0 ** rng.uniform(-53, 0) for _ in range(700)]
    edges = [edge + rng.uniform(-1e-3, 1e-3) for edge in (iv.NEAR_LEFT, iv.NEAR_RIGHT, 1.0) for _ in range(300)]
    powers = [math.nextafter(2.0**k, to) for k in range(-60, 60) for to in (0.0, inf)]
    return [x for x in [*wide, *left, *edges, *powers, 0.4142, -0.2928] if x > -1.0]


def _ratio(x: mpf) -> mpf:
    return mpmath.log1p(x) / x if x else mpf(1)


POINTS = {
    "sin": (lambda x: iv.sin((x, x)), mpmath.sin, turns, 300),
    "cos": (lambda x: iv.cos((x, x)), mpmath.cos, turns, 300),
    "exp": (iv.exp_point, mpmath.exp, exponents, 300),
    "log1p": (iv.log1p_point, mpmath.log1p, ratios, 1300),
    "ratio": (iv.log1p_ratio_point, _ratio, lambda: [0.0, *ratios()], 1300),
}


@pytest.mark.parametrize("name", POINTS)
def test_a_point_function_encloses_and_is_tight(name) -> None:
    kernel, reference, arguments, bits = POINTS[name]
    widest = 0.0
    with mp.workprec(bits):
        for x in arguments():
            if name in ("sin", "cos") and abs(x) > 1e3:
                continue
            lo, hi = kernel(x)
            value = reference(mpf(x))
            assert lo <= value <= hi, (name, x.hex(), lo, hi)
            if abs(value) > TINY:
                widest = max(widest, float((mpf(hi) - mpf(lo)) / abs(value)))
    assert widest < 2e-15


def test_the_ratio_is_one_at_zero_and_tight_beside_it() -> None:
    assert iv.log1p_ratio_point(0.0)[1] == 1.0
    for d in (0.0, 5e-324, 1e-300, 1e-20, 1e-9):
        lo, hi = iv.log1p_ratio((d, d))
        assert hi - lo <= 9.0 * iv.U


# --- Intervals of arguments


CURVES = {
    "sin": (iv.sin, mpmath.sin, -60.0, 60.0),
    "cos": (iv.cos, mpmath.cos, -60.0, 60.0),
    "exp": (iv.exp, mpmath.exp, -700.0, 700.0),
    "ratio": (iv.log1p_ratio, _ratio, -0.9, 9.0),
}


@pytest.mark.parametrize("name", CURVES)
def test_an_interval_function_encloses_every_value_and_its_own_parts(name) -> None:
    kernel, reference, left, right = CURVES[name]
    rng = random.Random(5)
    with mp.workprec(120):
        for _ in range(500):
            start = rng.uniform(left, right)
            a = (start, min(start + 10.0 ** rng.uniform(-12, 1), right))
            found = kernel(a)
            for _ in range(6):
                x = min(max(a[0] + (a[1] - a[0]) * rng.random(), a[0]), a[1])
                assert found[0] <= reference(mpf(x)) <= found[1], (name, a, x)
            part = (x, a[1])
            inner = kernel(part)
            assert found[0] <= inner[0] + 1e-14 * abs(inner[0])
            assert inner[1] - 1e-14 * abs(inner[1]) <= found[1]
            assert found[0] < found[1]


def test_extrema_are_found_and_only_those() -> None:
    assert iv.sin((1.5, 1.6))[1] == iv.cos((-0.1, 0.1))[1] == iv.cos((6.2, 6.3))[1] == 1.0
    assert iv.sin((4.7, 4.8))[0] == iv.cos((3.1, 3.2))[0] == iv.sin((-1.6, -1.5))[0] == -1.0
    assert iv.sin((0.0, 7.0)) == iv.cos((900.0, 999.0)) == (-1.0, 1.0)
    lo, hi = iv.sin((0.5, 1.5))
    assert lo > 0.479
    assert hi < 0.998
    lo, hi = iv.cos((3.2, 6.2))
    assert lo > -0.999
    assert hi < 0.997


# --- A million points against the functions' own identities


@jit
def violations(x, y):
    """How often an identity is refuted by its enclosures: never, if they enclose."""
    count = 0
    for i in range(x.size):
        s, c = iv.sin((x[i], x[i])), iv.cos((x[i], x[i]))
        one = iv.sub(iv.add(iv.sqr(s), iv.sqr(c)), (1.0, 1.0))
        twice = iv.sub(iv.sin((2.0 * x[i], 2.0 * x[i])), iv.scale(iv.mul(s, c), 2.0))
        back = iv.sub(iv.exp(iv.log1p_point(y[i])), iv.add((1.0, 1.0), (y[i], y[i])))
        shared = iv.sub(iv.mul(iv.log1p_ratio_point(y[i]), (y[i], y[i])), iv.log1p_point(y[i]))
        for each in (one, twice, back, shared):
            if not iv.contains_zero(each):
                count += 1
        if one[1] - one[0] > 3e-15 or shared[1] - shared[0] > 1e-14 * iv.mag(iv.log1p_point(y[i])) + 1e-300:
            count += 1
    return count


def test_a_million_points_agree_with_the_identities() -> None:
    rng = np.random.default_rng(6)
    half = 500_000
    x = np.concatenate([rng.uniform(-500.0, 500.0, half), 10.0 ** rng.uniform(-300.0, 2.0, half)])
    y = np.concatenate([rng.uniform(0.0, 3.0, half) + 1e-12, 10.0 ** rng.uniform(-250.0, 250.0, half)])
    assert violations(x, y) == 0


# --- What the proofs rest on


def test_constants_of_the_reductions() -> None:
    with mp.workprec(400):
        half_pi = mpf(iv.HALF_PI_HIGH) + mpf(iv.HALF_PI_MID) + mpf(iv.HALF_PI_LOW)
        assert abs(mpmath.pi / 2 - half_pi) < mpf(2) ** -141
        assert abs(mpmath.log(2) - mpf(iv.LN2_HIGH) - mpf(iv.LN2_LOW)) < mpf(2) ** -102
        assert iv.PER_HALF_PI - iv.U < 2 / mpmath.pi < iv.PER_HALF_PI + iv.U
        assert 1 + mpf(iv.NEAR_RIGHT) < mpmath.sqrt(2) < 1 / (1 + mpf(iv.NEAR_LEFT)) + mpf(1e-3)
        assert 1 + mpf(iv.NEAR_LEFT) > mpmath.sqrt(mpf("0.5"))
        assert mpmath.exp(700) > 1e304
        assert mpmath.exp(-700) < 1e-304
        for x in (iv.NEAR_LEFT, iv.NEAR_RIGHT):
            assert abs(mpf(x) / (2 + mpf(x))) < mpf(ball.ATANH_RANGE.numerator) / ball.ATANH_RANGE.denominator
            assert abs(mpmath.log1p(mpf(x))) > 0.3455
        assert (mpmath.sqrt(2) - 1) / (mpmath.sqrt(2) + 1) < 0.17158
    for value, grid in ((iv.HALF_PI_HIGH, 40), (iv.HALF_PI_MID, 82), (iv.LN2_HIGH, 42)):
        assert exact(value) % Fraction(1, 2**grid) == 0
    assert abs(iv.HALF_PI_LOW) < 2.0**-85
    assert abs(iv.HALF_PI_MID) < 2.0**-42
    assert abs(iv.LN2_LOW) < 2.0**-44


def test_bounds_are_at_least_what_the_count_of_errors_asks_for() -> None:
    """One unit more is for the subtraction of the radius; 0.04 for its own roundings and second orders."""
    own = 1.04
    assert max(ball.sine(), ball.cosine()) + own < iv.TURN_BOUND / iv.U
    assert ball.exponential() + own < iv.EXP_BOUND / iv.U
    assert max(ball.near(), ball.ratio()) + own < iv.NEAR_BOUND / iv.U
    on_tail, on_value = ball.far()
    assert on_tail < iv.FAR_TAIL_BOUND / iv.U
    assert on_value + own < iv.FAR_BOUND / iv.U


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the mnemonics of x86")
def test_the_machine_code_fuses_nothing_and_calls_no_libm() -> None:
    @numba.njit(error_model="numpy")
    def everything(a, b):
        total = iv.div(iv.mul(iv.add(a, b), iv.sub(a, b)), iv.root(iv.sqr(a)))
        total = iv.add(total, iv.mul(iv.sin(a), iv.cos(b)))
        return iv.add(total, iv.mul(iv.exp(a), iv.log1p_ratio(b)))

    everything((0.1, 0.2), (0.3, 0.4))
    code = "\n".join(everything.inspect_asm().values())
    assert len(re.findall(r"\bv?mul[sp]d\b", code)) > 100
    assert not re.findall(r"\bvfn?m(?:add|sub)\w*", code)
    assert not re.findall(r"\b(?:sin|cos|exp|log|log1p|pow|fma|ldexp|frexp)\b", code)


def test_plain_python_computes_the_same() -> None:
    a, b = (0.3, 0.7), (1.1, 2.3)
    for each in (iv.add, iv.sub, iv.mul, iv.div, iv.hull):
        assert each(a, b) == each.py_func(a, b)
    for each in (iv.sin, iv.cos, iv.exp, iv.log1p_ratio, iv.root, iv.sqr):
        assert each(a) == each.py_func(a)
    for each in (iv.exp_point, iv.log1p_point, iv.log1p_ratio_point):
        for x in (1e-5, 0.2, 3.0, 1e-310):
            assert each(x) == each.py_func(x)


def test_each_function_has_one_compiled_signature() -> None:
    for each in vars(iv).values():
        if hasattr(each, "signatures"):
            assert len({tuple(map(numba.core.types.unliteral, kinds)) for kinds in each.signatures}) <= 1, each
