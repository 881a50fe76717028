"""A plane that only pushes: tensions that lift the platform hold no place, in any command, and those that press do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

import cablewright as cw
import planar_robots
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot
from cablewright.robot.winch import SharedWinch
from cases import some

BOX = (-0.9, 0.9, -0.9, 0.9, 0.0, 0.0)


def pushing(plane: str, seed: int, body: bool = False) -> Robot:
    """A board of random size, whose lines run off it, and that only pushes."""
    rng = np.random.default_rng(seed)
    push = rng.uniform(0.0, 400.0) * planar_robots.axes(planar_robots.PLANES[plane])[2]
    lines, off = int(rng.integers(4, 6)), float(rng.uniform(0.05, 0.5))
    robot = planar_robots.board(plane, body, lines, off, force=tuple(-push))
    assert robot.platform.plane is not None
    return robot.with_platform(plane=robot.platform.plane.model_copy(update={"one_sided": True}))


def widest(robot: Robot, pose: np.ndarray) -> float:
    """Largest s with tensions from min + s to max - s, and a press of s, by a linear program of all forces."""
    a, b, n = planar_robots.frame(robot)
    ways, moments = [], []
    for line in robot.lines:
        arm = np.array(line.platform_point)
        turn = np.zeros(3) if robot.n == 3 else pose[3:]
        angle = float(turn @ n)
        arm = arm * np.cos(angle) + np.cross(n, arm) * np.sin(angle) + n * (n @ arm) * (1.0 - np.cos(angle))
        way = np.array(line.exit_point) - pose[:3] - arm
        ways.append(way / np.linalg.norm(way))
        moments.append(n @ np.cross(arm, ways[-1]))
    weight = robot.scene.gravity * robot.platform.mass
    U, load = np.array(ways), np.subtract(robot.platform.force, (0.0, 0.0, weight))
    rows, wrench = [U @ a, U @ b], [load @ a, load @ b]
    if robot.n == 6:
        rows, wrench = [*rows, moments], [*wrench, 0.0]
    m, (low, high) = robot.m, robot.lines[0].tension_limits
    one = np.ones((m, 1))
    found = linprog(
        [0.0] * m + [-1.0],
        A_ub=np.vstack([np.hstack([-np.eye(m), one]), np.hstack([np.eye(m), one]), [*(U @ n), 1.0]]),
        b_ub=[-low] * m + [high] * m + [-load @ n],
        A_eq=np.column_stack([np.array(rows), np.zeros(len(rows))]),
        b_eq=-np.array(wrench),
        bounds=(None, None),
    )
    return float(found.x[-1]) if found.status == 0 else -np.inf


@pytest.mark.parametrize("plane", sorted(planar_robots.PLANES))
@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("seed", some(range(6)))
def test_the_widest_tensions_are_those_of_a_program_of_all_forces(plane: str, body: bool, seed: int) -> None:
    robot = pushing(plane, seed, body)
    poses = planar_robots.places(robot, 12, seed=seed)
    found = cw.tension_distribution(robot, poses, "exact")
    wanted = np.array([widest(robot, pose) for pose in poses])
    assert found.margin == pytest.approx(wanted, abs=1e-5)
    np.testing.assert_array_equal(found.feasible[np.abs(wanted) > 1e-5], (wanted >= 0.0)[np.abs(wanted) > 1e-5])
    for method in ("closed-form", "improved-closed-form", "least-norm"):
        other = cw.tension_distribution(robot, poses, method)
        assert (other.margin[other.feasible] <= found.margin[other.feasible] + 1e-6).all()


@pytest.mark.parametrize(("mass", "share"), [(5.0, (0.0, 0.0)), (10.0, (0.02, 0.06)), (60.0, (0.7, 0.9))])
def test_a_workspace_is_where_the_sled_is_pressed(tmp_path: Path, mass: float, share: tuple[float, float]) -> None:
    robot = cw.load(str(planar_robots.sled(tmp_path, mass)))
    exact, static = (cw.workspace_area(robot, each, box=BOX).area / 1.8**2 for each in ("exact", "static"))
    assert share[0] <= exact <= share[1]
    assert exact == pytest.approx(static, abs=0.01)  # by chords, and by the same lines with their weight
    for refused in (cw.capacity, cw.wrench_closure):
        with pytest.raises(InputError, match="it only pushes"):
            refused(robot, [0.0, 0.0, 0.0])
    for criterion in ("capacity", "wrench-closure"):
        with pytest.raises(InputError, match="it only pushes: use exact or static"):
            cw.workspace_area(robot, criterion, box=BOX)


@pytest.mark.parametrize("method", ["exact", "least-norm", "closed-form", "objective"])
def test_tensions_of_shared_drums_are_judged_by_the_press_too(method: str) -> None:
    """Five lines, two of which run from one point to one drum, on a board that a force holds down more and more."""
    n = planar_robots.axes(planar_robots.PLANES["horizontal"])[2]
    hessian = np.eye(5) + 0.1  # not diagonal, so that the objective is searched
    chosen = cw.Quadratic(hessian, hessian @ np.full(5, -200.0)) if method == "objective" else method
    feasible = []
    for push in np.linspace(0.0, 400.0, 9):
        own = planar_robots.board("horizontal", lines=5, off=0.3, force=tuple(-push * n))
        assert own.platform.plane is not None
        shared = {"line": own.lines[0].name, "offset": 0.0, "winds": "along"}
        fifth = own.lines[4].model_copy(
            update={"exit_point": own.lines[0].exit_point, "shared_winch": SharedWinch.model_validate(shared)}
        )
        plane = own.platform.plane.model_copy(update={"one_sided": True})
        robot = own.with_platform(plane=plane).model_copy(update={"lines": (*own.lines[:4], fifth)})
        pose = planar_robots.places(robot, 1)[0]
        found = cw.tension_distribution(robot, pose, chosen, cable="elastic")
        if np.isnan(found.tensions).any():  # a search begins within the limits only
            assert not found.feasible
            feasible.append(False)
            continue
        ways = np.array([np.subtract(line.exit_point, pose) for line in robot.lines])
        lift = ways / np.linalg.norm(ways, axis=1)[:, None] @ n
        press = push + 9.81 * planar_robots.MASS * n[2] - float(lift @ found.tensions)
        low, high = planar_robots.LIMITS
        within = min(float((found.tensions - low).min()), float((high - found.tensions).min()), press)
        assert found.margin == pytest.approx(within, abs=1e-3)
        assert found.feasible == (found.margin >= 0.0)
        feasible.append(bool(found.feasible))
    assert feasible == sorted(feasible)
    assert feasible[-1]
    assert method == "exact" or not feasible[0]
