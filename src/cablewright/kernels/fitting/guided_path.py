"""A straight line over guides that `line_over_sheave` does not cover, for calibration: its length, its wrench, changes.

These are pulleys in a fixed plane, swivels whose winch is aside of their axis, and sheaves on the platform. The path is
that of `statics.line.spatial` for a rigid cable without weight. A groove that a cable enters obliquely carries a part
of its force, so that the change of the length is not the unit wrench: both are differentiated.
"""

from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, solve
from cablewright.kernels.fitting import line_over_sheave as own
from cablewright.kernels.layout import COLUMNS as PACKED_COLUMNS
from cablewright.kernels.layout import CONTACT, DEAD, DEAD_SPAN, EXIT_X, FREE, POINT_X, RADIUS, SPANS, STATE
from cablewright.kernels.rotation import rotate
from cablewright.kernels.statics.line.guides import ARC_BY_FORCE, SPAN_BY_FORCE
from cablewright.kernels.statics.line.spatial import (
    ARM,
    COLUMNS,
    END_FORCE,
    FORCE,
    FRAME,
    GIVEN,
    PLATFORM,
    POSE,
    RECORD,
    SIZE,
    spatial_at_pull,
    straight_spatial,
    turn_of,
)
from cablewright.kernels.statics.line.spatial_lines import comes_from
from cablewright.kernels.statics.line.spatial_parameter_derivatives import write_radius
from cablewright.kernels.statics.line.spatial_wrench import wrench_change

MOTIONS = 7  # of a line: those of the pose, and the sheave's radius, whose index is
BY_RADIUS = 6


class GuidedPath(NamedTuple):
    """Working memory of guided lines. Derivatives are by the motions of the pose, and by the radius of the sheave."""

    lines: NDArray[np.float64]  # (m, PACKED_COLUMNS): of guided lines, unknowns included
    state: NDArray[np.float64]  # (STATE,)
    arm: NDArray[np.float64]  # (3,): to the platform point, world, m
    record: NDArray[np.float64]  # (RECORD,)
    block: NDArray[np.float64]  # (4, 4)
    right: NDArray[np.float64]  # (4, COLUMNS)
    length: NDArray[np.float64]  # (MOTIONS,): derivatives of the length
    wrench: NDArray[np.float64]  # (MOTIONS, 6): derivatives of the wrench of a unit tension
    along: NDArray[np.float64]  # (MOTIONS,): derivatives of a part of that wrench


@jit(allocates=True)
def guided_path(m):
    """Allocate a `GuidedPath` for *m* lines."""
    return GuidedPath(
        np.zeros((m, PACKED_COLUMNS)),
        np.zeros(STATE),
        np.zeros(3),
        np.zeros(RECORD),
        np.zeros((SIZE, SIZE)),
        np.zeros((SIZE, COLUMNS)),
        np.zeros(MOTIONS),
        np.zeros((MOTIONS, 6)),
        np.zeros(MOTIONS),
    )


@jit
def place_guided(guided, lines, path):
    """Write the *guided* lines (m, PACKED_COLUMNS), None without any, with the numbers of *lines* (m, own.COLUMNS)."""
    if guided is not None:
        for i in range(lines.shape[0]):
            row = path.lines[i]
            copy(guided[i], row)
            for k in range(3):
                row[EXIT_X + k], row[POINT_X + k] = lines[i, own.EXIT + k], lines[i, own.POINT + k]
            row[RADIUS] = lines[i, own.RADIUS]


@jit
def draw_guided(line, path, i, pose, rotation, free):
    """Write length and direction of the straight cable of line *i* to *free*, as `line_over_sheave.over_sheave`.

    Returns the arm from the platform's origin to where the cable reaches the platform, world, m. The length is that
    beyond the exit point; of a winch aside from where the cable comes from on. All are NaN where no cable runs.
    """
    row, y, record = path.lines[i], path.state, path.record
    x, along, z = rotate(rotation, row[POINT_X], row[POINT_X + 1], row[POINT_X + 2])
    path.arm[0], path.arm[1], path.arm[2] = x, along, z
    if straight_spatial(row, y, pose, path.arm, rotation, 1.0, record, path.block, path.right):
        free[0] = row[SPANS] * y[FREE] + y[DEAD] - row[DEAD_SPAN] + y[CONTACT]
        free[1], free[2], free[3] = record[FORCE], record[FORCE + 1], record[FORCE + 2]
    else:
        free[0], free[1], free[2], free[3] = nan, nan, nan, nan
    line[own.FROM], line[own.FROM + 1], line[own.FROM + 2] = comes_from(row, record)
    return record[ARM], record[ARM + 1], record[ARM + 2]


@jit
def change_guided(path, i, pose, rotation):
    """Write the derivatives of length and wrench of the line *i* that was drawn last."""
    row, y, record, block, right = path.lines[i], path.state, path.record, path.block, path.right
    n = pose.shape[0]
    spatial_at_pull(row, y, pose, path.arm, rotation, 1.0, record, block, right)
    on_sheave, before = write_radius(row, record, right, GIVEN)
    solve(block, right, SIZE, COLUMNS)
    for k in range(MOTIONS):
        column = POSE + k if k < BY_RADIUS else GIVEN
        sign = 1.0 if k < BY_RADIUS else -1.0
        found = right[3, column] * row[SPANS]
        for j in range(3):
            arcs = record[FRAME + ARC_BY_FORCE + j] + record[PLATFORM + ARC_BY_FORCE + j]
            found += (arcs + record[FRAME + SPAN_BY_FORCE + j]) * right[j, column]
        path.length[k] = sign * found
        path.wrench[k, :] = 0.0
        if k < n or k == BY_RADIUS:
            axis = k - 3 if k < BY_RADIUS else -1
            wrench_change(row, y, record, right, column, axis, sign, path.wrench[k, :n])
        else:
            path.length[k] = 0.0
    path.length[BY_RADIUS] += on_sheave + before
    for k in range(n - 3):
        turned = turn_of(k, record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2])
        for j in range(3):
            path.length[3 + k] -= record[PLATFORM + ARC_BY_FORCE + j] * turned[j]


@jit
def wrench_along(path, fx, fy, fz, mx, my, mz):
    """Write the derivatives of the unit wrench along a force (fx, fy, fz) and a moment (mx, my, mz) to `along`."""
    for k in range(MOTIONS):
        change = path.wrench[k]
        path.along[k] = fx * change[0] + fy * change[1] + fz * change[2]
        path.along[k] += mx * change[3] + my * change[4] + mz * change[5]
