"""Inverse problem with preferred tensions: the nearest to them that balance the load within the limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import cases
import shared_winch_robots
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.solvers import held_tensions
from cablewright.solvers.inverse import inverse, solve_inverse
from cablewright.solvers.preferred_tensions import preferred_tensions
from cablewright.solvers.tension import tension_distribution

SEED = 11
PLAIN = Fidelity(CableLaw.RIGID, SheaveLaw.EYELET)
HEAVY = 1e7  # what balance weighs against the distance in SciPy's least squares
REDUNDANT = [robot for robot in cases.robots() if robot.m > robot.n]
STRAIGHT = [model for model in cases.models(CableLaw.RIGID, CableLaw.ELASTIC) if model.robot in REDUNDANT]
FULL = [Model(robot) for robot in REDUNDANT]


def asked_for(model: Model, rows: int, seed: int = SEED) -> np.ndarray:
    """Preferred tensions (rows, m): most of them within the limits."""
    rng = np.random.default_rng(seed)
    low, high = np.transpose([line.tension_limits for line in model.robot.lines])
    return low + (high - low) * rng.uniform(-0.02, 0.3, (rows, model.m))


def wrenches(found: Equilibrium) -> np.ndarray:
    """Wrench (N, n, m) per tension of straight lines from eyelets."""
    points = found.platform_points
    towards = np.array([line.exit_point for line in found.model.robot.lines]) - points
    towards /= np.linalg.norm(towards, axis=2, keepdims=True)
    arms = points - found.pose[:, None, :3]
    return np.concatenate([towards, np.cross(arms, towards)], axis=2).swapaxes(1, 2)[:, : found.model.n]


@pytest.mark.parametrize("model", [*STRAIGHT, *FULL], ids=cases.name)
def test_they_balance_the_load_within_the_limits(model: Model) -> None:
    poses = cases.poses(model, 20).pose
    found = solve_inverse(model, poses, preferred=asked_for(model, 20))
    held = found[found.ok]
    assert len(held.code) >= 18  # of a body, tensions preferred may not hold it upright
    assert held.is_valid(1e-9)
    assert (held.margin() >= -1e-6).all()
    assert not held.violation.any()


@pytest.mark.parametrize("robot", REDUNDANT, ids=lambda robot: robot.name)
def test_of_straight_lines_they_are_scipys_projection(robot: Robot) -> None:
    model = Model(robot, PLAIN)
    wanted = asked_for(model, 8)
    found = solve_inverse(model, cases.poses(model, 8).pose, preferred=wanted)
    assert found.ok.all()
    low, high = np.transpose([line.tension_limits for line in robot.lines])
    for A, tensions, near in zip(wrenches(found), found.tensions, wanted, strict=True):
        load_there = A @ tensions  # that it is the load's is for the test above
        rows, right = np.vstack([HEAVY * A, np.eye(robot.m)]), np.append(HEAVY * load_there, near)
        theirs = lsq_linear(rows, right, (low, high), method="bvls", tol=1e-15, max_iter=1000).x
        np.testing.assert_allclose(tensions, theirs, rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize("robot", REDUNDANT, ids=lambda robot: robot.name)
def test_of_straight_lines_they_meet_the_conditions_of_the_best(robot: Robot) -> None:
    """Karush, Kuhn and Tucker: the remaining gradient points into limits alone."""
    model = Model(robot, PLAIN)
    wanted = asked_for(model, 40)
    found = solve_inverse(model, cases.poses(model, 40).pose, preferred=wanted)
    low, high = np.transpose([line.tension_limits for line in robot.lines])
    turned_back = 0
    for A, tensions, near in zip(wrenches(found), found.tensions, wanted, strict=True):
        at_low, at_high = tensions < low + 1e-6, tensions > high - 1e-6
        free = ~(at_low | at_high)
        multipliers = np.linalg.lstsq(A[:, free].T, (tensions - near)[free], rcond=None)[0]
        wish = near - tensions + A.T @ multipliers
        scale = np.abs(near).max()
        assert np.abs(wish[free]).max() < 1e-7 * scale
        if free.sum() >= model.n:  # fewer leave the multipliers undecided
            assert (wish[at_low] < 1e-7 * scale).all()
            assert (wish[at_high] > -1e-7 * scale).all()
        turned_back += int((~free).sum())
    assert turned_back > 0


@pytest.mark.parametrize("model", STRAIGHT, ids=cases.name)
def test_what_balances_already_stays(model: Model) -> None:
    """Preferred tensions that hold the pose are taken as they are: the least-norm ones, and any others found."""
    poses = cases.poses(model, 10).pose
    for first in (solve_inverse(model, poses), solve_inverse(model, poses, preferred=asked_for(model, 10))):
        held = first[first.ok]
        again = solve_inverse(model, held.pose, preferred=held.tensions)
        np.testing.assert_allclose(again.tensions, held.tensions, rtol=1e-6, atol=1e-5)
        np.testing.assert_allclose(again.lengths, held.lengths, rtol=0, atol=1e-8)


@pytest.mark.parametrize("model", FULL, ids=cases.name)
def test_with_sag_they_stay_but_for_the_cables_weight(model: Model) -> None:
    """Distances are compared between pulls, mid-span: from the tension at the sheave that is up to the cable's
    weight."""
    held = cases.poses(model, 10)
    again = solve_inverse(model, held.pose, preferred=held.tensions)
    weight = max(line.cable.linear_density for line in model.robot.lines) * model.robot.scene.gravity
    assert np.abs(again.tensions - held.tensions).max() < 2.0 * weight * held.lengths.max()


@pytest.mark.parametrize("model", FULL, ids=cases.name)
def test_to_prefer_nothing_is_the_default_to_the_last_bit(model: Model) -> None:
    poses = cases.random_poses(model, 30, SEED)
    plain, zero = solve_inverse(model, poses), solve_inverse(model, poses, preferred=np.zeros(model.m))
    np.testing.assert_array_equal(zero.code, plain.code)
    np.testing.assert_array_equal(zero.lengths, plain.lengths)
    np.testing.assert_array_equal(zero.states, plain.states)


@pytest.mark.parametrize("model", FULL, ids=cases.name)
def test_what_is_preferred_decides_no_feasibility(model: Model) -> None:
    poses = cases.random_poses(model, 60, SEED)
    plain, other = solve_inverse(model, poses), solve_inverse(model, poses, preferred=asked_for(model, 60))
    assert plain.ok.any()
    if model.n == 3:  # whether a body stays upright is a matter of its tensions
        np.testing.assert_array_equal(other.ok, plain.ok)


def test_a_batch_takes_one_row_for_all_or_one_for_each() -> None:
    robot = load("house-printer")
    poses = cases.poses(Model(robot), 70).pose
    wanted = asked_for(Model(robot), 70)
    each = inverse(robot, poses, preferred=wanted)
    for row in (0, 33, 69):
        np.testing.assert_array_equal(inverse(robot, poses[row], preferred=wanted[row]).tensions, each.tensions[row])
    together = inverse(robot, poses, preferred=wanted[7])
    np.testing.assert_array_equal(together.tensions[7], each.tensions[7])
    np.testing.assert_array_equal(
        together.lengths, inverse(robot, poses, preferred=np.tile(wanted[7], (70, 1))).lengths
    )


def test_more_is_preferred_more_is_had_until_a_limit_is_reached() -> None:
    """Four lines can be tensed in one way: two that face each other more, the others less."""
    robot = load("paty2021")
    wanted = np.linspace(0.0, 4000.0, 9)[:, None] * np.ones(4)
    held = inverse(robot, np.zeros((9, 3)), preferred=wanted)
    np.testing.assert_allclose(held.tensions - held.tensions[0], 0.0, atol=1e-6)  # by symmetry there is no more to have
    tilted = inverse(robot, np.zeros((9, 3)), preferred=wanted * [1.0, 0.0, 1.0, 0.0])
    assert (np.diff(tilted.tensions[:, 0]) >= -1e-9).all()
    assert tilted.tensions[-1, 0] > tilted.tensions[0, 0] + 80.0
    assert tilted.tensions[:, 1].min() >= 510.0 - 1e-6


def test_too_few_lines_leave_no_choice() -> None:
    robot = load("grab-four-lines")
    pose = [1.0, 0.3, -0.2, np.nan, np.nan, 0.0]
    np.testing.assert_array_equal(inverse(robot, pose, preferred=[90.0] * 4).lengths, inverse(robot, pose).lengths)


@pytest.mark.parametrize(
    "wanted", [[1.0], [1.0] * 5, [[1.0] * 4] * 3, [1.0, 2.0, 3.0, np.nan], [np.inf] * 4, "abcd", 5.0, [[[1.0] * 4]]]
)
def test_what_are_no_tensions_is_rejected(wanted: object) -> None:
    with pytest.raises(InputError, match="preferred tensions"):
        inverse(load("merlet2023"), [[0, 0, 1], [0, 0, 2]], preferred=wanted)


def unlimited(name: str) -> Robot:
    """A robot of the library without minimum tensions."""
    robot = load(name)
    limits = [{"tension_limits": (0.0, line.tension_limits[1])} for line in robot.lines]
    lines = tuple(line.model_copy(update=own) for line, own in zip(robot.lines, limits, strict=True))
    return robot.model_copy(update={"lines": lines})


@pytest.mark.parametrize("name", ["jung2020", "hangprinter-v4", "ipanema"])
def test_lines_that_pull_against_each_other_stay_near_the_middle_of_limits_from_zero(name: str) -> None:
    model = Model(unlimited(name))
    preferred = preferred_tensions(model)
    assert preferred is not None
    np.testing.assert_allclose(preferred[0], [0.5 * line.tension_limits[1] for line in model.robot.lines])
    assert preferred_tensions(Model(load(name))) is None


@pytest.mark.parametrize("name", ["cogiro", "house-printer", "merlet2023"])
def test_lines_that_hang_the_platform_stay_near_a_share_of_its_weight(name: str) -> None:
    model = Model(unlimited(name))
    preferred = preferred_tensions(model)
    assert preferred is not None
    share = model.robot.platform.mass * model.robot.scene.gravity / model.m
    np.testing.assert_allclose(preferred[0], share)


@pytest.mark.parametrize("free", [False, True], ids=["limits", "limits from zero"])
@pytest.mark.parametrize("name", ["jung2020", "cogiro", "house-printer", "hangprinter-v4"])
def test_every_verb_has_the_same_tensions_by_default(name: str, free: bool) -> None:
    robot = unlimited(name) if free else load(name)
    middle = 0.5 * np.add(robot.scene.frame_min, robot.scene.frame_max)
    middle[2] = robot.scene.frame_min[2] + 0.2 * (robot.scene.frame_max[2] - robot.scene.frame_min[2])
    pose = Model(robot).unrotated_at(middle[None])[0]
    held = inverse(robot, pose, cable="rigid")
    assert held.ok
    np.testing.assert_allclose(tension_distribution(robot, pose).tensions, held.tensions, rtol=1e-4)


def test_lengths_do_not_jump_along_a_path_where_the_least_tension_is_zero() -> None:
    robot = unlimited("hangprinter-v4")
    path = np.linspace([-0.3, -0.3, 0.3], [0.3, 0.3, 0.3], 301)
    lengths = inverse(robot, path).lengths
    step = np.linalg.norm(path[1] - path[0])
    assert (np.abs(np.diff(lengths, axis=0)) <= 1.1 * step * Model(robot).lines.spans).all()


def hoist(weight: float) -> Robot:
    """A point on four winches, and on a counterweight of *weight*, kg, above."""
    exits = {"a": (-1.0, -1.0, 3.0), "b": (1.0, -1.0, 3.0), "c": (1.0, 1.0, 3.0), "d": (-1.0, 1.0, 3.0)}
    every = {"sheave": {"kind": "eyelet"}, "cable": shared_winch_robots.CABLE, "tension_limits": (2.0, 400.0)}
    lines = [
        every | {"name": name, "exit_point": place, "winch": shared_winch_robots.WINCH} for name, place in exits.items()
    ]
    return Robot.model_validate({
        "name": "hoist",
        "scene": {"frame_min": (-0.5, -0.5, 0.0), "frame_max": (0.5, 0.5, 1.0)},
        "platform": {"kind": "point", "mass": 5.0},
        "lines": [*lines, every | {"name": "up", "exit_point": (0.0, 0.0, 3.5), "counterweight": weight}],
    })  # fmt: skip


@pytest.mark.parametrize("weight", [0.25, 2.0])
def test_a_counterweight_near_its_limit_takes_no_margin_from_the_lines_with_winches(weight: float) -> None:
    model, poses = Model(hoist(weight)), np.array([[0.0, 0.0, 0.5], [0.2, 0.1, 0.6]])
    narrow, share = held_tensions.with_margin(model, poses, None)
    assert share == 1.0
    assert [line.tension_limits[0] for line in narrow.robot.lines] == [4.0, 4.0, 4.0, 4.0, 2.0]
    assert (solve_inverse(narrow, poses).tensions[:, :4] >= 4.0).all()
