"""Position error with the lengths of simpler models: rigid cables, no sag, swivels, eyelets."""

import numpy as np

import cablewright as cw

CASES = {
    "cable=rigid": {"cable": "rigid"},
    "cable=elastic": {"cable": "elastic"},
    "sheave=swivel": {"sheave": "swivel"},
    "sheave=eyelet": {"sheave": "eyelet"},
}
POSES = {
    "house-printer": ([3.7, 2.7, 0.0], [0.0, 0.0, 10.0], [6.0, 6.0, 1.0]),
    "merlet2023": ([0.0, -1.0, 1.0], [1.0, -3.0, 2.5], [2.0, 4.0, 0.5]),
}


def off(robot, pose, home, **simpler):
    lengths = cw.inverse(robot, pose, **simpler).lengths
    offset = cw.inverse(robot, home).lengths - cw.inverse(robot, home, **simpler).lengths
    found = cw.forward(robot, np.array([lengths, lengths + offset]), guess=pose).checked()
    return 1e3 * np.linalg.norm(found.pose - pose, axis=1)


for name, poses in POSES.items():
    for case, simpler in CASES.items():
        sizes = [off(cw.load(name), pose, [0.0, 0.0, 1.0], **simpler) for pose in poses]
        print(f"{name:<13} {case:<14}", "  ".join("{:6.2f} {:6.2f}".format(*size) for size in sizes))
print(f"points instead of sheaves, last pose, homed: {sizes[-1][1]:.2f} mm")
