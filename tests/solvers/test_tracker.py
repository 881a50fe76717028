"""A control loop's solver: it follows small steps, and a step that fails moves nothing."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.errors import AnswerError, InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.track import Tracker

HOUSE = Model(load("house-printer"))
START = np.full(4, 28.0)


def tracked(model: Model = HOUSE) -> Tracker:
    return Tracker(model, START)


def test_steps_of_a_millimetre_are_followed() -> None:
    path = np.array([1.0, -2.0, 3.0]) + np.arange(500)[:, None] * [6e-4, 7e-4, -3.9e-4]  # 1 mm each
    lengths = solve_inverse(HOUSE, path).checked().lengths
    cold = solve_forward(HOUSE, lengths)
    tracker = Tracker(HOUSE, lengths[0])
    for row in range(1, 500):
        assert tracker.step(lengths[row]) is Status.OK
        np.testing.assert_allclose(tracker.pose, cold.pose[row], atol=1e-9)
        np.testing.assert_allclose(tracker.states, cold.states[row], atol=1e-8)


def test_elastic_lines_are_followed_through_slackness() -> None:
    model = Model(HOUSE.robot, Fidelity(CableLaw.ELASTIC))
    tracker = Tracker(model, START)
    for out in np.linspace(0.0, 0.2, 100):
        lengths = START + np.array([out, 0.0, 0.0, 0.0])
        assert tracker.step(lengths) is Status.OK
    np.testing.assert_allclose(tracker.pose, solve_forward(model, lengths).pose, atol=1e-7)


@pytest.mark.parametrize(
    "lengths",
    [
        pytest.param(np.full(4, 24.0), id="too short"),
    ],
)
@pytest.mark.parametrize("cable", [CableLaw.CATENARY, CableLaw.ELASTIC])
def test_a_step_that_fails_moves_nothing(cable: CableLaw, lengths: np.ndarray) -> None:
    tracker = Tracker(Model(HOUSE.robot, Fidelity(cable)), START)
    pose, states = tracker.pose.copy(), tracker.states.copy()
    assert tracker.step(lengths) is not Status.OK
    np.testing.assert_array_equal(tracker.pose, pose)
    np.testing.assert_array_equal(tracker.states, states)
    assert tracker.step(START - 0.001) is Status.OK


@pytest.mark.parametrize(
    "lengths",
    [
        [28.0] * 3,
        [28.0] * 5,
        [28.0, 28.0, 28.0, np.nan],
        [28.0, 28.0, 28.0, np.inf],
        [[28.0] * 4],
        [28.0, 28.0, 28.0, -28.0],
        ["a"] * 4,
    ],
)
def test_lengths_of_the_wrong_count_or_not_finite_are_refused(lengths: list[float]) -> None:
    tracker = tracked()
    pose = tracker.pose.copy()
    with pytest.raises(InputError, match="lengths"):
        tracker.step(lengths)
    np.testing.assert_array_equal(tracker.pose, pose)


def test_lengths_are_left_alone() -> None:
    tracker, lengths = tracked(), START - 0.002
    tracker.step(lengths)
    np.testing.assert_array_equal(lengths, START - 0.002)


def test_earlier_poses_stay_what_they_were() -> None:
    tracker = tracked()
    held = tracker.pose
    before = held.copy()
    tracker.step(START - 0.01)
    np.testing.assert_array_equal(held, before)


def test_two_trackers_do_not_disturb_each_other() -> None:
    one, other = tracked(), tracked()
    one.step(START - 0.01)
    np.testing.assert_array_equal(other.pose, tracked().pose)


def test_it_begins_only_where_there_is_an_equilibrium() -> None:
    with pytest.raises(AnswerError, match="breaking load"):
        Tracker(HOUSE, np.full(4, 24.0))
    with pytest.raises(InputError, match="leave tensions undecided"):
        Tracker(Model(HOUSE.robot, Fidelity(CableLaw.RIGID)), START)
