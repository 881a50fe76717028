"""A spatial line in the inverse problem: its first guess, its state at a given pull, its column of the program.

*base* is the scratch of the equilibrium and *spatial* its part for such lines, None as in `spatial_lines`.
"""

from math import cos, exp, log, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    AZIMUTH,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    OK,
    PHI,
    PULLS,
    TAU,
    TENSION_MIN,
    UNDER_EXIT,
    WEIGHT,
)
from cablewright.kernels.statics.line.counterweight import winch_tension, winch_tension_change
from cablewright.kernels.statics.line.guides import SPAN, SPAN_BY_FORCE
from cablewright.kernels.statics.line.sheave import unstrain
from cablewright.kernels.statics.line.spatial import (
    END_FORCE,
    GIVEN,
    POSE,
    SIZE,
    dead_length,
    place_span,
    pull_along,
    settle_spatial_at_pull,
    spatial_system,
    straight_spatial,
    why_not_straight,
)
from cablewright.kernels.statics.line.spatial_lines import draw_placed
from cablewright.kernels.statics.line.spatial_wrench import add_spatial_pull, add_spatial_stiffness, wrench_change
from cablewright.kernels.statics.line.upright import extremes_and_change, is_slack
from cablewright.kernels.statics.line.upright_pull import STRAIGHT


@jit
def begin_placed(row, y, pose, i, known, share, base, spatial):
    """Return code and pull (N) of the first guess of a spatial line, see `interface.begin_line`."""
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    if known and not is_slack(row, y):
        if not place_span(row, y, pose, base.arms[i], base.rotation, record, block):
            return UNDER_EXIT, 0.0
        pull, _ = pull_along(row, y, record)
        return OK, pull
    tension = max(share, row[TENSION_MIN], 1.0) if row[COUNTERWEIGHT] == 0.0 else row[COUNTERWEIGHT]
    if not straight_spatial(row, y, pose, base.arms[i], base.rotation, tension, record, block, rhs):
        return why_not_straight(row, y, pose, base.arms[i]), 0.0
    tension = max(tension, STRAIGHT * row[WEIGHT] * (y[FREE] + y[DEAD]))
    y[TAU] = log(tension)
    unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
    return OK, tension


@jit
def settle_placed_at_pull(row, y, pose, i, pull, base, spatial):
    """Solve a spatial line for its pull (N) at a fixed pose, see `interface.settle_line_at_pull`.

    The solved right-hand sides are left in *spatial*.
    """
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    return settle_spatial_at_pull(row, y, pose, base.arms[i], base.rotation, pull, record, block, rhs)


@jit
def column_placed(row, y, i, pull, spatial, column, load):
    """Write the change of the wrench by the *pull* of a spatial line, solved before, see `interface.column_line`."""
    record, rhs = spatial.records[i], spatial.steps[i]
    wrench_change(row, y, record, rhs, GIVEN, -1, -row[PULLS] / pull, column)
    add_spatial_pull(record, row[PULLS], load)
    for k in range(column.shape[0]):
        load[k] += pull * column[k]


@jit
def extremes_placed(row, y, i, spatial):
    """Return the extreme tensions of a spatial line, N, and their changes, see `interface.extremes_at_pull`.

    A counterweight determines those of its line.
    """
    record, rhs = spatial.records[i], spatial.steps[i]
    c, s, tension = cos(y[PHI]), sin(y[PHI]), exp(y[TAU])
    outward = cos(y[AZIMUTH]) * rhs[0, GIVEN] + sin(y[AZIMUTH]) * rhs[1, GIVEN]
    grow = c * outward + s * rhs[2, GIVEN]
    _, by_tension, per_metre = dead_length(row, record[SPAN], tension)
    longer = by_tension * grow
    for k in range(3):
        longer += per_metre * record[SPAN_BY_FORCE + k] * rhs[k, GIVEN]
    dphi, dfree, ddead = c * rhs[2, GIVEN] - s * outward, rhs[3, GIVEN], longer * tension
    if row[COUNTERWEIGHT] > 0.0:
        held, dheld = winch_tension(row, y), winch_tension_change(row, y, grow, ddead)
        return held, held, dheld, dheld
    return extremes_and_change(row, y, dphi, grow, dfree, ddead, 0.0)


@jit
def add_placed(row, i, spatial, wrench):
    """Add the wrench of a spatial line, solved before, see `interface.add_line_pull`."""
    record, size = spatial.records[i], 0.0
    add_spatial_pull(record, row[PULLS], wrench)
    for k in range(3):
        size = max(size, row[PULLS] * abs(record[END_FORCE + k]))
    return size


@jit
def hang_placed(row, y, pull, pose, i, restart, work, spatial, column):
    """Solve a spatial line that hangs for its pull (N), see `interface.hang_line`."""
    if restart or not settle_placed_at_pull(row, y, pose, i, pull, work, spatial):
        if draw_placed(row, y, pose, i, pull, work, spatial) < 0.0:
            return False
        unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
        if not settle_placed_at_pull(row, y, pose, i, pull, work, spatial):
            return False
    record, steps = spatial.records[i], spatial.steps[i]
    add_spatial_pull(record, row[PULLS], work.wrench)
    add_spatial_stiffness(row, y, record, steps, row[PULLS], column, work.stiffness)
    wrench_change(row, y, record, steps, GIVEN, -1, row[PULLS], column)
    return True


@jit
def measure_placed(row, y, pose, i, work, spatial, by_pose):
    """Return the change of a spatial line's length by its pull, m, see `interface.length_changes`."""
    record, block, rhs, steps = spatial.records[i], spatial.blocks[i], spatial.parameters, spatial.steps[i]
    spatial_system(row, y, pose, work.arms[i], work.rotation, 0.0, record, block, rhs)
    by_pull = 0.0
    for j in range(SIZE):
        by_pull += block[3, j] * steps[j, GIVEN]
    for k in range(pose.shape[0]):
        by_pose[k] = -rhs[3, POSE + k]  # contact with a sheave that turns with the platform
        for j in range(SIZE):
            by_pose[k] += block[3, j] * steps[j, POSE + k]
    return by_pull
