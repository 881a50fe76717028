"""Excess from angles: the inverse of a hanging line's angle, straight lines beside rigid cables, dead sensors."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from cablewright.estimation import slackness
from cablewright.estimation.slackness import SlacknessSettings, SlacknessState, catenary_excess, parabolic_excess
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import LineAngles
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.slack import angle_from_excess, solve_with_slack, tangent_angle
from cablewright.solvers.taut import taut_at

MODEL = Model(load("merlet2023"))
SETTINGS = SlacknessSettings(MODEL)
PLACES = [(0.3, -1.0, 1.2), (-1.2, 2.5, 0.9), (0.0, 0.0, 2.0), (1.4, -3.8, 1.5)]


@pytest.mark.parametrize("place", PLACES)
def test_taut_lines_are_rigid_cables(place: tuple[float, float, float]) -> None:
    at = np.array(place)
    found = taut_at(MODEL, at)
    rigid = solve_inverse(Model(MODEL.robot, Fidelity.of("rigid", None)), at).lengths
    assert found.lengths == pytest.approx(rigid, abs=1e-9)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-5
        slope = (taut_at(MODEL, at + step).lengths - taut_at(MODEL, at - step).lengths) / 2e-5
        assert found.toward[:, axis] == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("excess", [2e-3, 5e-3, 0.03])
@pytest.mark.parametrize("line", [0, 3])
def test_an_excess_comes_back_from_its_angle(place: tuple[float, float, float], excess: float, line: int) -> None:
    taut = taut_at(MODEL, np.array(place))
    angle = float(angle_from_excess(MODEL, place, line, 0.2, excess))
    difference = angle - taut.angles[line]
    assert catenary_excess(SETTINGS, taut, line, difference) == pytest.approx(excess, rel=1e-3)
    parabola = parabolic_excess(SETTINGS, taut, np.full(4, difference))[line]
    assert parabola == pytest.approx(excess, rel=0.2)


def test_a_tight_line_shows_nothing() -> None:
    held = solve_with_slack(MODEL, PLACES[0], {3: 0.02})
    taut = taut_at(MODEL, np.array(PLACES[0]))
    shown = np.array([float(tangent_angle(held, i, 0.2)) for i in range(4)]) - taut.angles
    assert (shown[:3] < SETTINGS.visible_angle).all()
    assert shown[3] > 5 * SETTINGS.visible_angle


def steps(angles: list[np.ndarray], state: SlacknessState | None = None, begin: float = 0.0) -> SlacknessState:
    taut, state = taut_at(MODEL, np.array(PLACES[0])), state or slackness.start(SETTINGS)
    for k, measured in enumerate(angles):
        state = slackness.step(SETTINGS, state, LineAngles(begin + 0.01 * k, taut.angles + measured), taut)
    return state


def noisy(count: int, size: float = 0.05, seed: int = 1) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [np.array([0.0, 0.0, 0.0, size]) + 1e-3 * random.standard_normal(4) for _ in range(count)]


@pytest.mark.parametrize(("period", "count"), [(0.01, 1000), (1.0, 11)])
def test_the_scatter_of_readings_is_found(period: float, count: int) -> None:
    """Standard deviations of readings of 0.06 deg, and of 6 deg; by ten readings, if these are seconds apart."""
    settings, taut = dataclasses.replace(SETTINGS, timeout=2.5, gate=1.0), taut_at(MODEL, np.array(PLACES[0]))
    random, sizes = np.random.default_rng(4), np.array([1e-3, 1e-3, 0.1, 0.1])
    state = slackness.start(settings)
    for k in range(count):
        angles = taut.angles + sizes * random.standard_normal(4)
        state = slackness.step(settings, state, LineAngles(period * k, angles), taut)
    found = np.sqrt(state.scatter)
    assert (found[:2] < 4e-3).all()
    assert (np.abs(np.log(found[2:] / 0.1)) < math.log(2.0)).all()


def test_a_line_that_vibrates_is_not_taken_for_one_that_stands() -> None:
    """By half an amplitude of 1.4 deg at least, from the first hundredths of a second on."""
    taut, state = taut_at(MODEL, np.array(PLACES[0])), slackness.start(SETTINGS)
    for k in range(100):
        angles = taut.angles + 0.025 * np.sin(2.0 * np.pi * 0.5 * (0.01 * k + np.arange(4)))
        state = slackness.step(SETTINGS, state, LineAngles(0.01 * k, angles), taut)
        assert (np.sqrt(state.scatter) > 0.0125).all()


def test_one_reading_astray_is_left_out_and_a_step_is_believed() -> None:
    before = steps(noisy(100))
    once = steps([np.array([0.9, 0.0, 0.0, 0.05])], before, 1.0)
    assert once.differences[0] == before.differences[0]
    after = steps(noisy(20, 0.4), before, 1.0)
    assert after.differences[3] == pytest.approx(0.4, abs=3e-3)


def test_a_dead_and_a_stuck_line_are_not_known() -> None:
    measured = noisy(200)
    for each in measured[50:]:
        each[1] = np.nan
        each[2] = 0.1234
    found = steps(measured)
    assert np.isnan(found.excess).tolist() == [False, True, True, False]
    assert found.stuck.tolist() == [False, False, True, False]


def test_readings_that_are_not_new_change_nothing() -> None:
    state = steps(noisy(10))
    assert steps(noisy(1, 0.2), state, 0.02) is state


def test_indistinguishable_input_is_rejected() -> None:
    with pytest.raises(InputError, match="without weight"):
        SlacknessSettings(Model(MODEL.robot, Fidelity.of("elastic", None)))
    with pytest.raises(InputError, match="smoothing_time"):
        dataclasses.replace(SETTINGS, smoothing_time=math.inf)
