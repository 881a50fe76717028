"""A floor that what was laid hides from the vertical lidar, and a drum that stands while it does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.estimation.kalman.state import FilterState, inflate_position
from cablewright.machine.simulated.severities import with_severity
from cablewright.robot import load
from cablewright.signals import Command, Estimate, Truth
from cablewright.studies.estimator_settings import OBSERVERS
from twins import SETTINGS, TWIN, machine


def stand(estimator: str, covered_from: int, steps: int) -> list[tuple[Estimate, Truth]]:
    """A machine that stands, a step a second, all the ground in sight under powder from some step on."""
    twin = machine(plant="quasi-static", seed=3)
    one, still = OBSERVERS[estimator], Command(0.0, np.zeros(4))
    known = one.settings(load("merlet2023"), twin.settings, ())
    state, recording = one.start(known), []
    x, y, _ = twin.truth.position.tolist()
    for step in range(steps):
        if step == covered_from:
            for aside in (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9):
                twin.rig.ground.deposit((x - 1.8, y + aside), (x + 1.8, y + aside), 60.0)
        estimate = one.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
        recording.append((estimate, twin.truth))
    return recording


def move(state: FilterState, up: float, sigma: float) -> None:
    """Let a *state* be wrong by *up*, m, in all that has a height, and doubt that by *sigma*, m."""
    assert state.taut is not None
    wrong = np.array([0.0, 0.0, up])
    state.position = state.position + wrong
    state.lengths = state.lengths + state.taut.toward @ wrong
    state.ground_height += up
    inflate_position(state, [0.0, 0.0, sigma])


@pytest.mark.parametrize("estimator", OBSERVERS)
def test_a_floor_that_is_hidden_is_not_found_in_what_hides_it(estimator: str) -> None:
    recording = stand(estimator, 40, 120)
    off = np.array([estimate.position - truth.position for estimate, truth in recording[20:]])
    assert np.abs(off[:, 2]).max() < 0.01
    last, _ = recording[-1]
    assert last.valid
    assert "no floor in sight near the expected height" in {fault.sentence for fault in last.faults}
    assert last.clearance < last.position[2] - 0.03


def test_a_filter_knows_that_a_drum_stands_that_no_lidar_sees_go() -> None:
    """Two minutes on, it is as sure of its height as it was, and says nothing of its encoders."""
    recording = stand("filter", 40, 160)
    early, late = recording[45][0], recording[-1][0]
    assert early.covariance is not None
    assert late.covariance is not None
    assert late.covariance[2, 2] < 4.0 * early.covariance[2, 2] + 0.005**2
    assert not any(fault.source == "encoders" for estimate, _ in recording for fault in estimate.faults)
    assert np.abs(late.velocity).max() < 1e-3


@pytest.mark.parametrize("estimator", OBSERVERS)
def test_a_drum_that_sinks_under_new_powder_is_where_the_floor_says(estimator: str) -> None:
    """A refill stretches the lines, at once: no shaking, no count, and all the floor in sight is nearer."""
    nearly_empty = TWIN.with_owner(drum=SETTINGS.drum.model_copy(update={"powder": 2.0}))
    twin, one = (
        machine(with_severity(nearly_empty, "rough", ("exits",)), plant="quasi-static", seed=3),
        OBSERVERS[estimator],
    )
    known = one.settings(load("merlet2023"), twin.settings, ())
    state, still, off, heights = one.start(known), Command(0.0, np.zeros(4)), [], []
    for step in range(60):
        if step == 30:
            twin.refill(28.0)
        estimate = one.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
        off.append(estimate.position[2] - twin.truth.position[2])
        heights.append(float(twin.truth.position[2]))
    assert heights[29] - heights[30] > 0.01
    assert np.abs(off[20:30]).max() < 5e-3
    assert np.abs(off[40:]).max() < 5e-3  # two turns of the lidar later, five steps each


@pytest.mark.parametrize(("wrong", "is_found"), [(6e-3, True), (-6e-3, True), (0.03, False)])
def test_where_no_floor_is_in_sight_the_ground_that_was_seen_tells_the_height(wrong: float, is_found: bool) -> None:
    """Most of the ground is laid on while the rest shows the floor; then all is. What is far off is not believed."""
    twin, one = machine(plant="quasi-static", seed=3), OBSERVERS["filter"]
    known, still, off = one.settings(load("merlet2023"), twin.settings, ()), Command(0.0, np.zeros(4)), []
    state = one.start(known)
    x, y, _ = twin.truth.position.tolist()
    for step in range(260):
        for begin, first, last in ((30, -0.1, 1.8), (90, -1.8, -0.1)):
            for aside in (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9) if step == begin else ():
                twin.rig.ground.deposit((x + first, y + aside), (x + last, y + aside), 16.0 * (last - first))
        estimate = one.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
        if step == 150:
            assert state.filter is not None
            move(state.filter, wrong, 4e-3)
        off.append(estimate.position[2] - twin.truth.position[2])
    assert "no floor in sight near the expected height" in {fault.sentence for fault in estimate.faults}
    assert np.abs(off[20:150]).max() < 3e-3
    assert abs(off[152]) > 0.5 * abs(wrong)
    assert (np.abs(off[240:]).max() < 3e-3) == is_found


def test_a_wrong_height_does_not_make_its_own_ground() -> None:
    """Few rays meet the floor, and the state is 8 mm too high: no ground is remembered by it, and the floor wins."""
    twin, one = machine(plant="quasi-static", seed=3), OBSERVERS["filter"]
    known, still, off = one.settings(load("merlet2023"), twin.settings, ()), Command(0.0, np.zeros(4)), []
    state = one.start(known)
    x, y, _ = twin.truth.position.tolist()
    for step in range(1000):
        for aside in (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9) if step == 30 else ():
            twin.rig.ground.deposit((x - 0.3, y + aside), (x + 1.8, y + aside), 33.0)
        estimate = one.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
        if step == 60:
            assert state.filter is not None
            move(state.filter, 8e-3, 3e-3)
            state.filter.ground_map = GroundMap()
        off.append(estimate.position[2] - twin.truth.position[2])
    assert np.abs(off[20:60]).max() < 3e-3
    assert off[61] > 6e-3
    assert abs(off[-1]) < 3e-3
