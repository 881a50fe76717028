"""Inverse problem: pose to unstrained lengths and tensions, under tension limits.

Lines are told apart by their pull (`line.pull_of`): least norm means of the pulls, which are the tensions where cables
are straight; where pulls are preferred, of their distances from those. With sag the distribution is a sequence of
quadratic programs on the lines linearised at their present pulls; with straight cables and no levers the first is
already exact.
"""

from math import exp, hypot, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    COLUMNS,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    LEVER,
    PHI,
    PLATFORM_WEIGHT,
    PREFERRED,
    PSI,
    RADIUS,
    TAU,
    TENSION_MAX,
    TENSION_MIN,
    UNKNOWNS,
    WEIGHT,
    WINCH_Z,
    Code,
    Packed,
)
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics.equilibrium import (
    BAD_WRAP,
    LEVER_UNSTABLE,
    NOT_CONVERGED,
    OK,
    OVERSTRETCHED,
    SINGULAR,
    UNDER_EXIT,
    UNSTABLE,
    Work,
    evaluate,
    judge,
    judge_stability,
    workspace,
)
from cablewright.kernels.statics.line import (
    extremes,
    extremes_and_change,
    force_change,
    length_of,
    pull_of,
    settle_at_pull,
    start_force,
)
from cablewright.kernels.statics.sheave import straight, unstrain
from cablewright.kernels.statics.tension import SOFT, distribute
from cablewright.kernels.statics.wrench import add_force, place, start_balance

PROGRAMS = 120
SOFT_PROGRAMS = 40
SOFT_TOLERANCE = 1e-8  # of the largest pull
TAUT = 1.5  # of its own weight: a tension at which a line is straight enough to begin with
UNSURE = 0.01  # of its own weight: a line so slack may as well hang otherwise
SLACKEST = 0.25  # of its own weight: the least asked of a line where less leads nowhere
LEAST_SECANT = 1e-4  # of a pull: over a shorter step the curvature drowns in rounding
LET_GO = 0.02  # of its share of the weight: a line's pull when it is given up
SECOND_CHANCE = 1e-3  # of the weight: a violation so small is looked at again
TENSION_TOLERANCE = 1e-11  # of the largest pull
BALANCE_TOLERANCE = 1e-9  # of the largest force
STIFFEST = 1e-8  # 1/N: rigid cables are taken as this elastic where it is asked whether the platform stays
FLATTEST = 0.05  # of an extreme's change per pull: flatter than this, a limit is not linearised
INFEASIBLE = int(Code.INFEASIBLE)
INSIDE_SHEAVE = int(Code.INSIDE_SHEAVE)
NEEDS_PUSH = -1  # infeasible, and no line states that balance the load
ANSWERED = (OK, INFEASIBLE, OVERSTRETCHED, BAD_WRAP, LEVER_UNSTABLE, UNSTABLE, SINGULAR)  # codes that come with a state


class InverseWork(NamedTuple):
    """Scratch of the inverse problem beside that of the equilibrium."""

    base: Work
    structure: NDArray[np.float64]  # (n, m): wrench per pull, reversed
    load: NDArray[np.float64]  # (n,)
    low: NDArray[np.float64]  # (m,): limits on the pull
    high: NDArray[np.float64]
    pulls: NDArray[np.float64]  # (m,)
    wanted: NDArray[np.float64]  # (m,)
    multipliers: NDArray[np.float64]  # (n,)
    moves: NDArray[np.float64]  # (m,): the last change wanted of the pulls
    before: NDArray[np.float64]  # (m,): pulls of the last program
    curvature: NDArray[np.float64]  # (m,): of the Lagrangian
    bias: NDArray[np.float64]  # (m,)
    column: NDArray[np.float64]  # (n,)
    step: NDArray[np.float64]  # (n, 3)
    slackest: NDArray[np.float64]  # (1,): share of its weight that a line's tension may not fall under
    lengths: NDArray[np.float64]  # (m,)
    lines: NDArray[np.float64]  # (m, COLUMNS): as packed, but none of them rigid
    mixed: NDArray[np.float64]  # (n, n): of an underconstrained robot, wrench per free freedom and per pull


@jit(allocates=True)
def inverse_workspace(packed):
    """Scratch that fits *packed*."""
    m, n = packed.lines.shape[0], packed.freedoms
    return InverseWork(
        workspace(packed),
        np.zeros((n, m)),
        np.zeros(n),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros(n),
        np.zeros(m),
        np.zeros(m),
        np.ones(m),
        np.zeros(m),
        np.zeros(n),
        np.zeros((n, 3)),
        np.zeros(1),
        np.zeros(m),
        np.zeros((m, COLUMNS)),
        np.zeros((n, n)),
    )


@jit
def solve_inverse(packed, pose, states, work, known):
    """Least-norm tensions and line states at *pose*; *known* says that *states* hold a neighbour's solution.

    Returns code and the largest violation of a tension limit (N, 0 where feasible). Where limits cannot be met
    *states* hold the distribution that violates them least; where no state balances the load they are NaN.
    """
    code, violation = _solve(packed, pose, states, work, known)
    if code == OK and packed.freedoms == 6:
        code = stays(packed, pose, states, work)
    if code not in ANSWERED:
        states[:, :] = np.nan
    return (INFEASIBLE if code == NEEDS_PUSH else code), violation


@jit
def _solve(packed, pose, states, work, known):
    code = _begin(packed, pose, states, work, known)
    if code != OK:
        return code, 0.0
    if not known:
        work.multipliers[:] = 0.0
    code = _distribute(packed, states, work, 0.0)
    if code not in (INFEASIBLE, NOT_CONVERGED) and _slackest(packed, states) > UNSURE:
        return code, 0.0
    if code == INFEASIBLE and not _may_slacken(packed, work.base):
        return _least_bad(packed, states, work)
    # limits that let a line go slack under its own weight: ask no line to go that far
    _begin(packed, pose, states, work, False)
    work.multipliers[:] = 0.0
    if _distribute(packed, states, work, SLACKEST) == OK:
        return OK, 0.0
    _begin(packed, pose, states, work, False)
    work.multipliers[:] = 0.0
    code = _distribute(packed, states, work, 0.0)
    if code != INFEASIBLE:
        return code, 0.0
    return _least_bad(packed, states, work)


@jit
def _may_slacken(packed, base):
    """Whether limits let a line hang as slack as SLACKEST, where it may hang in more ways than one."""
    for i in range(packed.lines.shape[0]):
        row, plane = packed.lines[i], base.planes[i]
        if row[TENSION_MIN] < 2.0 * SLACKEST * row[WEIGHT] * (hypot(plane[2], plane[3]) + abs(row[WINCH_Z])):
            return True
    return False


@jit
def _least_bad(packed, states, work):
    """What an infeasible pose is answered: the tensions that break the limits least, and by how much."""
    settled, violation = _least_violation(packed, states, work)
    if settled and violation <= SECOND_CHANCE * packed.platform[PLATFORM_WEIGHT]:
        code = _distribute(packed, states, work, 0.0)  # the no was that of a program far from the answer
        if code != INFEASIBLE:
            return code, 0.0
        settled, violation = _least_violation(packed, states, work)
    return (INFEASIBLE if settled else NEEDS_PUSH), violation


@jit
def stays(packed, pose, states, work):
    """Whether a rigid body that is held at *pose* returns when pushed, with the lengths held: a status code."""
    stretching = none_rigid(packed, work)
    for i in range(packed.lines.shape[0]):
        states[i, FREE] /= 1.0 + exp(states[i, TAU]) * (
            stretching.lines[i, FREE_COMPLIANCE] - packed.lines[i, FREE_COMPLIANCE]
        )
    lengths_of(stretching, states, work.lengths)
    evaluate(stretching, work.lengths, pose, states, work.base)
    for i in range(packed.lines.shape[0]):
        states[i, FREE] *= 1.0 + exp(states[i, TAU]) * (
            stretching.lines[i, FREE_COMPLIANCE] - packed.lines[i, FREE_COMPLIANCE]
        )
    return judge_stability(stretching, states, work.base)


@jit
def none_rigid(packed, work):
    """The robot with rigid cables made very stiff ones."""
    for i in range(packed.lines.shape[0]):
        for k in range(COLUMNS):
            work.lines[i, k] = packed.lines[i, k]
        work.lines[i, FREE_COMPLIANCE] = max(packed.lines[i, FREE_COMPLIANCE], STIFFEST)
    return Packed(packed.freedoms, work.lines, packed.platform)


@jit
def balances(packed, states, work):
    """Whether the settled lines hold the platform, to rounding: programs can rest on an ill-conditioned answer."""
    base = work.base
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    scale = packed.platform[PLATFORM_WEIGHT]
    for i in range(packed.lines.shape[0]):
        h, v = start_force(states[i])
        v += packed.lines[i, WEIGHT] * states[i, FREE]
        plane = base.planes[i]
        add_force(base.arms[i], -h * plane[0], -h * plane[1], -v, base.wrench)
        scale = max(scale, abs(h), abs(v))
    for k in range(packed.freedoms):
        if not abs(base.wrench[k]) <= BALANCE_TOLERANCE * scale:
            return False
    return True


@jit
def _slackest(packed, states):
    """Smallest tension along any line as a share of that line's own weight."""
    share = 1e300
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        carried = row[WEIGHT] * (y[FREE] + y[DEAD])
        if carried > 0.0:
            share = min(share, extremes(row, y)[0] / carried)
    return share


@jit
def _distribute(packed, states, work, slackest):
    """Programs under the limits until the pulls rest, no line slacker than *slackest* of its weight. Returns a code."""
    work.slackest[0] = slackest
    relax = 1.0
    work.moves[:] = 0.0
    work.before[:] = 0.0
    work.curvature[:] = 1.0
    for _ in range(PROGRAMS):
        code, change, turned = _program(packed, states, work, 0.0, relax)
        if code != OK:
            return code
        if change < TENSION_TOLERANCE:
            return judge(packed, states, work.base.planes) if balances(packed, states, work) else NOT_CONVERGED
        # slack lines curve: where the programs overshoot, go only part of the way
        relax = 0.6 * relax if turned else min(1.0, 1.3 * relax)
    return NOT_CONVERGED


@jit
def _least_violation(packed, states, work):
    """Move *states* to the tensions that break the limits least.

    Returns whether they rest there, and by how much they break them (N): where a line would have to push there is
    nothing to rest at, and the violation is that of its pull.
    """
    work.multipliers[:] = 0.0
    work.curvature[:] = 1.0
    work.before[:] = 0.0
    work.moves[:] = 0.0
    relax = 1.0
    for _ in range(SOFT_PROGRAMS):
        code, change, turned = _program(packed, states, work, SOFT, relax)
        if code != OK or change < SOFT_TOLERANCE or _would_push(packed, work):
            break
        relax = 0.6 * relax if turned else min(1.0, 1.3 * relax)
    violation = 0.0
    if code == OK and change < SOFT_TOLERANCE:
        for i in range(packed.lines.shape[0]):
            least, most = extremes(packed.lines[i], states[i])
            violation = max(violation, packed.lines[i, TENSION_MIN] - least, most - packed.lines[i, TENSION_MAX])
        return True, violation
    for i in range(packed.lines.shape[0]):
        violation = max(violation, work.low[i] - work.wanted[i], work.wanted[i] - work.high[i])
    return False, violation


@jit
def _would_push(packed, work):
    """Whether a line that has been let go program after program still wants to push."""
    share = packed.platform[PLATFORM_WEIGHT] / packed.lines.shape[0]
    for i in range(packed.lines.shape[0]):
        if work.wanted[i] <= 0.0 and work.pulls[i] < LET_GO * max(share, packed.lines[i, TENSION_MIN]):
            return True
    return False


@jit
def _begin(packed, pose, states, work, known):
    """Place all lines; without known states start from straight lines at a fair share of the load."""
    base = work.base
    share = packed.platform[PLATFORM_WEIGHT] / packed.lines.shape[0]
    if packed.freedoms == 6:
        matrix(pose[3:], base.rotation)
    for i in range(packed.lines.shape[0]):
        row, y, plane = packed.lines[i], states[i], base.planes[i]
        place(packed.lines, i, pose, base.rotation, base.arms[i], plane)
        if plane[2] <= 1e-9:
            return UNDER_EXIT
        if row[UNKNOWNS] == 6.0 and hypot(plane[2], plane[3]) < row[LEVER] + row[RADIUS]:
            return INSIDE_SHEAVE  # within reach of the lever
        if not known:
            tension = max(share, row[TENSION_MIN], 1.0)
            if not straight(row, plane[2], plane[3], tension, y):
                return INSIDE_SHEAVE
            tension = max(tension, TAUT * row[WEIGHT] * (y[FREE] + y[DEAD]))
            y[TAU] = log(tension)
            unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
            work.pulls[i] = tension
        else:
            work.pulls[i], _, _ = pull_of(row, y, plane[2], plane[3])
    return OK


@jit
def _program(packed, states, work, give, relax):
    """Settle the lines at their pulls, linearise, distribute, go *relax* of the way.

    Returns code, relative change, and whether the way turned back on the one before.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    base = work.base
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    for k in range(n):
        work.load[k] = base.wrench[k]
    for i in range(m):
        row, y, plane, steps = packed.lines[i], states[i], base.planes[i], base.steps[i]
        pull = work.pulls[i]
        if not settle_at_pull(row, plane[2], plane[3], pull, y, base.blocks[i], steps):
            return NOT_CONVERGED, 0.0, False
        h, v = start_force(y)
        dh, dv = force_change(h, v, row[WEIGHT], steps, 1)
        dh, dv = dh / pull, dv / pull
        work.column[:] = 0.0
        add_force(base.arms[i], dh * plane[0], dh * plane[1], dv, work.column)
        _curve(work, i, pull, row[PREFERRED])
        # the part of the end force that is not proportional to the pull belongs to the load
        h, v = h - dh * pull, v + row[WEIGHT] * y[FREE] - dv * pull
        add_force(base.arms[i], -h * plane[0], -h * plane[1], -v, work.load)
        least, most, dleast, dmost = extremes_and_change(
            row, y, steps[PHI, 1], steps[TAU, 1], steps[FREE, 1], steps[DEAD, 1], steps[PSI, 1]
        )
        wanted = max(row[TENSION_MIN], work.slackest[0] * row[WEIGHT] * (y[FREE] + y[DEAD]))
        work.low[i] = pull + (wanted - least) * pull / max(dleast, FLATTEST * pull)
        work.high[i] = pull + (row[TENSION_MAX] - most) * pull / max(dmost, FLATTEST * pull)
    solved = distribute(
        work.structure,
        work.load,
        work.low,
        work.high,
        work.curvature,
        work.bias,
        give,
        work.wanted,
        work.multipliers,
        base.stiffness,
        work.step,
    )
    if solved <= 0:
        return (INFEASIBLE if solved == 0 else NOT_CONVERGED), 0.0, False
    largest, change, along = 0.0, 0.0, 0.0
    for i in range(m):
        pull = work.pulls[i]
        largest = max(largest, pull)
        wanted = max(work.wanted[i], 0.4 * pull)  # a softened limit may ask for less than nothing
        work.pulls[i] = pull + relax * (wanted - pull)
        _predict(packed.lines[i], states[i], base.steps[i], log(work.pulls[i] / pull))
        change = max(change, abs(wanted - pull))
        along += work.moves[i] * (wanted - pull)
        work.moves[i] = wanted - pull
    return OK, change / largest, along < 0.0


@jit
def _predict(row, y, steps, grown):
    """Take *y* along dy / dlog(pull) where the pull has changed little: the line then settles in a step less."""
    if abs(grown) < 0.1:
        for k in range(int(row[UNKNOWNS])):
            y[k] += grown * steps[k, 1]


@jit
def _curve(work, i, pull, preferred):
    """Take line *i*'s column, and from its change since the last program the curvature of the Lagrangian there.

    Each line's force depends on its own pull alone, so the Hessian is diagonal and a secant gives it.
    """
    step = pull - work.before[i]
    if abs(step) > LEAST_SECANT * pull and work.before[i] > 0.0:
        bend = 0.0
        for k in range(work.column.shape[0]):
            bend += work.multipliers[k] * (work.column[k] - work.structure[k, i])
        work.curvature[i] = min(max(1.0 - bend / step, 0.5), 1e9)
    for k in range(work.column.shape[0]):
        work.structure[k, i] = work.column[k]
    work.before[i] = pull
    work.bias[i] = (work.curvature[i] - 1.0) * pull + preferred


@jit
def lengths_of(packed, states, out):
    """Unstrained lengths of all lines, m."""
    for i in range(packed.lines.shape[0]):
        out[i] = length_of(packed.lines[i], states[i])
