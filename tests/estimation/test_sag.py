"""The filter's laws of hanging lines against equilibria of the statics core."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from cablewright.estimation.kalman.sag import Sag, balanced, each_alone
from cablewright.estimation.slackness import catenary_excess
from cablewright.kernels.filtering.sagging_lines import share_at
from cablewright.live.estimator_settings import started_settings, with_drum_mass
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.slack import solve_with_slack
from cablewright.solvers.taut import taut_at
from observer_runs import differences, forces_at, unsure_at
from twins import SETTINGS

ROBOT = load("merlet2023")
SENSORS = started_settings(ROBOT, SETTINGS).chain.slackness
MODEL = Model(with_drum_mass(ROBOT, SETTINGS))
WEIGHT = (SETTINGS.drum.empty_mass + SETTINGS.drum.powder) * ROBOT.scene.gravity
PLACES = [(0.1, -0.3, 1.2), (0.8, -1.5, 1.0), (-1.0, 2.0, 1.5), (0.3, 0.4, 0.8)]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("excess", [None, 0.002, 0.01, 0.05])
def test_the_forces_of_an_equilibrium_are_among_those_that_balance(
    place: tuple[float, float, float], excess: float | None
) -> None:
    """And the laws give its excesses and angles, by those forces."""
    where = np.array(place)
    loosest = int(np.argmin(solve_inverse(MODEL, where).checked().tensions))
    held = solve_inverse(MODEL, where) if excess is None else solve_with_slack(MODEL, where, {loosest: excess})
    found, taut = held.checked(), taut_at(MODEL, where)
    lines = LineStates(found.states)
    forces = np.exp(lines.log_tension) * np.cos(lines.free_angle)
    sag, may_be = Sag.at(SENSORS, taut, np.ones(MODEL.m)), balanced(SENSORS, taut, WEIGHT, 0.2 * WEIGHT)
    assert may_be is not None
    share = ((forces - may_be.forces[0]) / may_be.forces[1])[loosest]
    assert 0.0 <= share <= 1.0
    assert forces_at(may_be, np.array([share]))[0] == pytest.approx(forces, rel=0.02, abs=0.5)
    by_length = found.lengths - taut.lengths
    assert sag.excess(forces) == pytest.approx(by_length, rel=0.06, abs=3e-4)
    assert sag.excess(sag.forces(by_length)) == pytest.approx(by_length, rel=1e-2, abs=2e-4)


def test_forces_of_any_share_balance_the_weight() -> None:
    where = np.array(PLACES[1])
    taut = taut_at(MODEL, where)
    may_be = balanced(SENSORS, taut, WEIGHT, 0.2 * WEIGHT)
    assert may_be is not None
    shares = np.array([share_at(place) for place in np.linspace(0.0, 1.0, 33).tolist()])
    assert (np.diff(shares) > 0.0).all()
    assert (shares + shares[::-1]) == pytest.approx(1.0)
    for forces in forces_at(may_be, shares):
        assert (forces > 0.0).all()
        pull = -taut.toward.T @ (forces / np.hypot(taut.toward[:, 0], taut.toward[:, 1]))
        half = 0.5 * float((MODEL.lines.weight * taut.free).sum())
        assert pull[:2] == pytest.approx([0.0, 0.0], abs=1e-9 * WEIGHT)
        assert pull[2] == pytest.approx(WEIGHT + half, rel=1e-2)  # the straight line's slope at its sheave, not at B


@pytest.mark.parametrize("place", PLACES)
def test_forces_of_a_share_change_with_the_weight_as_is_said(place: tuple[float, float, float]) -> None:
    """A line that is slack at one limit of the range is slack there however heavy the drum is."""
    taut, shares = taut_at(MODEL, np.array(place)), np.linspace(0.0, 1.0, 5)
    may_be, heavier = (balanced(SENSORS, taut, WEIGHT + more, 10.0) for more in (0.0, 1.0))
    assert may_be is not None
    assert heavier is not None
    unsure = unsure_at(may_be, shares)
    assert forces_at(heavier, shares) - forces_at(may_be, shares) == pytest.approx(unsure[:, :, 0] / 10.0, abs=1e-6)
    for end in (0, -1):
        assert abs(unsure[end, np.argmin(forces_at(may_be, shares)[end]), 0]) < 1e-9
    assert np.abs(unsure).max() > 1.0


def test_no_forces_hold_a_drum_outside_its_exit_points() -> None:
    assert balanced(SENSORS, taut_at(MODEL, np.array([6.0, 0.0, 1.0])), WEIGHT, 1.0) is None


def test_a_slack_line_hangs_at_the_angle_of_its_catenary() -> None:
    where = np.array(PLACES[0])
    taut = taut_at(MODEL, where)
    sag = Sag.at(SENSORS, taut, np.ones(MODEL.m))
    for excess in (0.005, 0.02, 0.06):
        force = sag.forces(np.full(MODEL.m, excess))
        angles = differences(sag, force)
        for line in range(MODEL.m):
            exact = catenary_excess(SENSORS, taut, line, float(angles[line]))
            assert exact == pytest.approx(excess, rel=0.1)
            assert math.degrees(float(angles[line])) > 0.5


def test_three_lines_have_one_balance_and_five_none() -> None:
    def robot_of(lines: int) -> Model:
        every = (*ROBOT.lines, ROBOT.lines[0].model_copy(update={"name": "fifth"}))
        return Model(with_drum_mass(ROBOT, SETTINGS).model_copy(update={"lines": every[:lines]}))

    where = np.array([1.2, -2.0, 1.0])  # between the first three exit points
    for lines in (3, 5):
        model = robot_of(lines)
        sensors, taut = dataclasses.replace(SENSORS, model=model), taut_at(model, where)
        may_be = balanced(sensors, taut, WEIGHT, 1.0)
        if lines == 5:
            assert may_be is None
            continue
        held = solve_inverse(model, where).checked()
        states = LineStates(held.states)
        assert may_be is not None
        assert may_be.forces[0] == pytest.approx(
            np.exp(states.log_tension) * np.cos(states.free_angle), rel=0.02, abs=0.5
        )
        assert not may_be.forces[1].any()
    alone = each_alone(np.array([3.0, 200.0]))
    assert forces_at(alone, np.array([0.0, 1.0])).tolist() == [[3.0, 200.0]] * 2
