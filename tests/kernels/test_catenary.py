"""The span against the textbook form with 50 digits, from hanging straight down to taut."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from cablewright.kernels.statics.line.catenary import span
from oracles.irvine import span as textbook


def by_chance(count: int) -> list[tuple[float, float, float, float, float]]:
    rng = np.random.default_rng(1)
    rows = []
    for _ in range(count):
        h = 10 ** rng.uniform(-9, 5) * rng.choice([-1, 1])
        v = 10 ** rng.uniform(-3, 5) * rng.choice([-1, 1])
        length, weight = 10 ** rng.uniform(-2, 2.5), 10 ** rng.uniform(-4, 1)
        rows.append((h, v, length, weight, 10 ** rng.uniform(4, 9)))
    return rows


def test_its_end_is_the_textbooks() -> None:
    for h, v, length, weight, stiffness in by_chance(300):
        x, z, *_ = span(h, v, length, weight, 1 / stiffness)
        exact_x, exact_z = textbook(h, v, length, weight, stiffness)
        assert abs(x - exact_x) < 2e-14 * abs(exact_x) + 1e-300, (h, v, length, weight, stiffness)
        # z is the difference of two tensions: its own cancellation at equal heights is geometry, not error
        assert abs(z - exact_z) < 2e-14 * max(abs(exact_z), length * 1e-2), (h, v, length, weight, stiffness)


@pytest.mark.parametrize(("h", "v", "length", "weight", "stiffness"), by_chance(100))
def test_its_derivatives_are_the_textbooks(h: float, v: float, length: float, weight: float, stiffness: float) -> None:
    _, _, x_h, x_v, z_v, x_l, z_l, v1 = span(h, v, length, weight, 1 / stiffness)

    def exact(which: int, at: int) -> mpf:
        with mp.workdps(60):
            values = [mpf(h), mpf(v), mpf(length)]
            step = values[which] * mpf(10) ** -20
            low, high = list(values), list(values)
            low[which] -= step
            high[which] += step
            ends = [textbook(*each, weight, stiffness)[at] for each in (low, high)]
            return (ends[1] - ends[0]) / (2 * step)

    size = max(abs(x_h), abs(z_v))
    for ours, theirs, scale in (
        (x_h, exact(0, 0), abs(x_h)),
        (x_v, exact(1, 0), size),
        (x_v, exact(0, 1), size),
        (z_v, exact(1, 1), abs(z_v)),
        (x_l, exact(2, 0), abs(x_l) + 1e-9),
        (z_l, exact(2, 1), abs(z_l) + 1e-9),
    ):
        assert abs(ours - theirs) < 1e-10 * scale
    assert v1 == v + weight * length


def test_without_weight_it_is_a_spring() -> None:
    x, z, *_ = span(300.0, -400.0, 10.0, 0.0, 1e-5)
    assert x == pytest.approx(6.0 * 1.005, rel=1e-15)
    assert z == pytest.approx(-8.0 * 1.005, rel=1e-15)


def test_its_weight_fades_linearly() -> None:
    flat = np.array(span(300.0, -400.0, 10.0, 0.0, 1e-5)[:2])
    sags = [np.linalg.norm(np.array(span(300.0, -400.0, 10.0, w, 1e-5)[:2]) - flat) for w in (1e-2, 1e-4, 1e-6)]
    assert sags[0] / sags[1] == pytest.approx(100, rel=1e-2)
    assert sags[1] / sags[2] == pytest.approx(100, rel=1e-4)


def test_hanging_straight_down_and_folded() -> None:
    x, z, *_ = span(0.0, -3.0, 10.0, 1.0, 0.0)  # ten newtons of cable, three of them held here
    assert x == 0.0
    assert z == pytest.approx(-3.0 + 7.0)
    assert all(np.isfinite(span(0.0, -3.0, 10.0, 1.0, 0.0)))
