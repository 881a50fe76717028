"""Oracle: tension distribution of straight lines by numpy and HiGHS, from a robot's description."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from cablewright.robot import Robot
from oracles import tangent


def structure(robot: Robot, pose: np.ndarray, tension: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return A (n, m) and w (n,) of A t + w = 0: lines as `tangent.straight` has them at that tension, N."""
    platform, n = robot.platform, robot.n
    R = Rotation.from_rotvec(pose[3:]).as_matrix() if n == 6 else np.eye(3)
    columns = []
    for line in robot.lines:
        arm = R @ line.platform_point
        point = pose[:3] + arm
        phi = tangent.straight(line, point, tension).phi
        out = (point - line.exit_point)[:2] / np.linalg.norm((point - line.exit_point)[:2])
        u = -np.array([*(np.cos(phi) * out), np.sin(phi)])
        columns.append([*u, *np.cross(arm, u)][:n])
    weight = np.array([0.0, 0.0, -platform.mass * robot.scene.gravity])
    w = np.concatenate([weight + platform.force, np.zeros(3)])
    if n == 6:
        w[3:] = np.cross(R @ platform.centre_of_mass, weight) + platform.moment
    return np.array(columns).T, w[:n]


def margin(A: np.ndarray, w: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """Return the largest s for which tensions from low + s to high - s balance; -inf where none of any size do."""
    n, m = A.shape
    eye, one = np.eye(m), np.ones((m, 1))
    found = linprog(
        np.r_[np.zeros(m), -1.0],
        A_ub=np.block([[-eye, one], [eye, one]]),
        b_ub=np.r_[-low, high],
        A_eq=np.c_[A, np.zeros(n)],
        b_eq=-w,
        bounds=(None, None),
        method="highs",
    )
    assert found.status in (0, 2), found.message
    return float(found.x[-1]) if found.status == 0 else -np.inf


def support(A: np.ndarray, low: np.ndarray, high: np.ndarray, c: np.ndarray) -> float:
    """Return how far the wrenches -A t of tensions within limits reach along c (n,)."""
    pulls = -(c @ A)
    return float(np.maximum(pulls * low, pulls * high).sum())


def reach(A: np.ndarray, low: np.ndarray, high: np.ndarray, start: np.ndarray, along: np.ndarray) -> float:
    """Return how far one can go from the wrench *start* along *along* within the wrenches -A t; -inf if not at all."""
    m = A.shape[1]
    found = linprog(
        np.r_[np.zeros(m), -1.0],
        A_eq=np.c_[A, along],
        b_eq=-start,
        bounds=[*zip(low, high, strict=True), (0.0, None)],
        method="highs",
    )
    return float(found.x[-1]) if found.status == 0 else -np.inf
