"""A floor that what was laid hides from the vertical lidar, and a drum that stands while it does."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.estimation.kalman.state import FilterState, inflate_position
from cablewright.estimation.kalman.vertical_scan import level_sigma
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Command, Estimate, Truth
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from twins import SETTINGS, TWIN, machine

_Before = Callable[[int, SimulatedMachine, Any], None]
"""What happens before a step, by its number: to the machine, or to the estimator's state."""


def stand(
    estimator: str, steps: int, before: _Before, settings: TwinSettings = TWIN
) -> tuple[list[tuple[Estimate, Truth]], Array]:
    """Estimates and truths of a machine that stands, and by how much each height is too high (steps,), m."""
    twin = machine(settings, plant="quasi-static", seed=3)
    one, still = OBSERVERS[estimator], Command(0.0, np.zeros(4))
    known = one.settings(load("merlet2023"), twin.settings, ())
    state, recording = one.start(known), []
    for step in range(steps):
        before(step, twin, state)
        estimate = one.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
        recording.append((estimate, twin.truth))
    return recording, np.array([estimate.position[2] - truth.position[2] for estimate, truth in recording])


def lay(twin: SimulatedMachine, first: float, last: float, powder: float) -> None:
    """Seven ridges from *first* to *last*, m beside the platform, each of so many kg of *powder*."""
    x, y, _ = twin.truth.position.tolist()
    for aside in (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9):
        twin.rig.ground.deposit((x + first, y + aside), (x + last, y + aside), powder)


def covered(step: int, twin: SimulatedMachine, _state: Any) -> None:
    """All the ground in sight is under powder from step 40 on."""
    if step == 40:
        lay(twin, -1.8, 1.8, 60.0)


def move(state: FilterState, up: float, sigma: float) -> None:
    """Let a *state* be wrong by *up*, m, in all that has a height, and doubt that by *sigma*, m."""
    assert state.taut is not None
    wrong = np.array([0.0, 0.0, up])
    state.motion.position = state.motion.position + wrong
    state.lines.lengths = state.lines.lengths + state.taut.toward @ wrong
    inflate_position(state, [0.0, 0.0, sigma])
    ground = state.layout.ground
    state.P[ground, ground] += 0.1**2  # or the distance sensor would correct the height immediately


@pytest.mark.parametrize("estimator", OBSERVERS)
def test_a_hidden_floor_is_not_found_in_the_material_above_it(estimator: str) -> None:
    recording, _ = stand(estimator, 120, covered)
    off = np.array([estimate.position - truth.position for estimate, truth in recording[20:]])
    assert np.abs(off[:, 2]).max() < 0.01
    last, _ = recording[-1]
    assert last.valid
    assert "no floor in sight near the expected height" in {fault.sentence for fault in last.faults}
    assert last.clearance < last.position[2] - 0.03


def test_a_filter_knows_that_a_drum_stands_that_no_lidar_sees_go() -> None:
    """Two minutes on, it is as sure of its height as it was, and says nothing of its encoders."""
    recording, _ = stand("filter", 160, covered)
    early, late = recording[45][0], recording[-1][0]
    assert early.covariance is not None
    assert late.covariance is not None
    assert late.covariance[2, 2] < 4.0 * early.covariance[2, 2] + 0.005**2
    assert not any(fault.source == "encoders" for estimate, _ in recording for fault in estimate.faults)
    assert np.abs(late.velocity).max() < 1e-3


@pytest.mark.parametrize("estimator", OBSERVERS)
def test_a_drum_that_sinks_under_new_powder_is_where_the_floor_says(estimator: str) -> None:
    """A sudden refill stretches the lines: no shaking, no count, and all the floor in sight is nearer."""
    nearly_empty = TWIN.with_owner(drum=SETTINGS.drum.model_copy(update={"powder": 2.0}))

    def refilled(step: int, twin: SimulatedMachine, _state: Any) -> None:
        if step == 30:
            twin.refill(28.0)

    recording, off = stand(estimator, 60, refilled, with_severity(nearly_empty, "rough", ("exits",)))
    heights = [float(truth.position[2]) for _, truth in recording]
    assert heights[29] - heights[30] > 0.01
    assert np.abs(off[20:30]).max() < 5e-3
    assert np.abs(off[40:]).max() < 5e-3  # two turns of the lidar later, five steps each


@pytest.mark.parametrize(("wrong", "is_found"), [(6e-3, True), (-6e-3, True), (0.03, False)])
def test_where_no_floor_is_in_sight_known_ground_gives_the_height(wrong: float, is_found: bool) -> None:
    """Most of the ground is laid on while the rest shows the floor; then all is. Large deviations are rejected."""

    def laid_on(step: int, twin: SimulatedMachine, state: Any) -> None:
        if step == 30:
            lay(twin, -0.1, 1.8, 30.4)
        if step == 90:
            lay(twin, -1.8, -0.1, 27.2)
        if step == 151:
            move(state.filter, wrong, 4e-3)
        if step > 160:
            claimed.append(level_sigma(state.filter))

    claimed: list[float] = []
    recording, off = stand("filter", 260, laid_on)
    assert min(claimed) > 1.9e-3  # it is the same ground in each turn
    assert "no floor in sight near the expected height" in {fault.sentence for fault in recording[-1][0].faults}
    assert np.abs(off[20:150]).max() < 3e-3
    assert abs(off[152]) > 0.5 * abs(wrong)
    assert (np.abs(off[240:]).max() < 3e-3) == is_found


def test_a_wrong_height_does_not_make_its_own_ground() -> None:
    """Few rays meet the floor, and the state is 8 mm too high: no ground is remembered by it, and the floor wins."""

    def mistaken(step: int, twin: SimulatedMachine, state: Any) -> None:
        if step == 30:
            lay(twin, -0.3, 1.8, 33.0)
        if step == 61:
            move(state.filter, 8e-3, 3e-3)
            state.filter.built.ground_map = GroundMap()

    _, off = stand("filter", 1000, mistaken)
    assert np.abs(off[20:60]).max() < 3e-3
    assert off[61] > 6e-3
    assert abs(off[-1]) < 3e-3
