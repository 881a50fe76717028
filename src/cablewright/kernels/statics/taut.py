"""Straight lines to a platform: their angles, lengths and directions."""

from math import cos, nan, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.layout import FREE, PHI, SPANS, STATE
from cablewright.kernels.statics.equilibrium import workspace
from cablewright.kernels.statics.line.interface import place_lines, taut_line
from cablewright.kernels.statics.line.solved_line import end_of_line, hang_in_plane

# Columns of a line's results.
ANGLE, REACH, WHOLE = 0, 1, 2  # rad above the horizontal, m from the sheave, m from the winch
FOUND = 3


@jit(allocates=True)
def draw(packed, pose, found, planes, toward, per_motion):
    """Write the straight lines of *packed* at *pose* (n,), levers as without weight.

    *found* (m, FOUND); *planes* (m, 4) as `vertical_plane.place` has them, along the free span; *toward* (m, 3): the
    derivative of a line's length by the motion of its end: for one span the unit vector away from the sheave.
    *per_motion* (m, n): what a tension of 1 pulls, which is that by the motion of the platform, but for cable that
    comes aslant into a groove: see `docs/machine.md`. NaN for a line without a tangent to its end.
    """
    work, y = workspace(packed), np.zeros(STATE)
    place_lines(packed, pose, work)
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        whole = taut_line(row, y, pose, i, work, work.spatial)
        planes[i, :] = work.planes[i]
        if whole >= 0.0:
            hang_in_plane(row, y, pose, i, work, work.spatial, planes[i])
        else:
            found[i, :], toward[i, :], per_motion[i, :] = nan, nan, nan
            continue
        phi = y[PHI]
        found[i, ANGLE], found[i, REACH], found[i, WHOLE] = phi, y[FREE], whole
        along, up = row[SPANS] * cos(phi), row[SPANS] * sin(phi)
        x, across, z = along * planes[i, 0], along * planes[i, 1], up
        toward[i, 0], toward[i, 1], toward[i, 2] = x, across, z
        per_motion[i, :3] = toward[i]
        if pose.shape[0] == 6:
            ax, ay, az = end_of_line(row, i, work, work.spatial)
            per_motion[i, 3], per_motion[i, 4], per_motion[i, 5] = (
                ay * z - az * across,
                az * x - ax * z,
                ax * across - ay * x,
            )
