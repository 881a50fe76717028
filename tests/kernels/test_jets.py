"""Jets enclose values, first and second derivatives: against differentiation with 50 digits, at points of the box."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from cablewright.kernels.certificates import jets
from cablewright.kernels.certificates.interval import inflate, point
from cablewright.kernels.statics.line import spatial_enclosure

mp.dps = 15
SLOTS = (0, 3, 9)
CENTRE = (0.6, 0.35, 0.8)


def variables(radius: float) -> list[Any]:
    """Jets of three variables about CENTRE."""
    return [jets.variable(inflate(point(x), radius), slot, jets.BENT) for x, slot in zip(CENTRE, SLOTS, strict=True)]


def smooth(x: Any, y: Any, z: Any, at: Any) -> Any:
    """A formula with every operation, of jets or of numbers."""
    top = at.minus(at.times(x, at.sine(y)), at.cosine(at.plus(z, x)))
    below = at.square_root(at.plus(at.times(y, y), at.times(z, z)))
    return at.plus(at.over(top, below), at.angle(at.minus(x, z), at.over(y, x)))


class Numbers:
    """The operations of jets on numbers."""

    plus, minus, times = staticmethod(lambda a, b: a + b), staticmethod(lambda a, b: a - b), staticmethod(mp.fmul)
    over, square_root = staticmethod(lambda a, b: a / b), staticmethod(mp.sqrt)
    sine, cosine, angle = staticmethod(mp.sin), staticmethod(mp.cos), staticmethod(lambda x, y: mp.atan2(y, x))


def assert_encloses(jet: Any, of: Callable[..., Any], where: np.ndarray, slots: tuple[int, ...]) -> None:
    """Value and derivatives of the function at a point *where* are in the jet, as far as it has them."""
    with mp.workdps(50):
        at = [mpf(float(x)) for x in where]
        each = [(0, mp.fsum([of(*at)]))]
        for i, slot in enumerate(slots):
            each.append((1 + slot, mp.diff(of, at, tuple(int(k == i) for k in range(len(at))))))
        for row, pair in enumerate(jets.PAIRS.tolist(), start=jets.SLOPED):
            orders = [pair.count(slot) for slot in slots]
            if sum(orders) == 2 and row < jet.shape[0]:
                each.append((row, mp.diff(of, at, tuple(orders))))
        for row, value in each:
            low, high = jets.of(jet, row)
            slack = mpf(10) ** -18 * (1 + abs(value))  # of the differentiation
            assert low - slack <= value <= high + slack, (row, low, value, high)


@pytest.mark.parametrize("radius", [0.0, 1e-6, 0.02])
def test_formulas_are_enclosed(radius: float) -> None:
    jet, rng = smooth(*variables(radius), jets), np.random.default_rng(1)
    for _ in range(3):
        where = np.array(CENTRE) + radius * rng.uniform(-1.0, 1.0, 3)
        assert_encloses(jet, lambda x, y, z: smooth(x, y, z, Numbers), where, SLOTS)
    assert np.ptp(jet[: jets.SLOPED], axis=1).max() < 1e-13 + 60.0 * radius


def mean(heavy: Any, v: Any) -> Any:
    """Mean of 1 / q along a span: q^2 = (v + s heavy)^2 + 1 - v^2 at s from -1 to 1."""
    flat = mp.sqrt(1 - v * v)
    return (mp.asinh((v + heavy) / flat) - mp.asinh((v - heavy) / flat)) / (2 * heavy)


def rise(heavy: Any, v: Any) -> Any:
    """Mean of the vertical part of the direction along a span, over v."""
    return (mp.sqrt(1 + 2 * heavy * v + heavy * heavy) - mp.sqrt(1 - 2 * heavy * v + heavy * heavy)) / (2 * heavy * v)


@pytest.mark.parametrize(("heavy", "v"), [(0.01, 0.4), (2.5, 0.6)])
def test_the_means_are_those_of_a_quadrature(heavy: float, v: float) -> None:
    with mp.workdps(40):
        h, u = mpf(heavy), mpf(v)

        def norm(s: Any) -> Any:
            return mp.sqrt(1 + 2 * s * h * u + s * s * h * h)

        assert abs(mean(h, u) - mp.quad(lambda s: 1 / norm(s), [-1, 0, 1]) / 2) < 1e-20
        assert abs(rise(h, u) - mp.quad(lambda s: (u + s * h) / norm(s), [-1, 0, 1]) / 2 / u) < 1e-20


@pytest.mark.parametrize("rows", [jets.SLOPED, jets.BENT])
@pytest.mark.parametrize(("heavy", "v"), [(0.01, 0.4), (0.3, -0.7), (2.5, 0.6)])
@pytest.mark.parametrize("share", [1e-9, 0.1])
def test_a_sagging_span_is_enclosed(heavy: float, v: float, share: float, rows: int) -> None:
    """Of light and of heavy spans, also beyond the series."""
    box = [inflate(point(x), r) for x, r in ((heavy, share * heavy), (v, 0.1 * share))]
    level, upright = spatial_enclosure._span(jets.variable(box[0], 1, rows), jets.variable(box[1], 3, rows))
    slots = (1, 3)
    for where in ((heavy, v), (heavy * (1 - share), v + 0.1 * share)):
        assert_encloses(level, mean, np.array(where), slots)
        assert_encloses(upright, rise, np.array(where), slots)
    if rows == jets.SLOPED and share < 1e-6:
        assert np.ptp(level[0]) < 1e-7
