"""Inertial forces on a platform that does not rotate."""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.rotation import matrix, rotate


@jit(allocates=True)
def push(poses, accelerations, mass, centre, found):
    """Write the inertial wrenches (k, 6), N and N m, of a body that accelerates without rotation to *found*.

    *poses* (k, 6). The wrenches are in the world's axes, about the origin of the body. *accelerations* (k, 3), m/s^2;
    *mass*, kg; *centre* (3,), m, of the mass, platform frame.
    """
    rotation = np.empty((3, 3))
    for j in range(poses.shape[0]):
        matrix(poses[j, 3:], rotation)
        x, y, z = rotate(rotation, centre[0], centre[1], centre[2])
        for k in range(3):
            found[j, k] = -mass * accelerations[j, k]
        fx, fy, fz = found[j, 0], found[j, 1], found[j, 2]
        found[j, 3], found[j, 4], found[j, 5] = y * fz - z * fy, z * fx - x * fz, x * fy - y * fx
