"""Equilibria in planes and on cables without weight: all minima of the energy that a search of our own finds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import cablewright as cw
import planar_robots
from cablewright.foundation.errors import InputError
from cablewright.models.plane import directions
from cablewright.robot import Eyelet, Robot, load
from cablewright.solvers.line_cover import refuse_unfit

FORCE = (3.0, -2.0, 4.0)


def energy(robot: Robot, lengths: np.ndarray, pose: np.ndarray) -> float:
    """Strain energy of straight lines that carry nothing where they are slack, and the potential of the loads, J."""
    platform = robot.platform
    turn = Rotation.from_rotvec(pose[3:]) if robot.n == 6 else Rotation.identity()
    total = platform.mass * robot.scene.gravity * pose[2] - np.dot(platform.force, pose[:3])
    if robot.n == 6:
        total += platform.mass * robot.scene.gravity * turn.apply(platform.centre_of_mass)[2]
    for line, length in zip(robot.lines, lengths, strict=True):
        chord = float(np.linalg.norm(pose[:3] + turn.apply(line.platform_point) - line.exit_point))
        total += 0.5 * line.cable.stiffness * max(chord - length, 0.0) ** 2 / length
    return float(total)


def minima(robot: Robot, lengths: np.ndarray, starts: np.ndarray) -> list[np.ndarray]:
    """The distinct minima to which descents from *starts* (S, n) lead, in the plane if there is one."""
    free, found = directions(robot.platform.plane, robot.n), []
    for start in starts:
        ended = minimize(
            lambda q, start=start: energy(robot, lengths, start + free @ q) / 100.0,
            np.zeros(free.shape[1]),
            method="BFGS",
            options={"gtol": 1e-7, "maxiter": 400},
        )
        pose = start + free @ ended.x
        slope = np.abs(ended.jac).max()
        if slope < 1e-5 and not any(_near(pose, other) for other in found):
            found.append(pose)
    return found


def _near(one: np.ndarray, other: np.ndarray) -> bool:
    turned = 0.0
    if len(one) == 6:
        turned = (Rotation.from_rotvec(one[3:]) * Rotation.from_rotvec(other[3:]).inv()).magnitude()
    return bool(np.abs(one[:3] - other[:3]).max() < 2e-4 and turned < 2e-3)


def scattered(robot: Robot, count: int) -> np.ndarray:
    """Start poses anywhere in the frame, a body turned, in the plane if there is one."""
    if robot.platform.plane is not None:
        return planar_robots.places(robot, count, 1.0, 3.0, seed=5)
    rng = np.random.default_rng(6)
    places = rng.uniform(robot.scene.frame_min, robot.scene.frame_max, (count, 3))
    return np.hstack([places, rng.uniform(-0.6, 0.6, (count, 3))]) if robot.n == 6 else places


@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("plane", planar_robots.PLANES)
def test_minima_of_the_energy_in_a_plane_are_found(plane: str, body: bool) -> None:
    robot = planar_robots.board(plane, body, force=FORCE)
    held = cw.inverse(robot, planar_robots.places(robot, 1)[0], cable="elastic").checked()
    found = cw.equilibria(robot, held.lengths, cable="elastic", starts=60)
    stable = [each.pose for each in found[found.stable]]
    assert any(_near(held.pose, pose) for pose in stable)
    by_energy = minima(robot, held.lengths, scattered(robot, 12))
    assert by_energy
    for pose in by_energy:
        assert any(_near(pose, other) for other in stable), pose
    assert found.complete_for is None


@pytest.mark.parametrize("body", [False, True])
def test_sagging_lines_in_a_plane_have_what_forward_finds(body: bool) -> None:
    """Several from many starts, each with a balance of forces; one of them is that without a guess."""
    robot = planar_robots.board("tilted", body, force=FORCE)
    held = cw.inverse(robot, planar_robots.places(robot, 1)[0]).checked()
    found = cw.equilibria(robot, held.lengths, starts=60)
    assert any(_near(held.pose, each.pose) for each in found)
    assert max(each.unbalanced_force() for each in found) < 1e-6
    for each in found[found.stable]:
        again = cw.forward(robot, held.lengths, guess=each.pose)
        np.testing.assert_allclose(again.pose, each.pose, atol=1e-7)
        assert abs(robot.platform.plane.height(each.pose[:3])) < 1e-9
    cold = cw.forward(robot, held.lengths).checked()
    assert any(_near(cold.pose, each.pose) for each in found)


def test_cables_without_weight_hold_a_body_in_the_minima_of_the_energy() -> None:
    """Those turned little: of others there are many, and starts find some."""
    robot = load("cogiro")
    lines = tuple(line.model_copy(update={"sheave": Eyelet(), "winch_exit": None}) for line in robot.lines)
    robot = robot.model_copy(update={"lines": lines})
    held = cw.inverse(robot, [1.0, 1.0, 1.5, 0.0, 0.0, 0.0], cable="elastic").checked()
    found = cw.equilibria(robot, held.lengths, cable="elastic", starts=60)
    stable = found[found.stable]
    by_energy = minima(robot, held.lengths, np.vstack([held.pose + 0.05, scattered(robot, 4)]))
    upright = [pose for pose in by_energy if Rotation.from_rotvec(pose[3:]).magnitude() < 1.0]
    assert upright
    for pose in upright:
        assert any(_near(pose, each.pose) for each in stable), pose
    exits = np.array([line.exit_point for line in lines])
    chords = np.linalg.norm(stable.platform_points - exits, axis=-1)
    np.testing.assert_array_equal(found.slack[found.stable], chords <= held.lengths)


def test_what_has_no_shape_cannot_be_searched_exhaustively() -> None:
    model = cw.Model.of(load("merlet2023"), cable="elastic")
    with pytest.raises(InputError, match="cables without weight have no shape where they are slack"):
        refuse_unfit(model, np.full(4, 9.0))
