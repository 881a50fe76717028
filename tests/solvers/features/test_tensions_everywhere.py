"""Tension methods of lines that share winches, against linear programs, conditions of optimality and `inverse`."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import linprog

import cablewright as cw
import shared_winch_robots
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.foundation.arrays import Array
from cablewright.robot import Robot, load
from cablewright.solvers.tension import METHODS
from physics.test_shared_winches import BELT, Straight, _structure, parallelograms, shared

TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


@cache
def body() -> Robot:
    """Eight lines of a body on seven winches, two of them of equal length on one drum."""
    return shared(load("jung2020"), (1, 0, 0.0, "along"))


@cache
def poses() -> Array:
    middle = 0.5 * (np.array(body().scene.frame_min) + np.array(body().scene.frame_max))
    found = np.random.default_rng(2).uniform(-1e-3, 1e-3, (24, 6))
    found[:, :3] += middle
    return found


def equations(pose: Array) -> tuple[Array, Array]:
    """Rows and right sides of the balance, and of the drum: d_1 (1 + t_0 c) = d_0 (1 + t_1 c), which is linear."""
    A, w = _structure(body(), pose)
    d, stiffness = Straight(body()).lines(pose)[0], body().lines[0].cable.stiffness
    drum = np.array([d[1], -d[0], 0, 0, 0, 0, 0, 0])
    return np.vstack([A, drum]), np.array([*-w, stiffness * (d[0] - d[1])])


def widest(pose: Array) -> float:
    """The largest distance of tensions from their limits, N; negative where the limits have to be relaxed."""
    rows, right = equations(pose)
    low, high = body().lines[0].tension_limits
    more = np.block([[-np.eye(8), np.ones((8, 1))], [np.eye(8), np.ones((8, 1))]])
    found = linprog(
        [*np.zeros(8), -1.0],
        A_ub=more,
        b_ub=[*np.full(8, -low), *np.full(8, high)],
        A_eq=np.column_stack([rows, np.zeros(len(rows))]),
        b_eq=right,
        bounds=(None, None),
        options=TIGHT,
    )
    return float(found.x[-1])


@pytest.mark.parametrize("method", METHODS)
def test_each_method_balances_and_fits_the_drum(method: str) -> None:
    found = cw.tension_distribution(body(), poses(), method, cable="elastic")
    for row, pose in enumerate(poses()):
        rows, right = equations(pose)
        pulls = (found.tensions[row] > 1.0).all()  # nothing pushes: drums are linearised at tensions over zero
        np.testing.assert_allclose(rows @ found.tensions[row], right, atol=1e-7 if pulls else 1.0)
    low, high = body().lines[0].tension_limits
    inside = np.minimum(found.tensions - low, high - found.tensions).min(axis=1)
    np.testing.assert_allclose(found.margin, inside, atol=1e-4)
    assert 2 < found.feasible.sum() < 24


def test_the_margin_is_that_of_a_linear_program() -> None:
    found = cw.tension_distribution(body(), poses(), "exact", cable="elastic")
    expected = np.array([widest(pose) for pose in poses()])
    pulls = (found.tensions > 1.0).all(axis=1)
    np.testing.assert_allclose(found.margin[pulls], expected[pulls], atol=1e-5)
    np.testing.assert_allclose(found.margin, expected, atol=0.1)
    np.testing.assert_array_equal(found.feasible, expected >= 0.0)


def test_the_least_norm_is_that_of_inverse() -> None:
    plain = cw.inverse(body(), poses(), cable="elastic", preferred=np.zeros(8))
    found = cw.tension_distribution(body(), poses(), cw.Quadratic(np.ones(8)), cable="elastic")
    np.testing.assert_array_equal(found.feasible, plain.ok)
    np.testing.assert_allclose(found.tensions[plain.ok], plain.tensions[plain.ok], atol=1e-6)
    general = cw.tension_distribution(body(), poses()[plain.ok], cw.Quadratic(np.eye(8)), cable="elastic")
    np.testing.assert_allclose(general.tensions, plain.tensions[plain.ok], atol=1e-3)


def test_the_nearest_tensions_are_a_projection() -> None:
    found = cw.tension_distribution(body(), poses(), "closed-form", cable="elastic")
    middle = np.mean(body().lines[0].tension_limits)
    for row in np.flatnonzero((found.tensions > 1.0).all(axis=1)):
        rows, _ = equations(poses()[row])
        off = found.tensions[row] - middle
        np.testing.assert_allclose(rows.T @ np.linalg.lstsq(rows.T, off)[0], off, atol=1e-3)


def test_a_belt_has_one_tension_a_wrench() -> None:
    """Three tensions by two equations of balance and one of the belt: each method finds them, if within limits."""
    robot = cw.loads(BELT)
    at = np.array([[x, 0.0, 0.99] for x in (-0.5, -0.1, 0.3, 0.6)])
    held = cw.inverse(robot, at, cable="elastic").checked()
    for method in METHODS:
        found = cw.tension_distribution(robot, at, method, cable="elastic")
        np.testing.assert_allclose(found.tensions, held.tensions, rtol=1e-7)
        assert found.feasible.all()
    assert not cw.tension_distribution(robot, [0.3, 0.0, 0.7], cable="elastic").feasible


def test_rigid_lines_that_do_not_fit_their_drum_have_no_tensions() -> None:
    pairs = parallelograms(4)
    fits, turned = [0.1, 0.2, 1.0, 0.0, 0.0, 0.0], [0.1, 0.2, 1.0, 0.0, 0.0, 0.1]
    found = cw.tension_distribution(pairs, [fits, turned], "exact")
    assert np.isneginf(found.margin[1])
    assert np.isnan(found.tensions[1]).all()
    free = pairs.model_copy(
        update={"lines": tuple(line.model_copy(update={"shared_winch": None}) for line in pairs.lines)}
    )
    assert found.margin[0] == pytest.approx(float(cw.tension_distribution(free, fits, "exact").margin), abs=1e-6)


def test_capacity_is_the_distance_to_the_end_of_linear_programs() -> None:
    """Along random directions the wrenches end where a program of the coupled tensions does."""
    pose, (low, high) = poses()[0], body().lines[0].tension_limits
    polytope = cw.available_wrenches(body(), pose, cable="elastic")
    rows, right = equations(pose)
    rng, found = np.random.default_rng(3), []
    for _ in range(30):
        direction = rng.normal(size=6)
        direction /= np.linalg.norm(direction)
        far = linprog(
            [*np.zeros(8), -1.0],
            A_eq=np.column_stack([rows, [*direction, 0.0]]),
            b_eq=right,
            bounds=[(low, high)] * 8 + [(None, None)],
            options=TIGHT,
        )
        along = polytope.normals @ -direction
        ends = polytope.distances(polytope.required)
        reach = np.nanmin(np.where(along > 1e-12, ends / np.where(along > 1e-12, along, 1.0), np.inf))
        found.append((far.x[-1], reach))
    tried = np.array(found)
    np.testing.assert_allclose(tried[:, 0], tried[:, 1], rtol=3e-3, atol=1e-2)
    margin = cw.capacity(body(), poses(), cable="elastic")
    np.testing.assert_allclose(margin.margin[0], polytope.margin, rtol=1e-9)
    assert (tried[:, 0] >= margin.margin[0] - 1e-2).all() or margin.margin[0] < 0.0
    assert (margin.rank == 6).all()
    np.testing.assert_array_equal(
        margin.margin > 1e-3, cw.tension_distribution(body(), poses(), "exact", cable="elastic").margin > 1e-3
    )


def test_closure_is_that_of_a_linear_program() -> None:
    """Tensions that grow without end keep the drum's lines in proportion to their stiffness."""
    found = cw.wrench_closure(body(), poses(), cable="elastic")
    for row, pose in enumerate(poses()[:6]):
        A, _ = _structure(body(), pose)
        d = Straight(body()).lines(pose)[0]
        rows = np.vstack([A, [d[1], -d[0], 0, 0, 0, 0, 0, 0], np.ones(8)])
        program = linprog(
            [*np.zeros(8), -1.0],
            A_ub=np.column_stack([-np.eye(8), np.ones(8)]),
            b_ub=np.zeros(8),
            A_eq=np.column_stack([rows, np.zeros(8)]),
            b_eq=[*np.zeros(7), 8.0],
            bounds=(None, None),
            options=TIGHT,
        )
        assert found.margin[row] == pytest.approx(program.x[-1], abs=5e-3)  # strains
    assert found.feasible.all()
    few = parallelograms(3)
    assert not cw.wrench_closure(few, [0.1, 0.2, 1.0, 0.0, 0.0, 0.0], cable="elastic").feasible


def test_the_workspace_is_where_tensions_are() -> None:
    box = np.column_stack([poses()[:, :3].mean(axis=0) - 3e-3, poses()[:, :3].mean(axis=0) + 3e-3]).ravel().tolist()
    found = count_nodes(body(), "exact", grid=3, box=box, cable="elastic")
    axes = [np.linspace(box[2 * k], box[2 * k + 1], 3) for k in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = [widest(np.concatenate([node, np.zeros(3)])) >= 0.0 for node in nodes]
    assert found.counted == sum(inside)
    assert 0 < sum(inside) < 27


def test_no_poses_have_no_tensions() -> None:
    robot = shared_winch_robots.pairs()
    assert cw.tension_distribution(robot, np.zeros((0, 6))).tensions.shape == (0, robot.m)
