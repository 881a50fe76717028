"""Jacobian and structure matrix: differences of lengths, virtual work, and balance, on every robot of the library."""

import numpy as np
import pytest

import cablewright as cw
from cablewright.models.rotation import moved
from cablewright.robot import Robot


def pose_in(robot: Robot) -> np.ndarray:
    """A pose near the middle of the frame, in the plane of a robot that has one."""
    middle = 0.5 * (np.array(robot.scene.frame_min) + np.array(robot.scene.frame_max))
    pose = np.concatenate([middle + np.array([0.05, 0.07, -0.03]), [0.05, -0.03, 0.1][: robot.n - 3]])
    plane = robot.platform.plane
    if plane is not None:
        normal = np.array(plane.across)
        pose[:3] -= (pose[:3] @ normal - plane.distance) * normal
    return pose


HELD = [name for name in cw.library_names() if cw.load(name).winches >= cw.load(name).freedoms]


@pytest.mark.parametrize("name", HELD)
def test_the_jacobian_is_the_derivative_of_straight_lengths(name: str) -> None:
    robot, step = cw.load(name), 1e-5
    pose, free = pose_in(robot), cw.Model(robot).free_directions
    free = np.eye(robot.n) if free is None else free
    ends = [[moved(pose, sign * step * way) for way in free.T] for sign in (1.0, -1.0)]
    lengths = [cw.inverse(robot, np.array(each), cable="rigid").lengths for each in ends]
    expected = (lengths[0] - lengths[1]).T / (2.0 * step)
    found = cw.jacobian(robot, pose)
    assert found @ free == pytest.approx(expected, abs=3e-6)  # of a lever, whose angle depends on the tension
    assert found == pytest.approx(found @ free @ free.T, abs=1e-12)  # nothing across a plane


@pytest.mark.parametrize("name", HELD)
def test_virtual_work_relates_both(name: str) -> None:
    robot = cw.load(name)
    poses = np.stack([pose_in(robot)] * 2)
    cables = np.array([line.cables for line in robot.lines])
    A, J = cw.structure_matrix(robot, poses), cw.jacobian(robot, poses)
    assert A.shape == (2, robot.n, robot.m)
    assert -J.transpose(0, 2, 1) * cables == pytest.approx(A, abs=1e-14)


def test_tensions_of_a_distribution_balance_weight_and_wrench() -> None:
    robot, pose = cw.load("jung2020"), [0.2, 0.1, 0.9, 0.0, 0.1, 0.0]
    wrench = np.array([1.0, -2.0, 3.0, 0.1, 0.2, -0.1])
    tensions = cw.tension_distribution(robot, pose, "closed-form", wrench=wrench).tensions
    mass, centre = robot.platform.mass, np.array(robot.platform.centre_of_mass)
    turned = np.array([[np.cos(0.1), 0, np.sin(0.1)], [0, 1, 0], [-np.sin(0.1), 0, np.cos(0.1)]]) @ centre
    weight = np.array([0.0, 0.0, -mass * robot.scene.gravity])
    load = wrench + np.concatenate([weight, np.cross(turned, weight)])
    assert cw.structure_matrix(robot, pose) @ tensions == pytest.approx(-load, abs=1e-9)


def test_a_pose_in_an_exit_point_has_no_directions() -> None:
    robot = cw.load("hangprinter-v4")
    there = robot.exit_points[0] - robot.lines[0].platform_point
    with pytest.raises(cw.AnswerError, match="at an exit point"):
        cw.jacobian(robot, there)
    found = cw.jacobian(robot, [there, [0.0, 0.0, 1.0]])
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1]).all()


@pytest.mark.parametrize(
    ("poses", "text"),
    [
        ([0.0, 0.0], "3 numbers are expected"),
        ([0.0, np.nan, 1.0], "finite"),
        ("here", "numbers in m and rad"),
        (None, "3 numbers are expected"),
        ([["1 m", "2 m", "3 m"]], "numbers in m and rad"),
    ],
)
def test_wrong_poses_are_named_in_one_line(poses: object, text: str) -> None:
    with pytest.raises(cw.InputError, match=text):
        cw.jacobian(cw.load("house-printer"), poses)


def test_cables_with_weight_have_no_jacobian_of_geometry() -> None:
    with pytest.raises(cw.InputError, match="straight lines"):
        cw.jacobian(cw.Model(cw.load("house-printer")), [0.0, 0.0, 1.0])
