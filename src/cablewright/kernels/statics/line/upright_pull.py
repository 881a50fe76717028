"""An upright line whose pull is given instead of its length, as in inverse problems.

Functions of one line in its plane come first, then those of a line at index *i* of a robot's scratch, see
`equilibrium.Work`.
"""

from math import cos, exp, log, sin, sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import largest_of_column, solve
from cablewright.kernels.layout import (
    BETA,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    INSIDE_SHEAVE,
    LEVER,
    MOUNT,
    OK,
    PHI,
    PSI,
    PULLS,
    RADIUS,
    SIDE,
    SPANS,
    TAU,
    TENSION_MIN,
    UNDER_EXIT,
    UNKNOWNS,
    WEIGHT,
)
from cablewright.kernels.statics.line.sheave import straight, unstrain
from cablewright.kernels.statics.line.upright import (
    LENGTH_TOLERANCE,
    STALLED,
    STEPS,
    advance,
    extremes_and_change,
    force_change,
    given_way,
    is_slack,
    start_force,
    system,
)
from cablewright.kernels.statics.line.vertical_plane import (
    NO_PLANE,
    add_line,
    add_pull,
    has_plane,
    is_eyelet,
    is_in_reach_of_lever,
)
from cablewright.kernels.statics.platform import gradient_by_pose

STRAIGHT = 1.5  # of its own weight: tension at which a line is straight enough for a first guess


@jit
def pull_of(row, y, x, z):
    """Return the pull of the free span (N): its force at mid-length along its chord; and the chord's direction.

    A straight line's pull is its tension. Unlike the tension at the sheave, which rises again when a slack span becomes
    heavy, the pull falls monotonically with the length paid out, so that a pull determines the shape.
    """
    h, v = start_force(y)
    turn = row[SIDE] * row[RADIUS]
    gx, gz = given_way(row, y)
    cx = x - gx - row[LEVER] * cos(y[BETA]) + turn * sin(y[PHI])
    cz = z - gz - row[LEVER] * sin(y[BETA]) - turn * cos(y[PHI])
    chord = sqrt(cx * cx + cz * cz)
    cx, cz = cx / chord, cz / chord
    return h * cx + (v + 0.5 * row[WEIGHT] * y[FREE]) * cz, cx, cz


@jit
def settle_at_pull(row, x, z, pull, y, jacobian, rhs):
    """Solve the line at a fixed point for *pull* (N) from *y*; rhs[:, 1] is then dy / dlog(pull). True if converged."""
    unknowns = int(row[UNKNOWNS])
    scale = LENGTH_TOLERANCE * (1.0 + abs(x) + abs(z))
    for _ in range(STEPS):
        system_at_pull(row, x, z, pull, y, jacobian, rhs)
        done = largest_of_column(rhs, unknowns) < scale
        if not solve(jacobian, rhs, unknowns, 2):
            return False
        if done:
            return True
        done = largest_of_column(rhs, unknowns) < STALLED
        advance(row, y, rhs[:, 0], 1.0)
        if done:
            return True
    return False


@jit
def system_at_pull(row, x, z, pull, y, jacobian, rhs):
    """Write the equations of `system` with the pull given instead of the length; rhs[:, 1] is by -log(pull).

    Returns the derivatives of the pull's equation by x and z.
    """
    h, v = system(row, y, x, z, 0.0, jacobian, rhs[:, 0])
    for k in range(int(row[UNKNOWNS])):
        jacobian[2, k] = 0.0
        rhs[k, 1] = 0.0
    turn = row[SIDE] * row[RADIUS]
    hx, hz = row[LEVER] * cos(y[BETA]), row[LEVER] * sin(y[BETA])
    tx, tz = turn * cos(y[PHI]), turn * sin(y[PHI])
    gx, gz = given_way(row, y)
    cx, cz = x - gx - hx + tz, z - gz - hz - tx
    chord = sqrt(cx * cx + cz * cz)
    cx, cz = cx / chord, cz / chord
    middle = v + 0.5 * row[WEIGHT] * y[FREE]
    across = (middle * cx - h * cz) / (chord * pull)  # the chord turns as its ends move
    jacobian[2, PHI] = (h * cz - v * cx) / pull + across * (cx * tz - cz * tx)
    jacobian[2, TAU] = (h * cx + v * cz) / pull
    jacobian[2, FREE] = 0.5 * row[WEIGHT] * cz / pull
    if row[UNKNOWNS] > 5.0:
        jacobian[2, BETA] = -across * (cx * hx + cz * hz)
    if row[MOUNT] > 0.0:
        soft = row[MOUNT] * row[PULLS]
        jacobian[2, PHI] -= across * soft * (cz * v + cx * h)
        jacobian[2, TAU] += across * (cz * gx - cx * gz)
        if row[UNKNOWNS] > 4.0:
            jacobian[2, PSI] = -across * soft * cx * exp(y[TAU]) * cos(y[PSI]) / row[SPANS]
    rhs[2, 0] = (h * cx + middle * cz) / pull - 1.0
    rhs[2, 1] = 1.0
    return -across * cz, across * cx


@jit
def begin_upright(row, y, i, known, share, work):
    """Return code and pull (N) of the first guess of an upright line, see `interface.begin_line`."""
    plane = work.planes[i]
    if not has_plane(row, plane) and (is_eyelet(row) or abs(plane[3]) <= NO_PLANE):
        return UNDER_EXIT, 0.0
    if is_in_reach_of_lever(row, plane):
        return INSIDE_SHEAVE, 0.0
    if known and not is_slack(row, y):
        pull, _, _ = pull_of(row, y, plane[2], plane[3])
        return OK, pull
    tension = max(share, row[TENSION_MIN], 1.0)
    if not straight(row, plane[2], plane[3], tension, y):
        return INSIDE_SHEAVE, 0.0
    tension = max(tension, STRAIGHT * row[WEIGHT] * (y[FREE] + y[DEAD]))
    y[TAU] = log(tension)
    unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
    return OK, tension


@jit
def add_upright(row, y, i, work, wrench):
    """Add the wrench of an upright line, solved before, see `interface.add_line_pull`."""
    h, v = start_force(y)
    v += row[WEIGHT] * y[FREE]
    add_pull(row, work.arms[i], work.planes[i], h, v, wrench)
    return row[PULLS] * max(abs(h), abs(v))


@jit
def column_upright(row, y, i, pull, work, column, load):
    """Write the change of the wrench by the *pull* of an upright line, solved before, see `interface.column_line`."""
    plane = work.planes[i]
    h, v = start_force(y)
    dh, dv = force_change(h, v, row[WEIGHT], work.steps[i], 1)
    dh, dv = dh / pull, dv / pull
    column[:] = 0.0
    add_pull(row, work.arms[i], plane, -dh, -dv, column)
    # the part of the end force that is not proportional to the pull belongs to the load
    h, v = h - dh * pull, v + row[WEIGHT] * y[FREE] - dv * pull
    add_pull(row, work.arms[i], plane, h, v, load)


@jit
def hang_upright(row, y, pull, i, restart, work, column):
    """Solve an upright line that hangs for its pull (N), see `interface.hang_line`."""
    plane, block, steps = work.planes[i], work.blocks[i], work.steps[i]
    x, z = plane[2], plane[3]
    if restart or not settle_at_pull(row, x, z, pull, y, block, steps):
        if not straight(row, x, z, pull, y):
            return False
        unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
        if not settle_at_pull(row, x, z, pull, y, block, steps):
            return False
    by_x, by_z = system_at_pull(row, x, z, pull, y, block, steps)
    for k in range(int(row[UNKNOWNS])):
        steps[k, 0] = 0.0
        steps[k, 2] = 0.0
    steps[0, 0], steps[2, 0] = 1.0, -by_x
    steps[1, 2], steps[2, 2] = 1.0, -by_z
    if not solve(block, steps, int(row[UNKNOWNS]), 3):
        return False
    h, v = start_force(y)
    weight = row[WEIGHT]
    kxx, kzx = force_change(h, v, weight, steps, 0)
    dh, dv = force_change(h, v, weight, steps, 1)
    kxz, kzz = force_change(h, v, weight, steps, 2)
    add_line(row, work.arms[i], plane, h, v + weight * y[FREE], kxx, kxz, kzx, kzz, work.wrench, work.stiffness)
    column[:] = 0.0
    add_pull(row, work.arms[i], plane, dh, dv, column)
    return True


@jit
def measure_upright(row, y, i, work, by_pose):
    """Return the change of an upright line's length by its pull, m, see `interface.length_changes`."""
    plane, steps, arm, block = work.planes[i], work.steps[i], work.arms[i], work.blocks[i]
    system(row, y, plane[2], plane[3], 0.0, block, steps[:, 3])
    along, grown, up = 0.0, 0.0, 0.0
    for k in range(int(row[UNKNOWNS])):
        slope = block[2, k]  # of the length by an unknown
        along += slope * steps[k, 0]
        grown += slope * steps[k, 1]
        up += slope * steps[k, 2]
    gradient_by_pose(arm, along * plane[0], along * plane[1], up, by_pose)
    return grown


@jit
def extremes_upright(row, y, steps):
    """Return the extreme tensions of an upright line, N, and their changes, see `interface.extremes_at_pull`.

    *steps* (6, 4): of the solve at its pull.
    """
    return extremes_and_change(row, y, steps[PHI, 1], steps[TAU, 1], steps[FREE, 1], steps[DEAD, 1], steps[PSI, 1])
