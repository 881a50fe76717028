"""Radii of winch drums: exact lengths, noise that the filter's covariance admits, and a coil wound for a test."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.estimation.merlet2023 import drum_radius
from cablewright.estimation.merlet2023.drum_radius import RadiusSettings
from cablewright.foundation.errors import InputError
from cablewright.models.coil import wind

KNOWN = np.ones(2, dtype=bool)


def settings(rule: str = "filter", **changes: float) -> RadiusSettings:
    return RadiusSettings((0.05, 0.05), 0.04, 0.075, rule=rule, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("rule", ["paper", "filter"])
def test_exact_lengths_give_exact_radii(rule: str) -> None:
    known, state = settings(rule, length_sigma=1e-6, random_walk=0.0), drum_radius.start(settings())
    true = np.array([0.0537, 0.0481])
    for k in range(12):
        angles = np.array([0.6, -0.4]) * k
        state = drum_radius.step(known, state, 9.0 + true * angles, angles, KNOWN)
    assert state.radii == pytest.approx(true, abs=1e-7)


def test_a_drum_at_rest_shows_nothing() -> None:
    state = drum_radius.start(settings("paper"))
    for k in range(3):
        state = drum_radius.step(settings("paper"), state, np.array([9.0, 9.0 + 0.01 * k]), np.zeros(2), KNOWN)
    assert state.radii == pytest.approx([0.05, 0.05])


def test_an_unknown_line_shows_nothing() -> None:
    state = drum_radius.start(settings())
    for k in range(20):
        angles = np.full(2, 0.5 * k)
        state = drum_radius.step(settings(), state, 9.0 + 0.06 * angles, angles, np.array([True, False]))
    assert state.radii[0] == pytest.approx(0.06, rel=5e-3)
    assert state.radii[1] == 0.05


def test_errors_are_as_large_as_the_filter_says() -> None:
    """Over many drums whose radius walks as assumed, squared errors over variances are 1 on average."""
    known, random, ratios = settings(), np.random.default_rng(3), []
    for _ in range(150):
        true = 0.055 + known.sigma * random.standard_normal(2) * 0.5
        state, lengths, angles = (
            drum_radius.start(known)._replace(radii=np.full(2, 0.055)),
            np.full(2, 9.0),
            np.zeros(2),
        )
        state = state._replace(covariance=state.covariance * 0.25)
        for _ in range(25):
            turned = np.array([0.5, -0.3])
            true = true + known.random_walk * np.sqrt(np.abs(turned)) * random.standard_normal(2)
            lengths, angles = lengths + true * turned, angles + turned
            measured = lengths + known.length_sigma * random.standard_normal(2)
            state = drum_radius.step(known, state, measured, angles, KNOWN)
        ratios.append(((state.radii - true) / state.sigmas) ** 2)
    assert 0.75 < np.mean(ratios) < 1.3


def test_a_change_of_layers_is_followed() -> None:
    coil = wind(30.0, 0.05, 0.075, 0.003, 0.0026)
    known, random = settings(), np.random.default_rng(5)
    begin, state = coil.angle(9.0), drum_radius.start(settings())  # layer 2 begins at 7.85 m
    errors = []
    for k in range(80):
        angle = begin - 0.5 * k  # winding off
        length = np.full(2, 25.0 - coil.length(angle)) + 1e-3 * random.standard_normal(2)
        state = drum_radius.step(known, state, length, np.full(2, 0.5 * k), KNOWN)
        errors.append(state.radii / coil.radius(angle) - 1.0)
    changed = next(k for k in range(80) if coil.radius(begin - 0.5 * k) < 0.0515)
    assert np.abs(errors[changed + 20 :]).max() < 0.01
    assert np.abs(errors[20 : changed - 10]).max() < 0.01


def test_after_unhooking_the_next_state_only_begins() -> None:
    state = drum_radius.start(settings())
    for k in range(10):
        state = drum_radius.step(settings(), state, np.full(2, 9.0 + 0.03 * k), np.full(2, 0.5 * k), KNOWN)
    off = drum_radius.step(settings(), drum_radius.without_reference(state), np.full(2, 4.0), np.zeros(2), KNOWN)
    assert np.array_equal(off.radii, state.radii)


def test_radii_out_of_range_are_rejected() -> None:
    with pytest.raises(InputError, match="nominal"):
        RadiusSettings((0.2,), 0.04, 0.075)
    with pytest.raises(InputError, match="min_radius"):
        RadiusSettings((0.05,), 0.06, 0.05)
