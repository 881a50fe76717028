"""Compliances in the filter: their part in the motion of B against differences, and their determination by
equilibria."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

from cablewright.estimation.kalman import line_update
from cablewright.estimation.kalman.state import FilterState
from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering import predict, sagging_lines
from cablewright.live.estimator_settings import started_settings, with_drum_mass
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at
from observer_runs import differences, shown
from twins import SETTINGS

ROBOT = load("merlet2023")
STARTED = started_settings(ROBOT, SETTINGS)
KNOWN = STARTED.filter


def test_a_compliance_moves_b_as_differences_of_its_motion(later: FilterState) -> None:
    paid_out, step = np.array([2e-3, -1e-3, 3e-3, 1e-3]), 1e-6
    state = copy.deepcopy(later)
    line_update.update_jacobian(KNOWN, state, at_once=True)
    taut, sag = state.taut, state.hung.sag
    assert taut is not None
    assert sag is not None
    lines, h = KNOWN.machine.model.lines, sag.forces(line_update.excess(state))
    stretching = sag.laws[sagging_lines.STRETCHING] * np.cos(taut.angles)
    sagging = (lines.weight * np.cos(taut.angles)) ** 2 * taut.free**3 / (12.0 * h**3)

    def moved(shares: Array) -> Array:
        weighted = taut.toward.T / (stretching * np.exp(shares) + sagging)
        return np.asarray(np.linalg.solve(weighted @ taut.toward, weighted) @ paid_out)

    assert state.hung.jacobian @ paid_out == pytest.approx(moved(np.zeros(4)), rel=1e-6)
    loosened = paid_out - taut.toward @ moved(np.zeros(4))
    assert np.abs(loosened).max() > 1e-4
    for way, by in zip(step * np.eye(4), (state.hung.by_compliance * loosened).T, strict=True):
        assert (moved(way) - moved(-way)) / (2.0 * step) == pytest.approx(by, rel=1e-5, abs=1e-9)


def spread(state: FilterState) -> None:
    x, _, at = state.mean
    hung, lines = state.hung, state.lines
    predict.spread(x, state.P, at, hung.jacobian, hung.by_compliance, lines.loosened, 0.0, 1.0, 0.0)


def test_it_is_in_the_covariance_of_b_once(later: FilterState) -> None:
    state, lay = copy.deepcopy(later), later.layout
    state.lines.stretching, state.lines.loosened = 0.0, np.array([1e-3, -2e-3, 1e-3, 0.0])
    by, before = state.hung.by_compliance * state.lines.loosened, state.P.copy()
    spread(state)
    F = np.eye(lay.size)
    F[lay.position, lay.compliances] = by
    assert pytest.approx(F @ before @ F.T, abs=1e-16) == state.P
    again = state.P.copy()
    spread(state)
    assert (again == state.P).all()


@pytest.mark.parametrize("soft", [0, 2])
def test_a_line_that_gives_twice_as_much_is_found_by_equilibria(later: FilterState, soft: int) -> None:
    """Places and lengths are known; equilibria of the robot determine the compliance of each line."""
    robot = with_drum_mass(ROBOT, SETTINGS)
    halved = robot.lines[soft].cable.model_copy(
        update={"young_modulus": 0.5 * (robot.lines[soft].cable.young_modulus or np.nan)}
    )
    lines = tuple(
        line.model_copy(update={"cable": halved}) if i == soft else line for i, line in enumerate(robot.lines)
    )
    model = Model(robot.model_copy(update={"lines": lines}))
    state, lay = copy.deepcopy(later), later.layout
    state.lines.zeros, state.attitude.shaken_time, state.motion.mass = np.zeros(4), -np.inf, SETTINGS.carrier.empty_mass
    state.motion.mass += SETTINGS.carrier.powder
    settings = dataclasses.replace(KNOWN, mass_sigma=1e-3)
    first = settings.compliance_sigma
    state.lines.compliances = np.ones(4)
    state.P[:] = 0.0
    rows = np.arange(lay.compliances.start, lay.compliances.stop)
    state.P[rows, rows] = first**2
    places = np.random.default_rng(3).uniform([-1.5, -2.5, 0.8], [1.5, 2.5, 1.6], (40, 3))
    for place in places:
        held, taut = solve_inverse(model, place).checked(), taut_at(KNOWN.machine.model, place)
        own = LineStates(held.states)
        state.motion.position, state.lines.lengths = place.copy(), held.lengths.copy()
        line_update.update_jacobian(settings, state, at_once=True)
        assert state.hung.sag is not None
        forces = np.exp(own.log_tension) * np.cos(own.free_angle)
        angles = differences(state.hung.sag, forces)
        state.slackness = shown(state.slackness, differences=angles, excess=np.zeros(4), variances=np.full(4, 1e-8))
        assert taut.lengths == pytest.approx(state.taut.lengths if state.taut else np.nan, rel=1e-12)
        state.lines.last_angle_time = -np.inf
        line_update.update(settings, state)
    sigma = np.sqrt(state.P[rows, rows])
    true = np.ones(4)
    true[soft] = 2.0
    assert sigma.max() < 0.5 * first
    assert (np.abs(np.log(state.lines.compliances / true)) < 3.0 * sigma).all()
    assert state.lines.compliances[soft] > 1.5
