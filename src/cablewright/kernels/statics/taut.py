"""Straight cables from their exit points to the platform: angles, lengths, directions and compliance."""

from math import cos, nan, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    MOUNT,
    PHI,
    PULLS,
    SPANS,
    STATE,
)
from cablewright.kernels.statics.equilibrium import workspace
from cablewright.kernels.statics.line.guides import pull_of_dead_span
from cablewright.kernels.statics.line.interface import place_lines, taut_line
from cablewright.kernels.statics.line.solved_line import end_of_line, hang_in_plane

# Columns of a line's results.
ANGLE, REACH, WHOLE = 0, 1, 2  # rad above the horizontal, m from the sheave, m from the winch
FOUND = 3

# Columns of a line's softness, m/N.
STRETCH, GIVEN, SHARE = 0, 1, 2  # by cable, spring and mount; by the mount; by a mount of the compliance 1
SOFTNESS = 3


@jit(allocates=True)
def draw(packed, pose, found, planes, toward, per_motion):
    """Write angles, lengths and directions of the straight lines of *packed* at *pose* (n,), with weightless levers.

    *found* (m, FOUND); *planes* (m, 4) as `vertical_plane.place` has them, along the free span; *toward* (m, 3): the
    derivative of a line's length by the motion of its end: for one span the unit vector away from the sheave.
    *per_motion* (m, n): the wrench of a unit tension, which is the derivative of the length by the motion of the
    platform, except for cable that enters a groove obliquely: see `docs/machine.md`. NaN for a line without a tangent
    to its end.
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


@jit
def soften(lines, lengths, toward, softness):
    """Write the compliances *softness* (m, SOFTNESS), m/N, of straight *lines* (m, COLUMNS): cable, spring and mount.

    *lengths* (m,), m, from the winch, and *toward* (m, 3): as `draw` writes them. The mount of an exit point is pulled
    along the free span and, where it is modelled, along the dead span, by all cables of the line.
    """
    for i in range(lines.shape[0]):
        row = lines[i]
        x, y, z = pull_of_dead_span(row)
        x, y, z = toward[i, 0] + x, toward[i, 1] + y, toward[i, 2] + z
        mount = row[MOUNT : MOUNT + 6]
        soft = mount[0] * x * x + mount[1] * y * y + mount[2] * z * z
        soft += 2.0 * mount[3] * x * y + 2.0 * mount[4] * x * z + 2.0 * mount[5] * y * z
        pulled = row[PULLS] / row[SPANS]
        softness[i, GIVEN] = pulled * soft
        softness[i, SHARE] = pulled * (x * x + y * y + z * z)
        softness[i, STRETCH] = row[FREE_COMPLIANCE] * lengths[i] + row[END_SPRING] + softness[i, GIVEN]
