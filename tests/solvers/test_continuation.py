"""A control loop's solver: it follows small steps, and a step that fails moves nothing."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.kernels import layout
from cablewright.kernels.statics.line.upright import LOG_SLACK
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

HOUSE = Model(load("house-printer"))
START = np.full(4, 28.0)
PLAIN = TrackerSettings(certify=False)
SIDES = {"merlet2023": (2.3, 4.7, 2.0), "paty2021": (3.5, 3.5, 4.0)}


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
    tracker, sure = Tracker(model, START, PLAIN), Tracker(model, START)
    for out in np.linspace(0.0, 0.2, 100):
        lengths = START + np.array([out, 0.0, 0.0, 0.0])
        assert tracker.step(lengths) is Status.OK
        slack = tracker.states[0, layout.TAU] <= LOG_SLACK
        assert sure.step(lengths) is (Status.UNCERTIFIED if slack else Status.OK)
    assert slack
    np.testing.assert_allclose(tracker.pose, solve_forward(model, lengths).pose, atol=1e-7)


def path(name: str, step: float) -> tuple[Model, np.ndarray, np.ndarray]:
    """A closed path of 28 m at *step* (m): the model, the poses and their lengths, one line slack in between."""
    x, y, z = SIDES[name]
    corners = np.array([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z), (-x, -y, z)])
    sides = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    assert sides.sum() == pytest.approx(28.0)
    along = np.arange(0.0, 28.0 + 0.5 * step, step)
    poses = np.column_stack([np.interp(along, np.concatenate([[0.0], sides.cumsum()]), each) for each in corners.T])
    model = Model(load(name), tension_limits=(20.0, 5150.0))
    lengths = solve_inverse(model, poses).checked().lengths
    lengths[:, 0] += 0.3 * np.sin(np.pi * np.clip((along / 28.0 - 0.3) / 0.4, 0.0, 1.0)) ** 2
    return model, poses, lengths


@pytest.mark.parametrize("name", ["merlet2023", "paty2021"])
def test_a_line_goes_slack_and_taut_again_and_every_step_is_certified(name: str) -> None:
    model, poses, lengths = path(name, 0.01)
    tracker = Tracker(model, lengths[0])
    pulls = []
    for row in range(1, len(lengths)):
        assert tracker.step(lengths[row]) is Status.OK
        pulls.append(np.exp(tracker.states[0, layout.TAU]))
        if row % 50 == 0:
            cold = solve_forward(model, lengths[row]).checked()
            np.testing.assert_allclose(tracker.pose, cold.pose, rtol=0, atol=1e-9)
    assert min(pulls) < 10.0 < 20.0 < min(pulls[0], pulls[-1])  # N
    np.testing.assert_allclose(tracker.pose, poses[-1], rtol=0, atol=1e-9)


def test_a_body_is_followed_to_the_pose_that_its_lengths_are_of() -> None:
    model = Model(load("cogiro"))
    ends = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [2.0, 3.0, 3.0, 0.05, -0.05, 0.1]])
    poses = ends[0] + np.linspace(0.0, 1.0, 300)[:, None] * (ends[1] - ends[0])
    lengths = solve_inverse(model, poses).checked().lengths
    tracker = Tracker(model, lengths[0])
    for row in range(1, 300):
        assert tracker.step(lengths[row]) is Status.OK
    np.testing.assert_allclose(tracker.pose, poses[-1], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "out"),
    [("cogiro", 3.0), ("grab-four-lines", 0.3), ("jung2020", 0.3), ("paty2021", 3.0)],
)
def test_a_step_too_far_is_said_to_jump(name: str, out: float) -> None:
    model = Model(load(name))
    begin = cases.poses(model, 1)[0]
    tracker = Tracker(model, begin.lengths)
    pose, lengths = tracker.pose.copy(), begin.lengths.copy()
    lengths[0] += out
    assert tracker.step(lengths) is Status.JUMPED
    np.testing.assert_array_equal(tracker.pose, pose)
    assert tracker.step(begin.lengths + 1e-4) is Status.OK


@pytest.mark.parametrize("name", ["grab-four-lines", "cogiro", "jung2020", "paty2021", "merlet2023"])
def test_a_large_step_ends_where_small_ones_end_or_is_rejected(name: str) -> None:
    model, rng = Model(load(name)), np.random.default_rng(5)
    held = cases.poses(model, 4)
    followed = 0
    for begin, size in product(held.lengths, (0.01, 0.03, 0.1, 0.3)):
        one, many = Tracker(model, begin), Tracker(model, begin, PLAIN)
        change = rng.normal(0.0, size, model.m)
        if one.step(begin + change) is not Status.OK:
            continue
        followed += 1
        for part in np.linspace(0.0, 1.0, 501)[1:]:
            assert many.step(begin + part * change) is Status.OK
        np.testing.assert_allclose(one.pose, many.pose, rtol=0, atol=1e-8)
    assert followed > 3


def towards_a_fold(settings: TrackerSettings) -> tuple[Tracker, Status]:
    """A body of eight lines whose lengths change until it can no longer be followed; the last steps are ever smaller.

    At a fold two equilibria meet and vanish.
    """
    model = Model(load("cogiro"))
    begin = cases.poses(model, 12)[11].lengths
    way = np.random.default_rng(6).normal(0.0, 1.0, (12, 8))[11]
    tracker, done, step, status = Tracker(model, begin, settings), 0.0, 0.02, Status.OK
    while step > 1e-8:
        status = tracker.step(begin + (done + step) * way / np.abs(way).max())
        if status is Status.OK:
            done += step
        else:
            step /= 2.0
    return tracker, status


def test_a_fold_is_said() -> None:
    tracker, status = towards_a_fold(TrackerSettings(fold=1e-3))
    assert status is Status.FOLD
    assert 1e-3 <= tracker.margin < 1.01e-3


def test_behind_a_fold_there_is_nothing_to_follow() -> None:
    tracker, status = towards_a_fold(TrackerSettings())
    assert status in (Status.NOT_CONVERGED, Status.JUMPED, Status.FOLD, Status.SINGULAR)
    assert tracker.margin < 1e-3


def test_a_tolerance_that_cannot_be_met_is_uncertified() -> None:
    tracker = Tracker(HOUSE, START, TrackerSettings(tolerance=1e-16))
    pose = tracker.pose.copy()
    assert tracker.step(START - 0.001) is Status.UNCERTIFIED
    np.testing.assert_array_equal(tracker.pose, pose)


@pytest.mark.parametrize("name", ["tolerance", "jump", "fold"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_settings_that_are_no_bounds_are_rejected(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        TrackerSettings(**{name: value})


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
def test_lengths_of_the_wrong_count_or_not_finite_are_rejected(lengths: list[float]) -> None:
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
    with pytest.raises(InputError, match="do not determine tensions"):
        Tracker(Model(HOUSE.robot, Fidelity(CableLaw.RIGID)), START)


@pytest.mark.parametrize(
    ("name", "start", "line", "end", "dead"),
    [
        ("merlet2023", [8.742508004272134, 10.224249814461707, 10.84382845414174, 9.606922400419826], 1, 13.7638, 4.03),
        ("house-printer", [27.26226562359615, 31.86645744919, 31.69024896333, 25.0847361934782], 2, 33.1919, 14.8973),
    ],
)
@pytest.mark.parametrize("steps", [1, 3, 50])
def test_a_dead_span_does_not_fall_into_a_loop_unsaid(
    name: str, start: list[float], line: int, end: float, dead: float, steps: int
) -> None:
    """Metres let out in one step lead Newton to a loop behind the sheave, micrometres away in pose: the step is cut."""
    tracker = Tracker(Model(load(name)), start)
    wanted = np.array(start)
    wanted[line] = end
    for way in np.linspace(0.0, 1.0, steps + 1)[1:]:
        assert tracker.step(start + way * (wanted - start)) is Status.OK
    assert tracker.states[line, layout.DEAD] == pytest.approx(dead, abs=1e-3)
