"""Oracle: stiffness of straight elastic lines through eyelets, by complex steps of the wrench on the platform.

A step of 1e-30 i leaves no rounding of differences: derivatives are exact to the last digits. Nothing is shared
with the package but the description.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from cablewright.robot import Line, Robot

STEP = 1e-30


def parts(robot: Robot, lengths: Sequence[float], pose: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the elastic and the geometric stiffness (n, n): tensions change and nothing turns, and the reverse.

    Motions are those of the platform's origin and rotations in space; ``lengths`` (m,) are unstrained.
    """
    still = np.zeros(robot.n)

    def pulled(motion: np.ndarray) -> np.ndarray:
        return wrench(robot, pose, tensions(robot, lengths, pose, motion), still)

    def turned(motion: np.ndarray) -> np.ndarray:
        return wrench(robot, pose, tensions(robot, lengths, pose, still), motion)

    return derivative(pulled, robot.n), derivative(turned, robot.n)


def whole(
    robot: Robot, lengths: Sequence[float], pose: Sequence[float], about: Sequence[float] = (0, 0, 0)
) -> np.ndarray:
    """Return the tangent stiffness (n, n) for motions of a point of the platform, ``about``, world, from its origin."""

    def moved(motion: np.ndarray) -> np.ndarray:
        at_origin = motion.copy()
        if robot.n == 6:
            at_origin[:3] -= np.cross(motion[3:], about)
        there = wrench(robot, pose, tensions(robot, lengths, pose, at_origin), at_origin)
        if robot.n == 6:
            there[3:] -= np.cross(about + np.cross(motion[3:], about), there[:3])
        return there

    return derivative(moved, robot.n)


def derivative(function: Callable[[np.ndarray], np.ndarray], n: int) -> np.ndarray:
    """Return minus the derivative (n, n) of a wrench (n,) by a motion (n,)."""
    return np.array([-function(STEP * 1j * unit).imag / STEP for unit in np.eye(n)]).T


def tensions(robot: Robot, lengths: Sequence[float], pose: Sequence[float], motion: np.ndarray) -> list[complex]:
    """Return the tension of each line after a motion (n,): 0 where it is slack."""
    found = []
    for line, length, arm in zip(robot.lines, lengths, arms(robot, pose, motion), strict=True):
        away = np.array(line.exit_point) - (np.array(pose[:3]) + motion[:3] + arm)
        free = np.sqrt(away @ away)
        taut, unstrained = stretching(line, free, float(length))
        tension = line.cable.stiffness * (taut / unstrained - 1)
        found.append(tension if tension.real > 0 else 0j)
    return found


def stretching(line: Line, free: complex, length: float) -> tuple[complex, float]:
    """Return the strained and the unstrained length of the stretching part, m."""
    if line.winch_exit is None:
        return free, length - line.dead_length
    dead = math.dist(line.winch_exit, line.exit_point)
    return (free + dead, length) if line.dead_elastic else (free, length - dead)


def arms(robot: Robot, pose: Sequence[float], motion: np.ndarray) -> list[np.ndarray]:
    """Return where each platform point is from the platform's origin after a motion (n,), world, m."""
    return [_turned(line.platform_point, pose, motion) for line in robot.lines]


def wrench(robot: Robot, pose: Sequence[float], pulls: Sequence[complex], motion: np.ndarray) -> np.ndarray:
    """Return force and moment (n,) about the platform's origin after a motion (n,), the lines under tensions (m,)."""
    platform = robot.platform
    weight = np.array([0, 0, -platform.mass * robot.scene.gravity])
    forces, points = [weight], [np.zeros(3)]
    if robot.n == 6:
        points = [_turned(platform.centre_of_mass, pose, motion)]
    for line, pull, arm in zip(robot.lines, pulls, arms(robot, pose, motion), strict=True):
        away = np.array(line.exit_point) - (np.array(pose[:3]) + motion[:3] + arm)
        forces.append(pull * away / np.sqrt(away @ away))
        points.append(arm)
    force = np.sum(forces, axis=0) + platform.force
    if robot.n == 3:
        return force
    return np.concatenate([force, np.sum(np.cross(points, forces), axis=0) + platform.moment])


def _turned(point: Sequence[float], pose: Sequence[float], motion: np.ndarray) -> np.ndarray:
    """Return a platform point from the origin, world; to first order in the motion, which is all a step needs."""
    if len(pose) == 3:
        return np.array(point)
    arm = Rotation.from_rotvec(pose[3:]).as_matrix() @ np.array(point)
    return arm + np.cross(motion[3:], arm)
