"""Lengths of lines that are solved at a given pull, and their derivatives, for shared winches.

The derivatives are by the motion of the platform with pulls held, and by the pull with the platform held.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import OK, STATE, robot_of
from cablewright.kernels.statics.inverse import begin
from cablewright.kernels.statics.inverse_scratch import inverse_workspace
from cablewright.kernels.statics.line.interface import length_changes
from cablewright.kernels.statics.line.upright import length_of
from cablewright.kernels.statics.underactuated import evaluate_at_pulls


class LengthWork(NamedTuple):
    """Lengths of all lines and their derivatives by pull and pose."""

    lengths: NDArray[np.float64]  # (m,): unstrained, m
    by_pull: NDArray[np.float64]  # (m,): change per logarithm of the line's pull, m
    by_pose: NDArray[np.float64]  # (m, n): change per motion of the platform, m/m, and m per rad about world axes


@jit(allocates=True)
def length_workspace(n, m):
    """Allocate a `LengthWork` for *m* lines of a platform with *n* coordinates."""
    return LengthWork(np.zeros(m), np.zeros(m), np.zeros((m, n)))


@jit
def measure(packed, pose, states, base, out):
    """Write lengths and changes of all lines, as `underactuated.evaluate_at_pulls` left them in *base*, to *out*."""
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        out.lengths[i] = length_of(row, y)
        out.by_pull[i] = length_changes(row, y, pose, i, base, base.spatial, out.by_pose[i])


@jit(allocates=True)
def lengths_at_pulls(packed, poses, pulls, lengths, slopes):
    """Write lengths (N, m), m, of lines at poses (N, n) under *pulls* (N, m), N, and their slopes, m/N.

    Rows where a line has no solution are left as they are.
    """
    work, states = inverse_workspace(robot_of(packed, 0)), np.zeros((lengths.shape[1], STATE))
    own = length_workspace(packed.freedoms, lengths.shape[1])
    for j in range(poses.shape[0]):
        robot = robot_of(packed, j)
        if begin(robot, poses[j], states, work, False) != OK:
            continue
        copy(pulls[j], work.pulls)
        if evaluate_at_pulls(robot, poses[j], states, work, True):
            measure(robot, poses[j], states, work.base, own)
            copy(own.lengths, lengths[j])
            for i in range(lengths.shape[1]):
                slopes[j, i] = own.by_pull[i] / pulls[j, i]
