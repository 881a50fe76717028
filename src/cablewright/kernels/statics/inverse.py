"""Inverse problem: from a pose to unstrained lengths and tensions, within tension limits.

The unknown of each line is its pull (`upright_pull.pull_of`), its tension where cables are straight. The solution has
the least norm of the pulls, or of their distances from preferred pulls. With sag it is found by a sequence of quadratic
programs on the lines linearised at their current pulls; with straight cables and no levers the first one is exact.
"""

from math import exp, hypot, log

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, largest
from cablewright.kernels.layout import (
    BAD_WRAP,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    INFEASIBLE,
    LEVER_UNSTABLE,
    MASSLESS,
    NOT_CONVERGED,
    OK,
    OVERSTRETCHED,
    PLATFORM_WEIGHT,
    PREFERRED,
    SINGULAR,
    TAU,
    TENSION_MIN,
    UNSTABLE,
    WEIGHT,
    WINCH_Z,
    Packed,
)
from cablewright.kernels.statics.equilibrium import evaluate, judge, judge_stability, unbalanced
from cablewright.kernels.statics.line.counterweight import beyond_hung_limits, beyond_limits
from cablewright.kernels.statics.line.interface import (
    add_line_pull,
    begin_line,
    column_line,
    extremes_at_pull,
    is_predicted_exactly,
    may_tip,
    predict_line,
    settle_line_at_pull,
)
from cablewright.kernels.statics.line.pull_limits import pull_limits
from cablewright.kernels.statics.line.upright import SLACK_TENSION, extremes, lengths_of
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import keep_free, load_scale, place_platform, start_balance
from cablewright.kernels.statics.tension_distribution import SOFT, Program, distribute

PROGRAMS = 120
SOFT_PROGRAMS = 40
SOFT_TOLERANCE = 1e-8  # of the largest pull
AMBIGUOUS = 0.01  # of its own weight: a line with a smaller tension can have several shapes
SLACKEST = 0.25  # of its own weight: minimum tension of a line where smaller ones lead to no solution
MIN_SECANT = 1e-4  # of a pull: the curvature over a shorter step is rounding
MIN_PULL = 0.02  # of its share of the load: pull of a line that programs have reduced again and again
SMALL_VIOLATION = 1e-3  # of the load: up to here a pose is tried again before it is reported infeasible
TENSION_TOLERANCE = 1e-11  # of the largest pull
IDLE = 1e-10  # of the largest pull: programs halve the pull of an idle line until it is about a tenth of this
BALANCE_TOLERANCE = 1e-9  # of the largest force
STIFFEST = 1e-8  # 1/N: compliance assumed for rigid cables where the stability of the platform is judged
NEEDS_PUSH = -1  # infeasible, and no line states that balance the load
SOLVED = (OK, INFEASIBLE, OVERSTRETCHED, BAD_WRAP, LEVER_UNSTABLE, UNSTABLE, SINGULAR)  # codes with line states


@jit
def solve_inverse(packed, pose, states, work, known):
    """Find least-norm tensions and line states at *pose*; *known*: *states* hold a neighbour's solution.

    Returns code and the largest violation of a tension limit (N, 0 where feasible). Where limits cannot be met
    *states* hold the distribution that violates them least; where no state balances the load they are NaN.
    """
    code, violation = _solve(packed, pose, states, work, known)
    code, violation = judge_held(packed, pose, states, work, code, violation)
    if code not in SOLVED:
        states[:, :] = np.nan
    return (INFEASIBLE if code == NEEDS_PUSH else code), violation


@jit
def judge_held(packed, pose, states, work, code, violation):
    """Return status code and violation (N) of an inverse solution, by counterweights and stability.

    Marks slack lines.
    """
    if code == OK:
        code, violation = _judge_hung(packed, states)
    if code == OK and packed.platform[MASSLESS] > 0.0:
        _mark_slack(packed, states, work.pulls)
    if code == OK and may_tip(packed, states):
        code = stays(packed, pose, states, work)
    return code, violation


@jit
def _solve(packed, pose, states, work, known):
    code = begin(packed, pose, states, work, known)
    if code != OK:
        return code, 0.0
    code = _distribute(packed, pose, states, work, 0.0)
    if code not in (INFEASIBLE, NOT_CONVERGED) and _slackest(packed, states) > AMBIGUOUS:
        return code, 0.0
    if code == INFEASIBLE and not _may_slacken(packed, work.base):
        return _least_infeasible(packed, pose, states, work)
    # the limits let a line become slack under its own weight: try with a larger minimum tension first
    begin(packed, pose, states, work, False)
    if _distribute(packed, pose, states, work, SLACKEST) == OK:
        return OK, 0.0
    begin(packed, pose, states, work, False)
    code = _distribute(packed, pose, states, work, 0.0)
    if code != INFEASIBLE:
        return code, 0.0
    return _least_infeasible(packed, pose, states, work)


@jit
def _judge_hung(packed, states):
    """Code and violation (N) of the limits by lines whose tension a counterweight decides."""
    violation, most = 0.0, 0.0
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        violation = max(violation, beyond_hung_limits(row, states[i]))
        most = max(most, row[COUNTERWEIGHT])
    return (INFEASIBLE, violation) if violation > BALANCE_TOLERANCE * most else (OK, 0.0)


@jit
def _mark_slack(packed, states, pulls):
    """Mark as slack the massless lines that carry next to nothing, where no tension is asked of them; unstrain them."""
    most = largest(pulls, pulls.shape[0])
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if row[WEIGHT] == 0.0 and row[TENSION_MIN] == 0.0 and pulls[i] <= IDLE * most:
            tension = exp(y[TAU])
            y[FREE] *= 1.0 + tension * row[FREE_COMPLIANCE]
            y[DEAD] *= 1.0 + tension * row[DEAD_COMPLIANCE]
            y[TAU] = log(SLACK_TENSION)


@jit
def _may_slacken(packed, base):
    """Whether the limits allow a line tensions near SLACKEST, at which it can have several shapes."""
    for i in range(packed.lines.shape[0]):
        row, plane = packed.lines[i], base.planes[i]
        if row[TENSION_MIN] < 2.0 * SLACKEST * row[WEIGHT] * (hypot(plane[2], plane[3]) + abs(row[WINCH_Z])):
            return True
    return False


@jit
def _least_infeasible(packed, pose, states, work):
    """Write the tensions of an infeasible pose that violate the limits least. Returns code and violation, N."""
    settled, violation = _least_violation(packed, pose, states, work)
    if settled and violation <= SMALL_VIOLATION * load_scale(packed):
        code = _distribute(packed, pose, states, work, 0.0)  # the infeasible program was far from the solution
        if code != INFEASIBLE:
            return code, 0.0
        settled, violation = _least_violation(packed, pose, states, work)
    return (INFEASIBLE if settled else NEEDS_PUSH), violation


@jit
def stays(packed, pose, states, work):
    """Return the status code of the platform at *pose*: OK if its equilibrium is stable at constant lengths."""
    elastic = none_rigid(packed, work)
    for i in range(packed.lines.shape[0]):
        added = elastic.lines[i, FREE_COMPLIANCE] - packed.lines[i, FREE_COMPLIANCE]
        states[i, FREE] /= 1.0 + exp(states[i, TAU]) * added
    lengths_of(elastic, states, work.lengths)
    evaluate(elastic, work.lengths, pose, states, work.base)
    for i in range(packed.lines.shape[0]):
        added = elastic.lines[i, FREE_COMPLIANCE] - packed.lines[i, FREE_COMPLIANCE]
        states[i, FREE] *= 1.0 + exp(states[i, TAU]) * added
    return judge_stability(elastic, states, work.base)


@jit
def none_rigid(packed, work):
    """Return the robot with very stiff cables in place of rigid ones."""
    for i in range(packed.lines.shape[0]):
        copy(packed.lines[i], work.lines[i])
        work.lines[i, FREE_COMPLIANCE] = max(packed.lines[i, FREE_COMPLIANCE], STIFFEST)
    return Packed(packed.freedoms, work.lines, packed.platform, packed.general)


@jit
def balances(packed, states, work):
    """Return whether the solved lines balance the platform: programs can converge to an ill-conditioned result."""
    base = work.base
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    scale = packed.platform[PLATFORM_WEIGHT]
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        scale = max(scale, add_line_pull(row, states[i], i, base, base.spatial, base.wrench))
    keep_free(packed, base.wrench)
    return unbalanced(packed, base.arms, base.wrench) <= BALANCE_TOLERANCE * scale


@jit
def _slackest(packed, states):
    """Smallest tension along any line as a share of the line's weight."""
    share = 1e300
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        carried = row[WEIGHT] * (y[FREE] + y[DEAD])
        if carried > 0.0:
            share = min(share, extremes(row, y)[0] / carried)
    return share


@jit
def _distribute(packed, pose, states, work, slackest):
    """Solve programs until the pulls converge, with tensions of at least *slackest* of a line's weight; a code."""
    work.slackest[0] = slackest
    relax = 1.0
    work.moves[:], work.before[:], work.curvature[:] = 0.0, 0.0, 1.0
    for _ in range(PROGRAMS):
        code, change, turned = _program(packed, pose, states, work, 0.0, relax)
        if code != OK:
            return code
        if change < TENSION_TOLERANCE:
            if not (_settle_idle(packed, pose, states, work) and balances(packed, states, work)):
                return NOT_CONVERGED
            return judge(packed, states, work.base.planes, work.base.spatial)
        # slack lines are nonlinear: shorten the steps where programs overshoot
        relax = 0.6 * relax if turned else min(1.0, 1.3 * relax)
    return NOT_CONVERGED


@jit
def _settle_idle(packed, pose, states, work):
    """Solve the lines whose last change of pull was small among the pulls, but not for themselves. False if one fails.

    Their states were only predicted, which is exact to the square of that change.
    """
    base = work.base
    for i in range(packed.lines.shape[0]):
        row, pull = packed.lines[i], work.pulls[i]
        if is_predicted_exactly(row, pull, work.moves[i]):
            continue
        if not settle_line_at_pull(row, states[i], pose, i, pull, base, base.spatial):
            return False
    return True


@jit
def _least_violation(packed, pose, states, work):
    """Move *states* to the tensions that violate the limits least.

    Returns whether the pulls converge, and the largest violation (N). Where a line would have to push they cannot
    converge, and the violation is that of its pull.
    """
    work.multipliers[:], work.moves[:], work.before[:], work.curvature[:] = 0.0, 0.0, 0.0, 1.0
    relax = 1.0
    for _ in range(SOFT_PROGRAMS):
        code, change, turned = _program(packed, pose, states, work, SOFT, relax)
        if code != OK or change < SOFT_TOLERANCE or would_push(packed, work.pulls, work.required):
            break
        relax = 0.6 * relax if turned else min(1.0, 1.3 * relax)
    violation = 0.0
    if code == OK and change < SOFT_TOLERANCE:
        for i in range(packed.lines.shape[0]):
            violation = max(violation, beyond_limits(packed.lines[i], states[i]))
        return True, violation
    for i in range(packed.lines.shape[0]):
        violation = max(violation, work.low[i] - work.required[i], work.required[i] - work.high[i])
    return False, violation


@jit
def would_push(packed, pulls, required):
    """Return whether some line would have to push: its pull is required although it has fallen to almost nothing."""
    share = load_scale(packed) / packed.lines.shape[0]
    for i in range(packed.lines.shape[0]):
        if required[i] <= 0.0 and pulls[i] < MIN_PULL * max(share, packed.lines[i, TENSION_MIN]):
            return True
    return False


@jit
def begin(packed, pose, states, work, known):
    """Place all lines and guess their states: straight lines that share the load, unless *states* are *known*.

    Returns a code.
    """
    base = work.base
    if not known:
        work.multipliers[:] = 0.0
    share = load_scale(packed) / packed.lines.shape[0]
    place_platform(pose, base.rotation)
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        place(packed.lines, i, pose, base.rotation, base.arms[i], base.planes[i])
        code, work.pulls[i] = begin_line(row, y, pose, i, known, share, base, base.spatial)
        if code != OK:
            return code
    return OK


@jit
def _program(packed, pose, states, work, give, relax):
    """Solve the lines at their pulls, linearise, distribute, and take the share *relax* of the step.

    Returns code, relative change of the pulls, and whether the step reverses the one before.
    """
    m, base = packed.lines.shape[0], work.base
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    copy(base.wrench, work.load)
    program = Program(work.structure, work.load, work.low, work.high, work.curvature, work.bias)
    for i in range(m):
        row, y = packed.lines[i], states[i]
        pull = work.pulls[i]
        solved, low, high, dlow, dhigh = _linearise_line(packed, i, pose, y, work)
        if not solved:
            return NOT_CONVERGED, 0.0, False
        curve(program, work.multipliers, work.before, work.column, i, pull, row[PREFERRED])
        work.low[i], work.high[i] = pull_limits(row, y, pull, work.slackest[0], low, high, dlow, dhigh)
    keep_free(packed, work.load)
    solved = distribute(program, give, work.required, work.multipliers, base.stiffness, work.step)
    if solved <= 0:
        return (INFEASIBLE if solved == 0 else NOT_CONVERGED), 0.0, False
    largest, change, along = 0.0, 0.0, 0.0
    for i in range(m):
        pull = work.pulls[i]
        largest = max(largest, pull)
        required = max(work.required[i], 0.4 * pull)  # with softened limits it may be negative
        work.pulls[i] = pull + relax * (required - pull)
        grown = log(work.pulls[i] / pull)
        if abs(grown) < 0.1:  # predict the line's state along dy / dlog(pull), which saves it a Newton step
            predict_line(packed.lines[i], states[i], i, grown, base, base.spatial)
        change = max(change, abs(required - pull))
        along += work.moves[i] * (required - pull)
        work.moves[i] = required - pull
    return OK, change / largest, along < 0.0


@jit
def _linearise_line(packed, i, pose, y, work):
    """Solve line *i* at its pull; write its wrench per pull, reversed, to work.column and add the rest to work.load.

    Returns whether it is solved, its extremes of tension, and their changes per logarithm of the pull.
    """
    row, pull, base = packed.lines[i], work.pulls[i], work.base
    if not settle_line_at_pull(row, y, pose, i, pull, base, base.spatial):
        return False, 0.0, 0.0, 0.0, 0.0
    column_line(row, y, i, pull, base, base.spatial, work.column, work.load)
    keep_free(packed, work.column)
    low, high, dlow, dhigh = extremes_at_pull(row, y, i, base, base.spatial)
    return True, low, high, dlow, dhigh


@jit
def curve(program, multipliers, before, column, i, pull, preferred):
    """Store line *i*'s *column* of the structure matrix, and its curvature (Hessian entry) for the next program.

    A line's force depends on its own pull alone, so that the Hessian is diagonal and a secant through the last
    program's column gives its entries. *multipliers* and the pulls *before* (m,), N, are those of the last program.
    """
    step = pull - before[i]
    if abs(step) > MIN_SECANT * pull and before[i] > 0.0:
        bend = 0.0
        for k in range(column.shape[0]):
            bend += multipliers[k] * (column[k] - program.structure[k, i])
        program.curvature[i] = min(max(1.0 - bend / step, 0.5), 1e9)
    for k in range(column.shape[0]):
        program.structure[k, i] = column[k]
    before[i] = pull
    program.bias[i] = (program.curvature[i] - 1.0) * pull + preferred
