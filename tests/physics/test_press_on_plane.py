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
    for criterion in ("capacity", "wrench-closure"):
        with pytest.raises(InputError, match="it only pushes: use exact or static"):
            cw.workspace_area(robot, criterion, box=BOX)
