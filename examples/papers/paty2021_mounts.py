"""Brackets as compliant mounts: the motion of the platform by the statics, and by the bracket."""

import numpy as np

import cablewright as cw

robot, pose = cw.load("house-printer"), [-2.25, -6.75, 13.0]
design = cw.bracket(robot, pose, times=1).designs.universal_joint
force, moved = design.loads.sheave_force[0], design.sheave_motions
gives = (force * moved).sum(axis=1) / (force**2).sum(axis=1)  # m/N
lines = [line.model_dump() | {"exit_compliance": soft} for line, soft in zip(robot.lines, gives.tolist(), strict=True)]
soft = cw.Robot.model_validate(robot.model_dump() | {"lines": lines})
stiff = cw.inverse(robot, pose)
there = cw.forward(soft, stiff.lengths, guess=stiff.pose)
print(f"mounts {1e6 * gives.min():.3f} to {1e6 * gives.max():.3f} um/N")
print(f"by the statics {1e3 * np.linalg.norm(there.pose - stiff.pose):.2f} mm")
print(f"by the bracket: {1e3 * np.linalg.norm(design.platform_motion):.2f} mm")
