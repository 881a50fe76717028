"""Rank of the structure matrix of Jung 2020, and its stiffness in yaw, with the exit points of Tables 1 and 3."""

import numpy as np

import cablewright as cw


def yaw(stiffness):
    """Stiffness against a rotation about z while the platform is free to move otherwise."""
    return stiffness[5, 5] - stiffness[5, :5] @ np.linalg.solve(stiffness[:5, :5], stiffness[:5, 5])


pose = np.array([0.2, 0.1, 0.9])
for name in ("jung2020-table1", "jung2020"):
    robot = cw.load(name)
    held = cw.inverse(robot, pose).checked()
    arms = np.array([line.platform_point for line in robot.lines])
    away = np.array([line.exit_point for line in robot.lines]) - arms - pose
    lengths = np.linalg.norm(away, axis=1)
    u = away / lengths[:, None]
    structure = np.vstack([u.T, np.cross(arms, u).T])  # its Eq. 3
    elastic = structure @ np.diag(130e3 / lengths) @ structure.T  # its Eq. 9
    everything = cw.linearise(held).stiffness
    print(f"{name}: rank {np.linalg.matrix_rank(structure)}, largest tension {held.tensions.max():.1f} N")
    print(f"  yaw stiffness by its Eq. 9: {abs(yaw(elastic)):.2f} N m/rad, here: {yaw(everything):.2f} N m/rad")
    twisted = cw.inverse(robot.under_wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.5)), pose)
    print(f"  under a yaw moment of 0.5 N m: {twisted.status.word}")
