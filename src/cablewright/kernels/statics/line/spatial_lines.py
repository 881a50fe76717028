"""Solver functions of lines that do not hang in a vertical plane ("spatial lines"), at index *i* of a robot's memory.

*spatial* is `Work.spatial` of a general robot; for others nothing here is compiled, see `Packed`.
"""

from math import acos, cos, exp, hypot, log, nan, sin

from cablewright.kernels import jit
from cablewright.kernels.certificates.exclusion import SETTLED
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    ARRIVAL_X,
    ASIDE,
    AXIS_X,
    AXIS_Y,
    AXIS_Z,
    AZIMUTH,
    BAD_WRAP,
    BREAKING,
    CONTACT,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    DEAD_SPAN,
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    GUIDE,
    NOT_CONVERGED,
    OK,
    OVERSTRETCHED,
    PHI,
    PULLS,
    RADIUS,
    SPANS,
    SWIVEL,
    TAU,
    UNKNOWNS,
    WEIGHT,
)
from cablewright.kernels.statics.line.guides import ARC, CONTACT_POINT, TOWARDS, give_way, leave_frame, towards_winch
from cablewright.kernels.statics.line.sheave import unstrain
from cablewright.kernels.statics.line.spatial import (
    ARM,
    COLUMNS,
    END_FORCE,
    FORCE,
    FRAME,
    POSE,
    RESIDUAL,
    SIZE,
    advance_spatial,
    guess_spatial,
    is_unwound,
    settle_spatial,
    spatial_system,
    straight_length,
    straight_spatial,
    why_not_straight,
)
from cablewright.kernels.statics.line.spatial_wrench import (
    add_spatial,
    add_spatial_pull,
    add_spatial_rate,
    stiffness_along,
)
from cablewright.kernels.statics.line.upright import FAILED, SLACK, SLACK_TENSION, extremes


@jit
def evaluate_placed(row, y, length, pose, i, work, spatial):
    """Evaluate the equations of a spatial line for its *length* (m), see `interface.evaluate_line`."""
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
    """Eliminate a spatial line, evaluated before, from the platform's equations, see `interface.condense_line`."""
    rows = spatial.steps[i]
    if not solve(spatial.blocks[i], rows, SIZE, POSE + work.wrench.shape[0]):
        return False
    add_spatial(row, y, spatial.records[i], rows, row[PULLS], spatial.change, work.wrench, work.stiffness)
    return True


@jit
def condense_moving_placed(row, y, i, rate, work, spatial, pulled, turning):
    """Eliminate a spatial line whose length changes, see `interface.condense_moving_line`."""
    record, rows = spatial.records[i], spatial.steps[i]
    if not solve(spatial.blocks[i], rows, SIZE, COLUMNS):
        return False
    add_spatial(row, y, record, rows, row[PULLS], spatial.change, work.wrench, work.stiffness)
    add_spatial_rate(row, y, record, rows, row[PULLS], rate, pulled, turning)
    return True


@jit
def step_placed(y, i, move, spatial):
    """Take the Newton step of a spatial line, eliminated before, see `interface.advance_line`."""
    steps = spatial.steps[i]
    for k in range(SIZE):
        for j in range(move.shape[0]):
            steps[k, RESIDUAL] -= steps[k, POSE + j] * move[j, 0]
    return advance_spatial(y, steps, RESIDUAL, 1.0)


@jit
def draw_placed(row, y, pose, i, tension, work, spatial):
    """Set *y* to a straight spatial line at a tension (N), see `interface.draw_line`."""
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    found = straight_spatial(row, y, pose, work.arms[i], work.rotation, tension, record, block, rhs)
    return straight_length(row, y) if found else -1.0


@jit
def guess_placed(row, y, pose, i, length, tension, work, spatial):
    """Guess the state *y* of a spatial line from its unstrained length (m), see `interface.guess_line`."""
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    return guess_spatial(row, y, pose, work.arms[i], work.rotation, length, tension, record, block, rhs)


@jit
def settle_placed(row, y, length, pose, i, tension, work, spatial):
    """Solve a spatial line for its length (m) at a fixed pose, from a guess, see `interface.settle_line`."""
    arm, turned = work.arms[i], work.rotation
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    if row[WEIGHT] == 0.0 and row[COUNTERWEIGHT] == 0.0:
        if not straight_spatial(row, y, pose, arm, turned, SLACK_TENSION, record, block, rhs):
            return FAILED
        excess = straight_length(row, y) - length
        if excess <= 0.0:
            return SLACK
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
    evaluated = solved and spatial_system(row, y, pose, arm, turned, length, record, block, rhs)
    return SETTLED if evaluated else FAILED


@jit
def find_placed(row, y, length, pose, i, work, spatial):
    """Solve a spatial line for its length (m) at a fixed pose without a guess, see `interface.find_line`."""
    plane = work.planes[i]
    tension = max(row[WEIGHT], 1.0) * hypot(plane[2], plane[3])
    if not guess_placed(row, y, pose, i, length, tension, work, spatial):
        return why_not_straight(row, y, pose, work.arms[i])
    return NOT_CONVERGED if settle_placed(row, y, length, pose, i, tension, work, spatial) == FAILED else OK


@jit
def judge_placed(row, y, i, spatial):
    """Return the status code of a spatial line, solved before, see `interface.judge_line`."""
    if is_unwound(row, i, spatial):
        return BAD_WRAP
    return OVERSTRETCHED if extremes(row, y)[1] > row[BREAKING] else OK


@jit
def aim_placed(row, y, pose, i, tension, work, spatial):
    """Draw a straight spatial line at *tension* (N); return a code and the unit vector along which it pulls."""
    record, arm = spatial.records[i], work.arms[i]
    if draw_placed(row, y, pose, i, tension, work, spatial) < 0.0:
        return why_not_straight(row, y, pose, arm), 0.0, 0.0, 0.0
    if is_unwound(row, i, spatial):
        return BAD_WRAP, 0.0, 0.0, 0.0
    arm[0], arm[1], arm[2] = record[ARM], record[ARM + 1], record[ARM + 2]
    return OK, -record[FORCE], -record[FORCE + 1], -record[FORCE + 2]


@jit
def stiffen_placed(row, y, i, spatial, chord, arm):
    """Return the stiffness of a spatial line along its chord, N/m, see `interface.stiffen_line`."""
    record = spatial.records[i]
    arm[0], arm[1], arm[2] = record[ARM], record[ARM + 1], record[ARM + 2]
    return row[PULLS] * stiffness_along(row, y, record, spatial.steps[i], chord)


@jit
def shape_placed(row, y, guide, origin, plane):
    """Set *y* to a spatial line, straight between the given points, see `solved_line.shape_line`.

    *origin*: exit point. The *plane* contains the platform point.
    """
    t, c = exp(y[TAU]), cos(y[PHI])
    away = (plane[0] * plane[2], plane[1] * plane[2], plane[3])
    plane[0], plane[1] = cos(y[AZIMUTH]), sin(y[AZIMUTH])
    fx, fy, fz = t * c * plane[0], t * c * plane[1], t * sin(y[PHI])
    leave_frame(row, fx, fy, fz, away, guide, 0)
    give_way(row, fx, fy, fz, 0.0, guide, 0)
    for k in range(3):
        origin[k] += guide[CONTACT_POINT + k]
    straight = y[FREE] * (1.0 + t * row[FREE_COMPLIANCE])
    plane[2], plane[3] = straight * c, straight * sin(y[PHI])  # its end, as long as it is straight


@jit
def turn_placed(row, y, plane, guide):
    """Rotate the state of a spatial line with its guide, see `solved_line.turn_line`."""
    fx, fy, fz, x, along, z = leave_placed(row, y, plane, guide)
    if row[RADIUS] > 0.0:
        return max(guide[ARC], 0.0) / row[RADIUS]
    if row[UNKNOWNS] == 3.0:
        z = -1.0  # a cable whose winch is not described arrives from below
    return acos(min(max(-fx * x - fy * along - fz * z, -1.0), 1.0))


@jit
def leave_placed(row, y, plane, guide):
    """Return the directions in which a spatial line leaves its guides, see `solved_line.directions_of_line`."""
    c, s = cos(y[PHI]), sin(y[PHI])
    ex, ey = c * cos(y[AZIMUTH]), c * sin(y[AZIMUTH])
    leave_frame(row, ex, ey, s, (plane[0] * plane[2], plane[1] * plane[2], plane[3]), guide, 0)
    if row[GUIDE] == ASIDE:
        return ex, ey, s, guide[TOWARDS], guide[TOWARDS + 1], guide[TOWARDS + 2]
    x, across, z = towards_winch(row)
    return ex, ey, s, x, across, z


@jit
def comes_from(row, record):
    """Return the unit vector from a drawn line's guide at the frame to where its cable comes from; 0: not modelled."""
    if row[GUIDE] == ASIDE:
        return record[FRAME + TOWARDS], record[FRAME + TOWARDS + 1], record[FRAME + TOWARDS + 2]
    return towards_winch(row)


@jit
def faces_back(row, record, x, y, z):
    """Return whether the swivel of a drawn line faces (x, y, z) while the cable leaves it to the other side."""
    if row[GUIDE] != SWIVEL:
        return False
    ax, ay, az = row[AXIS_X], row[AXIS_Y], row[AXIS_Z]
    fx, fy, fz = record[FORCE], record[FORCE + 1], record[FORCE + 2]
    return fx * x + fy * y + fz * z < (fx * ax + fy * ay + fz * az) * (x * ax + y * ay + z * az)


@jit
def carry_placed(row, step, scale):
    """Move the winch of a spatial line with its exit point, but not that point, see `solved_line.carry_exit`."""
    if row[GUIDE] == ASIDE:
        for k in range(3):
            row[ARRIVAL_X + k] -= scale * step[k]
    x, across, z = towards_winch(row)
    row[DEAD_SPAN] -= scale * (x * step[0] + across * step[1] + z * step[2])
