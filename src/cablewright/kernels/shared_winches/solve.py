"""Inverse problem with lines that share winches: from a pose to tensions and lengths that agree with the drums.

As in `inverse`, tensions of least norm within limits are found by a sequence of quadratic programs (`program`).
Coordinates of the pose may be free: as many at least as there are fewer winches than degrees of freedom.
"""

from math import isnan, nan

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import (
    BAD_WRAP,
    INFEASIBLE,
    LEVER_UNSTABLE,
    MASSLESS,
    NOT_CONVERGED,
    OK,
    SINGULAR,
    TENSION_MAX,
    UNSTABLE,
)
from cablewright.kernels.shared_winches.lengths import measure
from cablewright.kernels.shared_winches.quadratic_program import (
    AGREE,
    LONGEST_STEP,
    begin_program,
    fill_program,
    forget_multipliers,
    missed,
)
from cablewright.kernels.statics.descent import place_below
from cablewright.kernels.statics.equilibrium import judge
from cablewright.kernels.statics.inverse import (
    NEEDS_PUSH,
    PROGRAMS,
    SOFT_TOLERANCE,
    SOLVED,
    TENSION_TOLERANCE,
    balances,
    begin,
    judge_held,
    would_push,
)
from cablewright.kernels.statics.line.counterweight import beyond_limits
from cablewright.kernels.statics.platform import turn_to_start
from cablewright.kernels.statics.tension_distribution import SOFT, Program, distribute
from cablewright.kernels.statics.underactuated import evaluate_at_pulls, hang, keep

ATTEMPTS, PLACED = 5, 2  # starts where the position is free, and where only rotations are
TAUT = (64.0, 16.0, 4.0, 1.0, 0.25)  # of its own weight: minimum tensions with which limits far below it are approached
FITS = 1e-10  # m: up to which solved lengths may miss their drum
GROWTH = 4.0  # of a step: limit of the next step over this one
MISFIT = -2  # infeasible: lengths of rigid cables do not fit their drums
ABSURD = 100.0  # of a line's maximum tension: no answer violates its limit least by as much
POSE_TOLERANCE = 1e-11  # m or rad: last step of a coordinate


@jit(allocates=True)
def solve_shared(packed, shares, pose, states, work, own, known):
    """Find least-norm tensions and line states; own.given (n,) holds the pose, NaN where a coordinate is free.

    *pose* (n,) receives the whole pose; *known*: it and *states* hold a neighbour's. *shares*: see `program`.
    Returns code and the largest violation of a tension limit, N, as `inverse.solve_inverse`.
    """
    attempts = 1
    for k in range(pose.shape[0]):
        if isnan(own.given[k]):
            attempts = max(attempts, ATTEMPTS if k < 3 else PLACED)
    code, violation = NOT_CONVERGED, 0.0
    for attempt in range(1 if known else attempts):
        if not known and not _guess_pose(packed, attempt, pose, states, work, own):
            continue
        code, violation = _attempt(packed, shares, pose, states, work, own, known)
        code, violation = judge_held(packed, pose, states, work, code, violation)
        if code not in (NOT_CONVERGED, NEEDS_PUSH, UNSTABLE, SINGULAR, BAD_WRAP, LEVER_UNSTABLE):
            break
    if code not in SOLVED:
        states[:, :] = nan
        copy(own.given, pose)
    return (INFEASIBLE if code in (NEEDS_PUSH, MISFIT) else code), violation


@jit
def _guess_pose(packed, attempt, pose, states, work, own):
    """Write a start to *pose*: unrotated below the exit points, then hung on springs. Return False if those fail."""
    pose[:] = 0.0
    work.lengths[:] = 0.0  # not known: the guess depends on the frame alone
    turn_to_start(packed, pose, attempt)
    place_below(packed, work.lengths, pose)
    if attempt > 0 or isnan(own.given[0]) or isnan(own.given[1]) or isnan(own.given[2]):
        return hang(packed, own.given, pose, states, work)
    keep(own.given, pose)
    return True


@jit
def _attempt(packed, shares, pose, states, work, own, known):
    """Solve from *pose*: within limits, else with the least violation. Returns code and violation, N."""
    code = _restart(packed, pose, states, work, own, known)
    if code != OK:
        return code, 0.0
    code = _solve(packed, shares, pose, states, work, own)
    if code not in (INFEASIBLE, NEEDS_PUSH, NOT_CONVERGED):
        return code, 0.0
    if packed.platform[MASSLESS] == 0.0:
        if _from_taut(packed, shares, pose, states, work, own):
            return OK, 0.0
        _restart(packed, pose, states, work, own, False)
        code = _solve(packed, shares, pose, states, work, own)
    return code, _violation(packed, states, own, code)


@jit
def _from_taut(packed, shares, pose, states, work, own):
    """Solve with larger minimum tensions, where limits are so low that lines sag much; then without. Whether it does.

    Where the latter fails, the answer is that with the larger ones: within limits, but not the least norm.
    """
    for slackest in TAUT:
        for lower in (True, False):
            _restart(packed, pose, states, work, own, False)
            work.slackest[0] = slackest
            if _solve(packed, shares, pose, states, work, own) != OK:
                break
            if not lower:
                return True
            work.slackest[0] = 0.0
            if _solve(packed, shares, pose, states, work, own) == OK:
                return True
    return False


@jit
def _restart(packed, pose, states, work, own, known):
    """Place all lines at *pose*, straight unless *states* are *known*. Returns a code."""
    if not known:
        keep(own.given, pose)
    begin_program(own)
    work.slackest[0] = 0.0
    return begin(packed, pose, states, work, known)


@jit
def _solve(packed, shares, pose, states, work, own):
    """Solve programs until pulls and pose converge, with softened limits where one is infeasible. Returns a code.

    INFEASIBLE only where pulls and pose converge although a program is; NEEDS_PUSH where a line would have to push.
    """
    relax = 1.0
    for _ in range(PROGRAMS):
        code, change, moved, turned = _advance(packed, shares, pose, states, work, own, 0.0, relax)
        if code in (INFEASIBLE, NOT_CONVERGED):
            proved = code == INFEASIBLE
            code, change, moved, turned = _advance(packed, shares, pose, states, work, own, SOFT, relax)
            if code != OK:
                return NEEDS_PUSH if proved else code
            if change < SOFT_TOLERANCE and moved < SOFT_TOLERANCE:
                return INFEASIBLE
            if would_push(packed, work.pulls, own.required) or _is_far(packed, own):
                return NEEDS_PUSH
            forget_multipliers(own)
        elif code != OK:
            return code
        elif change < TENSION_TOLERANCE and moved < POSE_TOLERANCE:
            if not evaluate_at_pulls(packed, pose, states, work, False):
                return NOT_CONVERGED
            if not (balances(packed, states, work) and _fits(packed, shares, pose, states, work, own)):
                return NOT_CONVERGED
            return judge(packed, states, work.base.planes, work.base.spatial)
        relax = 0.6 * relax if turned else min(1.0, 1.3 * relax)
    return NOT_CONVERGED


@jit
def _fits(packed, shares, pose, states, work, own):
    """Whether the lengths of the evaluated lines fit the drums."""
    measure(packed, pose, states, work.base, own.lengths)
    for r in range(shares.shape[0]):
        allowed = FITS if own.scales[r] > 0.0 else AGREE  # of rigid cables nothing adapts
        if not abs(missed(shares, r, own.lengths.lengths)) <= allowed:
            return False
    return True


@jit
def _violation(packed, states, own, code):
    """Largest violation of a tension limit, N: of the tensions found, or of pulls that no line can have."""
    violation = 0.0
    for i in range(packed.lines.shape[0]):
        if code == INFEASIBLE:
            violation = max(violation, beyond_limits(packed.lines[i], states[i]))
        elif code == NEEDS_PUSH:
            violation = max(violation, own.low[i] - own.required[i], own.required[i] - own.high[i])
    return violation


@jit
def _is_far(packed, own):
    """Whether a pull is required that is out of all proportion to its limit: no cable stretches as much."""
    for i in range(packed.lines.shape[0]):
        if own.required[i] > ABSURD * packed.lines[i, TENSION_MAX]:
            return True
    return False


@jit
def _advance(packed, shares, pose, states, work, own, give, relax):
    """Solve one program and take the share *relax* of its step.

    Returns code, relative change of the pulls, longest step of a coordinate (m, rad), and whether the pulls turn back.
    """
    if not evaluate_at_pulls(packed, pose, states, work, False):
        return NOT_CONVERGED, 0.0, 0.0, False
    measure(packed, pose, states, work.base, own.lengths)
    if not fill_program(packed, shares, pose, states, work, own):
        return MISFIT, 0.0, 0.0, False
    program = Program(own.structure, own.load, own.low, own.high, own.curvature, own.bias)
    solved = distribute(program, give, own.required, own.multipliers, own.hessian, own.step)
    if solved <= 0:
        return (INFEASIBLE if solved == 0 else NOT_CONVERGED), 0.0, 0.0, False
    m, largest, change, along, moved = packed.lines.shape[0], 0.0, 0.0, 0.0, 0.0
    for i in range(m):
        pull = work.pulls[i]
        largest = max(largest, pull)
        required = max(own.required[i], 0.4 * pull)  # with softened limits it may be negative
        work.pulls[i] = pull + relax * (required - pull)
        change = max(change, abs(required - pull))
        along += own.moves[i] * (required - pull)
        own.moves[i] = required - pull
    for k in range(pose.shape[0]):
        if isnan(own.given[k]):
            step = min(max(own.required[m + k] / own.rates[k], -LONGEST_STEP), LONGEST_STEP)
            pose[k] += relax * step
            moved = max(moved, abs(step))
    own.reach[0] = min(LONGEST_STEP, GROWTH * moved)
    return OK, change / largest, moved, along < 0.0
