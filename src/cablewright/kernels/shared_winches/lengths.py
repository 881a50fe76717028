"""Lengths of lines solved at their pulls, and how they change with the pull and with the pose, for shared winches.

The changes are those of lines whose pulls are held while the platform moves, and of lines at a platform that is held.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import GUIDE, STATE, UNKNOWNS
from cablewright.kernels.statics.line import length_of, system
from cablewright.kernels.statics.spatial import COLUMNS, GIVEN, POSE, SIZE, spatial_system


class LengthWork(NamedTuple):
    """Lengths of all lines and their changes, and scratch for one line."""

    lengths: NDArray[np.float64]  # (m,): unstrained, m
    by_pull: NDArray[np.float64]  # (m,): change per logarithm of the line's pull, m
    by_pose: NDArray[np.float64]  # (m, n): change per motion of the platform, m/m, and m per rad about world axes
    block: NDArray[np.float64]  # (6, 6)
    rhs: NDArray[np.float64]  # (6, 4)
    spatial_block: NDArray[np.float64]  # (4, 4)
    spatial_rhs: NDArray[np.float64]  # (4, 8)


@jit(allocates=True)
def length_workspace(n, m):
    """Scratch for *m* lines of a platform with *n* coordinates."""
    return LengthWork(
        np.zeros(m),
        np.zeros(m),
        np.zeros((m, n)),
        np.zeros((STATE, STATE)),
        np.zeros((STATE, 4)),
        np.zeros((SIZE, SIZE)),
        np.zeros((SIZE, COLUMNS)),
    )


@jit
def measure(packed, pose, states, base, out):
    """Write lengths and changes of all lines, as `underactuated.evaluate_at_pulls` left them in *base*, to *out*."""
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        out.lengths[i] = length_of(row, y)
        if row[GUIDE] > 0.0:
            _measure_placed(row, y, i, pose, base, base.spatial, out)
            continue
        plane, steps, arm = base.planes[i], base.steps[i], base.arms[i]
        system(row, y, plane[2], plane[3], 0.0, out.block, out.rhs[:, 0])
        along, grown, up = 0.0, 0.0, 0.0
        for k in range(int(row[UNKNOWNS])):
            slope = out.block[2, k]  # of the length by an unknown
            along += slope * steps[k, 0]
            grown += slope * steps[k, 1]
            up += slope * steps[k, 2]
        gx, gy = along * plane[0], along * plane[1]
        out.by_pull[i] = grown
        out.by_pose[i, 0], out.by_pose[i, 1], out.by_pose[i, 2] = gx, gy, up
        if pose.shape[0] == 6:
            out.by_pose[i, 3] = arm[1] * up - arm[2] * gy
            out.by_pose[i, 4] = arm[2] * gx - arm[0] * up
            out.by_pose[i, 5] = arm[0] * gy - arm[1] * gx


@jit
def _measure_placed(row, y, i, pose, base, spatial, out):
    """As `measure`, of one line out of the plane; *spatial* is None as in `spatial_lines`."""
    if spatial is None:
        return
    block, rhs, steps = out.spatial_block, out.spatial_rhs, spatial.steps[i]
    spatial_system(row, y, pose, base.arms[i], base.rotation, 0.0, spatial.records[i], block, rhs)
    out.by_pull[i] = 0.0
    for j in range(SIZE):
        out.by_pull[i] += block[3, j] * steps[j, GIVEN]
    for k in range(pose.shape[0]):
        out.by_pose[i, k] = -rhs[3, POSE + k]  # contact with a sheave that turns with the platform
        for j in range(SIZE):
            out.by_pose[i, k] += block[3, j] * steps[j, POSE + k]
