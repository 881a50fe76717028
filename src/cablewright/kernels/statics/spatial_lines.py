"""Lines out of the plane in the solves of a whole robot, each at index *i* of the robot's scratch.

*spatial* is `Work.spatial`: None for a robot that is not general, for which nothing here is compiled, see `Packed`.
"""

from math import log, nan

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    CONTACT,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    PULLS,
    SPANS,
    TAU,
    WEIGHT,
)
from cablewright.kernels.newton import solve
from cablewright.kernels.statics.line import SLACK_TENSION
from cablewright.kernels.statics.sheave import unstrain
from cablewright.kernels.statics.spatial import (
    ARM,
    END_FORCE,
    POSE,
    RESIDUAL,
    SIZE,
    advance_spatial,
    guess_spatial,
    settle_spatial,
    spatial_system,
    straight_length,
    straight_spatial,
)
from cablewright.kernels.statics.spatial_wrench import add_spatial, add_spatial_pull, stiffness_along


@jit
def evaluate_placed(row, y, length, pose, i, work, spatial):
    """As `equilibrium.evaluate`, of one line. Returns its largest residual, m, NaN without a solution, and force, N."""
    if spatial is None:
        return nan, 0.0
    record, rhs = spatial.records[i], spatial.steps[i]
    if not spatial_system(row, y, pose, work.arms[i], work.rotation, length, record, spatial.blocks[i], rhs):
        return nan, 0.0
    add_spatial_pull(record, row[PULLS], work.trial)
    worst, force = 0.0, 0.0
    for k in range(SIZE):
        size = abs(rhs[k, RESIDUAL])
        if size > worst or size != size:
            worst = size
    for k in range(3):
        force = max(force, row[PULLS] * abs(record[END_FORCE + k]))
    return worst, force


@jit
def condense_placed(row, y, i, work, spatial):
    """As `equilibrium.condense`, of one evaluated line. False if its block is singular."""
    if spatial is None:
        return False
    rows = spatial.steps[i]
    if not solve(spatial.blocks[i], rows, SIZE, POSE + work.wrench.shape[0]):
        return False
    add_spatial(row, y, spatial.records[i], rows, row[PULLS], spatial.change, work.wrench, work.stiffness)
    return True


@jit
def step_placed(y, i, move, spatial):
    """As `equilibrium.step_line`, of an eliminated line."""
    if spatial is None:
        return False
    steps = spatial.steps[i]
    for k in range(SIZE):
        for j in range(move.shape[0]):
            steps[k, RESIDUAL] -= steps[k, POSE + j] * move[j, 0]
    return advance_spatial(y, steps, RESIDUAL, 1.0)


@jit
def draw_placed(row, y, pose, i, tension, work, spatial):
    """As `equilibrium.draw_straight`, of one line."""
    if spatial is None:
        return -1.0
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    found = straight_spatial(row, y, pose, work.arms[i], work.rotation, tension, record, block, rhs)
    return straight_length(row, y) if found else -1.0


@jit
def guess_placed(row, y, pose, i, length, tension, work, spatial):
    """As `line.guess`, of one line."""
    if spatial is None:
        return False
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    return guess_spatial(row, y, pose, work.arms[i], work.rotation, length, tension, record, block, rhs)


@jit
def add_settled(row, length, pose, y, i, tension, work, spatial):
    """Solve a line at a fixed pose, if need be from a guess at *tension*, and add it. False if it is not solved.

    A slack massless one adds nothing.
    """
    if spatial is None:
        return False
    arm, turned = work.arms[i], work.rotation
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    if row[WEIGHT] == 0.0 and row[COUNTERWEIGHT] == 0.0:
        if not straight_spatial(row, y, pose, arm, turned, SLACK_TENSION, record, block, rhs):
            return False
        excess = straight_length(row, y) - length
        if excess <= 0.0:
            return True
        compliance = row[SPANS] * y[FREE] * row[FREE_COMPLIANCE] + y[DEAD] * row[DEAD_COMPLIANCE]
        compliance += y[CONTACT] * row[ARC_COMPLIANCE] + row[END_SPRING]
        y[TAU] = log(excess / compliance)
        unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
        solved = settle_spatial(row, y, pose, arm, turned, length, record, block, rhs)
    else:
        solved = settle_spatial(row, y, pose, arm, turned, length, record, block, rhs) or (
            guess_spatial(row, y, pose, arm, turned, length, tension, record, block, rhs)
            and settle_spatial(row, y, pose, arm, turned, length, record, block, rhs)
        )
    if not (solved and spatial_system(row, y, pose, arm, turned, length, record, block, rhs)):
        return False
    return condense_placed(row, y, i, work, spatial)


@jit
def write_stiffness(row, y, i, chord, arm, spatial):
    """Write the *chord* (3,) of an eliminated line and the *arm* (3,) of its end; returns its stiffness along it."""
    if spatial is None:
        return nan
    record = spatial.records[i]
    arm[0], arm[1], arm[2] = record[ARM], record[ARM + 1], record[ARM + 2]
    return row[PULLS] * stiffness_along(row, y, record, spatial.steps[i], chord)
