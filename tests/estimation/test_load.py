"""The drum's mass in the filter: how far B sinks, against equilibria, and how sure that is."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from cablewright.estimation import started_filter
from cablewright.estimation.kalman import line_update, vertical_update
from cablewright.estimation.kalman.load import weigh
from cablewright.estimation.kalman.state import FilterState, inflate_position
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.signals import Scan
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.estimator_settings import started_settings, with_drum_mass
from observed import drive
from twins import SETTINGS

ROBOT = with_drum_mass(load("merlet2023"), SETTINGS)
STARTED = started_settings(ROBOT, SETTINGS)
KNOWN = STARTED.filter


@pytest.fixture(scope="module")
def later() -> FilterState:
    state = started_filter.start(STARTED)
    for frame, _ in drive(9.0, seed=2):
        started_filter.step(STARTED, state, frame)
    assert state.chain is None
    return state.filter


def heavier(mass: float) -> Model:
    return Model(ROBOT.model_copy(update={"platform": ROBOT.platform.model_copy(update={"mass": mass})}))


@pytest.mark.parametrize("change", [2.0, -10.0])
def test_it_sinks_as_the_equilibrium_of_the_same_lengths(later: FilterState, change: float) -> None:
    state = copy.deepcopy(later)
    held = solve_inverse(Model(ROBOT), later.position).checked()
    state.position, state.lengths, state.compliances = later.position.copy(), held.lengths.copy(), np.ones(4)
    line_update.update_jacobian(KNOWN, state, at_once=True)
    excess = line_update.excess(state)
    weigh(KNOWN, state, state.mass + change)
    sunk = solve_forward(heavier(state.mass), held.lengths, guess=held.pose).checked().pose - held.pose
    assert abs(sunk[2]) > 3e-4
    assert np.sign(sunk[2]) == -np.sign(change)
    moved = state.position - later.position
    assert np.linalg.norm(moved - sunk) < 0.15 * np.linalg.norm(sunk)  # a line that is slack is less so under more load
    assert (state.lengths == held.lengths).all()
    assert state.loosened == pytest.approx(line_update.excess(state) - excess, abs=1e-12)


def test_that_is_as_unsure_as_it_is_far_and_nothing_else_is(later: FilterState) -> None:
    state, position = copy.deepcopy(later), later.layout.position
    weigh(KNOWN, state, state.mass + 5.0)
    moved = state.position - later.position
    added = state.P - later.P
    assert added[position, position] == pytest.approx(KNOWN.load_sigma**2 * np.outer(moved, moved), abs=1e-15)
    added[position, position] = 0.0
    assert not added.any()
    assert state.coasted[:3] - later.coasted[:3] == pytest.approx(moved)  # of what lidars saw before


def test_a_turn_that_began_before_it_sank_tells_no_height(later: FilterState) -> None:
    scan = next(
        reading
        for frame, _ in reversed(drive(9.0, seed=2))
        for reading in frame.of(Scan)
        if reading.source == "vertical"
    )
    left = []
    for sunk in (scan.times[0] - 0.01, scan.times[0] + 0.01):
        state = copy.deepcopy(later)
        state.sunk_time = sunk
        state.position = state.position + np.array([0.0, 0.0, 4e-3])
        inflate_position(state, [0.0, 0.0, 4e-3])
        vertical_update.update(KNOWN, state, scan)
        left.append(state.position[2] - later.position[2])
    assert abs(left[0]) < 1e-3
    assert left[1] == pytest.approx(4e-3, abs=3e-4)  # walls tell none
    weigh(KNOWN, state, state.mass + 1e-3)
    assert state.sunk_time == sunk
    weigh(KNOWN, state, state.mass + 15.0)
    assert state.sunk_time == state.time


def test_the_same_mass_again_changes_nothing(later: FilterState) -> None:
    state = copy.deepcopy(later)
    weigh(KNOWN, state, state.mass)
    assert (state.position == later.position).all()
    assert (state.P == later.P).all()


def test_before_the_first_position_it_is_a_number() -> None:
    state = started_filter.start(STARTED)
    started_filter.weigh(STARTED, state, 42.0)
    assert state.filter.mass == 42.0
    assert np.isnan(state.filter.position).all()
