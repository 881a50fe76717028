"""Solver functions of upright lines (in a vertical plane), each at index *i* of a robot's memory `equilibrium.Work`."""

from math import cos, exp, hypot, isnan, nan, pi, sin

from cablewright.kernels import jit
from cablewright.kernels.certificates.exclusion import SETTLED
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    BAD_WRAP,
    BETA,
    BREAKING,
    DEAD,
    DEAD_COMPLIANCE,
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    INSIDE_SHEAVE,
    LEVER,
    LEVER_MOMENT,
    LEVER_UNSTABLE,
    NOT_CONVERGED,
    OK,
    OVERSTRETCHED,
    PHI,
    PSI,
    PULLS,
    RADIUS,
    SIDE,
    SPANS,
    STATE,
    TAU,
    UNDER_EXIT,
    UNKNOWNS,
    UNSTABLE,
    WEIGHT,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.statics.line.sheave import straight, unstrain, whole_length, wrap
from cablewright.kernels.statics.line.upright import (
    FAILED,
    SLACK,
    SLACK_TENSION,
    advance,
    extremes,
    force_change,
    given_way,
    guess,
    lever_stable,
    settle,
    system,
)
from cablewright.kernels.statics.line.upright_pull import pull_of
from cablewright.kernels.statics.line.vertical_plane import (
    add_line,
    add_pull,
    has_plane,
    is_eyelet,
    is_in_reach_of_lever,
)
from cablewright.kernels.statics.platform import add_force, add_turning

TAUT = 1e9  # N; tension at which a lever's weight is negligible
LEVER_PULLS = (1.0, 10.0, 100.0, 1000.0)  # tensions, times the weight of the straight line, at which levers are placed
BACKWARDS = -1e-9  # cosine of a span's direction, below which it leaves its sheave backwards and not straight down


@jit
def evaluate_upright(row, y, length, i, work):
    """Evaluate the equations of an upright line for its *length* (m), see `interface.evaluate_line`."""
    plane, steps, worst = work.planes[i], work.steps[i], 0.0
    h, v = system(row, y, plane[2], plane[3], length, work.blocks[i], steps[:, 0])
    work.forces[i, 0], work.forces[i, 1] = h, v
    v += row[WEIGHT] * y[FREE]
    for k in range(int(row[UNKNOWNS])):
        size = abs(steps[k, 0])
        if k == BETA:
            size *= row[LEVER] / max(1.0, row[LEVER_MOMENT] / (row[LEVER] * exp(y[TAU])))  # about its end's error
        if size > worst or size != size:  # keeps a NaN
            worst = size
    add_pull(row, work.arms[i], plane, h, v, work.trial)
    return worst, row[PULLS] * max(abs(h), abs(v))


@jit
def condense_upright(row, y, i, work):
    """Eliminate an upright line, evaluated before, from the platform's equations, see `interface.condense_line`."""
    if not eliminate(row, work.blocks[i], work.steps[i], 3):
        return False
    add_eliminated(row, y, work.forces[i], work.steps[i], work.arms[i], work.planes[i], work.wrench, work.stiffness)
    return True


@jit
def condense_moving_upright(row, y, i, rate, work, pulled, turning):
    """Eliminate an upright line whose length changes, see `interface.condense_moving_line`."""
    steps, plane, arm = work.steps[i], work.planes[i], work.arms[i]
    if not eliminate(row, work.blocks[i], steps, 4):
        return False
    add_eliminated(row, y, work.forces[i], steps, arm, plane, work.wrench, work.stiffness)
    h, v = work.forces[i, 0], work.forces[i, 1]
    dh, dv = force_change(h, v, row[WEIGHT], steps, 3)
    rate = rate * row[PULLS]
    add_force(arm, -rate * dh * plane[0], -rate * dh * plane[1], -rate * dv, pulled)
    dh, dv = force_change(h, v, row[WEIGHT], steps, 0)
    h, v = row[PULLS] * (h - dh), row[PULLS] * (v - dv + row[WEIGHT] * y[FREE])
    add_turning(turning, 0, arm[0], arm[1], arm[2], -h * plane[0], -h * plane[1], -v)
    return True


@jit
def eliminate(row, block, steps, columns):
    """Solve a line's Newton block for four right-hand sides: residual (column 0), x, z, length. False if singular."""
    unknowns = int(row[UNKNOWNS])
    for column in range(1, columns):
        for k in range(unknowns):
            steps[k, column] = 0.0
        steps[column - 1, column] = 1.0
    return solve(block, steps, unknowns, columns)


@jit
def add_eliminated(row, y, force, steps, arm, plane, wrench, stiffness):
    """Add one eliminated line to the platform's balance and stiffness: its force after its own step, and its change."""
    weight = row[WEIGHT]
    h, v = force[0], force[1]
    dh, dv = force_change(h, v, weight, steps, 0)
    kxx, kzx = force_change(h, v, weight, steps, 1)
    kxz, kzz = force_change(h, v, weight, steps, 2)
    v += weight * y[FREE]
    add_line(row, arm, plane, h - dh, v - dv, kxx, kxz, kzx, kzz, wrench, stiffness)


@jit
def step_upright(row, y, steps, arm, plane, move):
    """Take the Newton step of an upright line, eliminated before, see `interface.advance_line`."""
    dx, dy, dz = move[0, 0], move[1, 0], move[2, 0]
    if move.shape[0] == 6:
        a, b, c = move[3, 0], move[4, 0], move[5, 0]
        dx += b * arm[2] - c * arm[1]
        dy += c * arm[0] - a * arm[2]
        dz += a * arm[1] - b * arm[0]
    along = plane[0] * dx + plane[1] * dy
    for k in range(int(row[UNKNOWNS])):
        steps[k, 0] -= steps[k, 1] * along + steps[k, 2] * dz
    return advance(row, y, steps[:, 0], 1.0)


@jit
def draw_upright(row, y, x, z, tension):
    """Set *y* to a straight upright line at a tension (N), see `interface.draw_line`.

    It runs to the platform point (x, z) in the line's plane, m.
    """
    return whole_length(row, y) if straight(row, x, z, tension, y) else -1.0


@jit
def settle_upright(row, y, x, z, length, i, tension, work):
    """Solve an upright line for its length (m) at a fixed pose, from a guess, see `interface.settle_line`.

    It ends at the platform point (x, z) in the line's plane, m.
    """
    block, steps = work.blocks[i], work.steps[i]
    if row[WEIGHT] == 0.0:
        found = _settle_massless(row, x, z, length, y, block, steps)
        if found != SETTLED:
            return found
    elif not settle(row, x, z, length, y, block, steps) and not (
        guess(row, x, z, length, tension, y) and settle(row, x, z, length, y, block, steps)
    ):
        return FAILED
    work.forces[i, 0], work.forces[i, 1] = system(row, y, x, z, length, block, steps[:, 0])
    return SETTLED


@jit
def _settle_massless(row, x, z, length, y, block, rhs):
    """Solve a massless line: SETTLED, SLACK (its tension in *y* is then SLACK_TENSION) or FAILED."""
    if not straight(row, x, z, SLACK_TENSION, y):
        return FAILED
    excess = whole_length(row, y) - length
    if excess <= 0.0:
        return SLACK
    contact = row[RADIUS] * wrap(row, y)
    compliance = (
        row[SPANS] * y[FREE] * row[FREE_COMPLIANCE] + y[DEAD] * row[DEAD_COMPLIANCE] + contact * row[ARC_COMPLIANCE]
    )
    tension = excess / (compliance + row[END_SPRING])
    straight(row, x, z, tension, y)
    unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
    return SETTLED if settle(row, x, z, length, y, block, rhs) else FAILED


@jit
def find_upright(row, y, plane, length, block, rhs):
    """Solve an upright line for its length (m) at a fixed pose without a guess, see `interface.find_line`.

    *plane* (4,): of the line; *block* (6, 6) and *rhs* (6, 4) are scratch.
    """
    x, z, settled = plane[2], plane[3], False
    if not has_plane(row, plane):
        return UNDER_EXIT
    if isnan(length) or is_in_reach_of_lever(row, plane):
        return INSIDE_SHEAVE
    if row[WEIGHT] == 0.0 and straight(row, x, z, SLACK_TENSION, y) and whole_length(row, y) <= length:
        return OK
    for pull in LEVER_PULLS:
        if not guess(row, x, z, length, pull * max(row[WEIGHT], 1.0) * hypot(x, z), y):
            return INSIDE_SHEAVE
        if settle(row, x, z, length, y, block, rhs) and not _runs_back(row, y):
            settled = True
            for k in range(STATE):
                rhs[k, 3] = y[k]
            if lever_stable(row, y):
                break
    for k in range(STATE):
        y[k] = rhs[k, 3] if settled else nan
    return OK if settled else NOT_CONVERGED


@jit
def _runs_back(row, y):
    """Whether the tension at the sheave does not carry the dead span, which then hangs below the winch."""
    if row[UNKNOWNS] == 3.0 or row[UNKNOWNS] == 5.0:  # without a dead span, or with one that may sag
        return False
    pull = exp(y[TAU]) * sin(y[PSI])
    return pull < 0.0 < pull + row[WEIGHT] * y[DEAD]


@jit
def judge_upright(row, y, plane):
    """Return the status code of an upright line, solved before, see `interface.judge_line`."""
    if not has_plane(row, plane):
        if is_eyelet(row):
            return UNDER_EXIT
        if cos(y[PHI]) < BACKWARDS:  # the sheave can face any way, and drives the platform off its axis
            return UNSTABLE
    if not lever_stable(row, y):
        return LEVER_UNSTABLE
    angle = wrap(row, y)
    if angle < 0.0 or angle > 2.0 * pi:
        return BAD_WRAP
    return OVERSTRETCHED if extremes(row, y)[1] > row[BREAKING] else OK


@jit
def aim_upright(row, y, tension, plane):
    """Draw a straight upright line at *tension* (N); return a code and the unit vector along which it pulls."""
    if is_in_reach_of_lever(row, plane) or not straight(row, plane[2], plane[3], tension, y):
        return INSIDE_SHEAVE, 0.0, 0.0, 0.0
    if not has_plane(row, plane) and cos(y[PHI]) < BACKWARDS:
        return UNDER_EXIT, 0.0, 0.0, 0.0
    contact = wrap(row, y)
    if contact < 0.0 or contact > 2.0 * pi:
        return BAD_WRAP, 0.0, 0.0, 0.0
    along = -cos(y[PHI])
    return OK, along * plane[0], along * plane[1], -sin(y[PHI])


@jit
def stiffen_upright(row, y, i, work, chord):
    """Return the stiffness of an upright line along its chord, N/m, see `interface.stiffen_line`."""
    steps, plane = work.steps[i], work.planes[i]
    h, v = work.forces[i, 0], work.forces[i, 1]
    kxx, kzx = force_change(h, v, row[WEIGHT], steps, 1)
    kxz, kzz = force_change(h, v, row[WEIGHT], steps, 2)
    _, cx, cz = pull_of(row, y, plane[2], plane[3])
    chord[0], chord[1], chord[2] = plane[0] * cx, plane[1] * cx, cz
    return row[PULLS] * (cx * (kxx * cx + kxz * cz) + cz * (kzx * cx + kzz * cz))


@jit
def dips_upright(row, y):
    """Return whether the dead span of an upright line has a lowest point inside, see `interface.dips_line`."""
    v = exp(y[TAU]) * sin(y[PSI])
    return v * (v + row[WEIGHT] * y[DEAD]) < 0.0


@jit
def start_upright(row, y):
    """Return the point where the free span begins, from the exit point, m: along the line's plane, and up."""
    turn = row[SIDE] * row[RADIUS]
    x, z = given_way(row, y)
    x += row[LEVER] * cos(y[BETA]) - turn * sin(y[PHI])
    z += row[LEVER] * sin(y[BETA]) + turn * cos(y[PHI])
    return x, z


@jit
def leave_upright(row, y, plane):
    """Return the directions in which an upright line leaves its guides, see `solved_line.directions_of_line`."""
    has_dead = 1.0 if row[UNKNOWNS] > 3.0 else 0.0
    flat, dead_flat = cos(y[PHI]), has_dead * cos(y[PSI])
    dead_rise = has_dead * sin(y[PSI])
    return flat * plane[0], flat * plane[1], sin(y[PHI]), dead_flat * plane[0], dead_flat * plane[1], dead_rise


@jit
def carry_upright(row, plane, step, scale):
    """Move the winch of an upright line with its exit point, but not that point, see `solved_line.carry_exit`."""
    if row[UNKNOWNS] > 3.0:
        row[WINCH_Z] -= scale * step[2]
    if row[UNKNOWNS] > 4.0:
        row[WINCH_X] -= scale * (step[0] * plane[0] + step[1] * plane[1])
