"""The coordinates that equilibrium decides on a robot with fewer winches than degrees of freedom."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.robot import Robot


def free_coordinates(robot: Robot) -> list[int]:
    """Return the coordinates of a pose that are left free (NaN) along a path; none where winches hold all.

    Rotations first, from that about x on, then the horizontal coordinate farther across the exit points, and the other.
    In a plane the rotation about its normal, then coordinates in it, horizontal ones first.
    """
    missing = robot.freedoms - robot.winches
    if missing <= 0:
        return []
    if (plane := robot.platform.plane) is not None:
        axis = int(np.argmax(np.abs(plane.across)))
        return [*([3 + axis] if robot.n == 6 else []), *(k for k in range(3) if k != axis)][:missing]
    exits = np.array([line.exit_point[:2] for line in robot.lines])
    apart = np.abs([b - a for a, b in combinations(exits, 2)] or [[0.0, 0.0]]).sum(axis=0)
    across = int(np.argmin(apart))
    rotations = [3, 4, 5] if robot.n == 6 else []
    return [*rotations, across, 1 - across][:missing]


def with_free(robot: Robot, poses: Array) -> Array:
    """Return *poses* (..., n) with NaN for coordinates that equilibrium decides; unchanged where winches hold all."""
    free = free_coordinates(robot)
    if not free:
        return poses
    left = poses.copy()
    left[..., free] = np.nan
    return left


def as_held(robot: Robot, poses: Array) -> Array:
    """Return *poses* (N, n) with NaN for coordinates that winches do not hold, and of a body on shared ones rotations.

    Lines on one drum fit it at the rotation that equilibrium decides.
    """
    if not robot.sharing or robot.platform.plane is not None:
        return with_free(robot, poses)
    held = poses.copy()
    held[:, decided_by_weight(robot)] = np.nan
    return held


def decided_by_weight(robot: Robot) -> list[int]:
    """Return indices of pose coordinates that gravity decides at rest, rotations first; none if winches hold all."""
    missing = robot.freedoms - robot.winches
    if robot.sharing and 0 < missing < 3 < robot.n:  # parallel lines hold a body's rotation together
        missing = 3
    if robot.platform.plane is not None or missing <= 0:
        return []
    return [3, 4, 5, 1, 0][6 - robot.n :][:missing]  # rotations first, of a body
