"""The drum's mass in the filter: how far B sinks, against equilibria, and how sure that is."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from cablewright.estimation import started_filter
from cablewright.estimation.kalman import filter as error_state
from cablewright.estimation.kalman import line_update
from cablewright.estimation.kalman.drum_mass import weigh
from cablewright.estimation.kalman.state import FilterState, inflate_position
from cablewright.foundation.signals import Command, Scan, SensorFrame, Truth
from cablewright.live.estimator_settings import started_settings, with_drum_mass
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from twins import SETTINGS, TWIN, machine

ROBOT = with_drum_mass(load("merlet2023"), SETTINGS)
STARTED = started_settings(ROBOT, SETTINGS)
KNOWN = STARTED.filter


def heavier(mass: float) -> Model:
    return Model(ROBOT.model_copy(update={"platform": ROBOT.platform.model_copy(update={"mass": mass})}))


@pytest.mark.parametrize(("change", "looser"), [(2.0, 0.0), (-10.0, 0.0), (20.0, 0.012), (-18.0, 0.012)])
def test_it_sinks_as_the_equilibrium_of_the_same_lengths(later: FilterState, change: float, looser: float) -> None:
    """Also where a line, *looser* by m, gets slack meanwhile."""
    state, evenly = copy.deepcopy(later), solve_inverse(Model(ROBOT), later.motion.position).checked()
    lengths = evenly.lengths + looser * (evenly.tensions == evenly.tensions.min())
    held = solve_forward(Model(ROBOT), lengths, guess=evenly.pose).checked()
    state.motion.position, state.lines.lengths, state.lines.compliances = held.pose.copy(), lengths.copy(), np.ones(4)
    line_update.update_jacobian(KNOWN, state, at_once=True)
    weigh(KNOWN, state, state.motion.mass + change)
    sunk = solve_forward(heavier(state.motion.mass), lengths, guess=held.pose).checked().pose - held.pose
    assert abs(sunk[2]) > 3e-4
    assert np.sign(sunk[2]) == -np.sign(change)
    moved = state.motion.position - held.pose
    assert np.linalg.norm(moved - sunk) < 0.05 * np.linalg.norm(sunk)
    assert (state.lines.lengths == lengths).all()


def test_that_is_as_unsure_as_it_is_far_and_nothing_else_is(later: FilterState) -> None:
    state, position = copy.deepcopy(later), later.layout.position
    weigh(KNOWN, state, state.motion.mass + 2.0)  # so little that nothing else is predicted with it
    moved = state.motion.position - later.motion.position
    added = state.P - later.P
    assert added[position, position] == pytest.approx(KNOWN.load_sigma**2 * float(moved @ moved) * np.eye(3), abs=1e-15)
    added[position, position] = 0.0
    assert not added.any()
    assert state.motion.coasted[:3] - later.motion.coasted[:3] == pytest.approx(moved)  # of earlier scans


def test_a_scan_begun_before_a_sink_or_bounce_gives_no_height(
    later: FilterState, whole: list[tuple[SensorFrame, Truth]]
) -> None:
    scan = next(
        reading for frame, _ in reversed(whole[:900]) for reading in frame.of(Scan) if reading.source == "vertical"
    )
    left = []
    for bounce_end in (scan.times[0] - 0.01, scan.times[0] + 0.01):
        state = copy.deepcopy(later)
        state.motion.bounce_end = bounce_end
        state.motion.position = state.motion.position + np.array([0.0, 0.0, 4e-3])
        inflate_position(state, [0.0, 0.0, 4e-3])
        state.turns.pending.append(scan)
        error_state._process_turn(KNOWN, state)
        assert not state.turns.pending
        left.append(state.motion.position[2] - later.motion.position[2])
    assert abs(left[0]) < 1e-3
    assert left[1] == pytest.approx(4e-3)
    weigh(KNOWN, state, state.motion.mass + 1e-3)
    assert state.motion.bounce_end == bounce_end
    weigh(KNOWN, state, state.motion.mass + 15.0)
    assert state.motion.bounce_end == pytest.approx(state.time + 0.5)


def test_a_drum_that_bounces_after_a_refill_leaves_no_fault_and_is_found() -> None:
    """The accelerometer shows a bounce, and rest again."""
    little = SETTINGS.drum.model_copy(update={"powder": 2.0})
    twin = machine(TWIN.with_owner(drum=little), seed=1)
    state, known = started_filter.start(STARTED), started_settings(ROBOT, twin.settings)
    off, faults = [], set()
    for step in range(3000):
        if step == 2400:
            twin.refill(20.0)
            started_filter.weigh(known, state, little.empty_mass + 20.0)
        estimate = started_filter.step(known, state, twin.step(Command(twin.time, np.zeros(4))))
        if step >= 2400:
            off.append(float(np.linalg.norm(estimate.position - twin.truth.position)))
            faults |= {fault.source for fault in estimate.faults}
    assert "inertial" not in faults
    assert max(off) < 8e-3  # it sinks by 4 mm, and bounces as far
    assert max(off[300:]) < 3e-3


def test_the_same_mass_again_changes_nothing(later: FilterState) -> None:
    state = copy.deepcopy(later)
    weigh(KNOWN, state, state.motion.mass)
    assert (state.motion.position == later.motion.position).all()
    assert (state.P == later.P).all()


def test_before_the_first_position_it_is_a_number() -> None:
    state = started_filter.start(STARTED)
    started_filter.weigh(STARTED, state, 42.0)
    assert state.filter.motion.mass == 42.0
    assert np.isnan(state.filter.motion.position).all()
