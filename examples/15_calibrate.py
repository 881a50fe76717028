"""Self-calibration from encoders: determined and undetermined parameters."""

import numpy as np

import cablewright as cw

robot = cw.load("wang2021")
made = cw.simulate_calibration(robot, poses=40, noise=1e-4, seed=1)
found = cw.calibrate(robot, made.measured)

print(f"lengths fit to {1e3 * found.rms:.3f} mm; {found.alone.rank} of {found.alone.total} unknowns are decided")
print("open:", ", ".join(found.gauge))
for each in found.weakest[:2]:
    print(f"hardly known: {each.words}, sigma {1e3 * each.sigma:.1f} mrad")
best = found.suggestions[0]
print(f"next: {best.words}: {1e3 * best.before:.1f} to {1e3 * best.after:.1f} mm")

truth = np.array([line.exit_point for line in robot.lines])
exits, _ = cw.aligned(found.values[:12].reshape(4, 3), truth)
print(f"exit point error, rms, translation and yaw aligned: {1e3 * np.sqrt(np.mean((exits - truth) ** 2)):.2f} mm")
