"""Inverse problem with fewer lines than degrees of freedom: m coordinates are given, gravity decides the others.

The platform first hangs on springs with the lengths of a guessed pose, which gives the free coordinates and the pulls.
Newton on the platform's balance in these n unknowns follows, with each line solved at its pull. In a plane the
coordinates across it are also given, and the reactions of the plane are the unknowns instead.
"""

from math import exp, isnan, nan, pi, sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, copy_rows, largest, largest_of_column, solve
from cablewright.kernels.layout import FREE, FREE_COMPLIANCE, INFEASIBLE, NOT_CONVERGED, OK, TENSION_MIN, WEIGHT
from cablewright.kernels.statics.descent import SPRING, SPRING_TOLERANCE, descend, place_below
from cablewright.kernels.statics.equilibrium import judge
from cablewright.kernels.statics.forward import UPRIGHT
from cablewright.kernels.statics.inverse import NEEDS_PUSH, balances, none_rigid, stays
from cablewright.kernels.statics.line.counterweight import beyond_limits
from cablewright.kernels.statics.line.interface import hang_line
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import (
    STARTS,
    add_reactions,
    angle_of,
    keep_free,
    load_scale,
    place_platform,
    rates_of_rotation,
    start_balance,
    turn_to_start,
)

MAX_PUSHING = 2  # number of the start from which on a line that would have to push ends the search
SPRING_ROUNDS = 3  # descents on springs before Newton
NEWTON_STEPS = 60
HALVINGS = 12
FORCE_TOLERANCE = 1e-13  # of the load
NO_PULL = 1e-4  # of the load: a smaller pull means that the line would have to push
LONGEST_STEP = 0.3  # m, rad or log of a pull


@jit(allocates=True)
def solve_hanging(packed, pose, states, work):
    """Complete *pose*, whose n - m free coordinates are NaN, and write the line states of that equilibrium.

    Of the solutions found from several starts the stable one within the tension limits with the smallest rotation
    angle is taken. Returns code and the largest violation of a tension limit (N).
    """
    given = pose.copy()
    best, best_states = pose.copy(), states.copy()
    answer, violation, min_angle = NOT_CONVERGED, 0.0, 1e300
    for start in range(STARTS):
        pose[:] = 0.0
        turn_to_start(packed, pose, start)
        code, beyond = _solve_from(packed, given, pose, states, work)
        angle = angle_of(pose)
        if code == answer:
            better = angle < min_angle if code == OK else beyond < violation
        else:
            better = _rank(code) > _rank(answer)
        if better:
            answer, violation, min_angle = code, beyond, angle
            copy(pose, best)
            copy_rows(states, best_states)
        if (answer == OK and min_angle < UPRIGHT) or (answer == NEEDS_PUSH and start >= MAX_PUSHING):
            break
    copy(best, pose)
    copy_rows(best_states, states)
    if answer in (NOT_CONVERGED, NEEDS_PUSH):
        copy(given, pose)
        states[:, :] = nan
    return (INFEASIBLE if answer == NEEDS_PUSH else answer), violation


@jit
def _rank(code):
    """Preference among codes: the larger the better."""
    if code == OK:
        return 4
    if code == INFEASIBLE:
        return 3
    return 0 if code == NOT_CONVERGED else 1 if code == NEEDS_PUSH else 2


@jit(allocates=True)
def _solve_from(packed, given, pose, states, work):
    """Solve from the guess in *pose*. Returns code and violation."""
    work.lengths[:] = 0.0  # not known yet: the guess then depends on the frame alone
    place_below(packed, work.lengths, pose)
    if not hang(packed, given, pose, states, work):
        return NOT_CONVERGED, 0.0
    if not _balance(packed, given, pose, states, work):
        return _judge_failure(packed, states, work)
    code = stays(packed, pose, states, work)
    if code != OK:
        return code, 0.0
    code = judge(packed, states, work.base.planes, work.base.spatial)
    violation = 0.0
    for i in range(packed.lines.shape[0]):
        violation = max(violation, beyond_limits(packed.lines[i], states[i]))
    if code == OK and violation > 0.0:
        return INFEASIBLE, violation
    return code, violation


@jit
def _judge_failure(packed, states, work):
    """Code and violation where the balance was not met: NEEDS_PUSH where a pull has become negligible."""
    for i in range(packed.lines.shape[0]):
        min_pull = max(NO_PULL * load_scale(packed), packed.lines[i, WEIGHT] * states[i, FREE])
        if work.pulls[i] < min_pull:
            return NEEDS_PUSH, packed.lines[i, TENSION_MIN]
    return NOT_CONVERGED, 0.0


@jit
def keep(given, pose):
    """Write the given coordinates back to *pose*."""
    for k in range(pose.shape[0]):
        if not isnan(given[k]):
            pose[k] = given[k]


@jit
def hang(packed, given, pose, states, work):
    """Guess the free coordinates of *pose* and the pulls by descents on springs with the lengths of the pose."""
    base, m = work.base, packed.lines.shape[0]
    elastic = none_rigid(packed, work)
    for _ in range(SPRING_ROUNDS):
        keep(given, pose)
        place_platform(pose, base.rotation)
        for i in range(m):
            place(packed.lines, i, pose, base.rotation, base.arms[i], base.planes[i])
            base.lengths[i] = sqrt(base.planes[i, 2] ** 2 + base.planes[i, 3] ** 2)
        if not descend(elastic, base.lengths, pose, states, base, SPRING, SPRING_TOLERANCE, packed.freedoms):
            return False
    for i in range(m):
        plane = base.planes[i]
        stretch = sqrt(plane[2] ** 2 + plane[3] ** 2) / base.lengths[i] - 1.0
        share = 1e-2 * load_scale(packed) / m
        work.pulls[i] = max(stretch / elastic.lines[i, FREE_COMPLIANCE], share)
    keep(given, pose)
    return True


@jit
def _balance(packed, given, pose, states, work):
    """Run Newton on the platform's balance in the free coordinates and the pulls. True if it converges."""
    base, n = work.base, packed.freedoms
    load = load_scale(packed)
    if not evaluate_at_pulls(packed, pose, states, work, True):
        return False
    for _ in range(NEWTON_STEPS):
        size = largest(base.wrench, n)
        if size <= FORCE_TOLERANCE * load:
            break
        _mix(packed, given, pose, work)
        if not solve(work.mixed, base.move, n, 1):
            return False
        held = 1.0
        for k in range(n):
            held = min(held, LONGEST_STEP / max(abs(base.move[k, 0]), 1e-300))
        stalled = held == 1.0 and largest_of_column(base.move, n) < 1e-13
        for halving in range(HALVINGS):
            _step(given, pose, work, held if halving == 0 else -0.5 * held)
            if halving > 0:
                held *= 0.5
            placed = evaluate_at_pulls(packed, pose, states, work, False)
            if stalled or (placed and largest(base.wrench, n) < size):
                break
        if stalled:
            break
    if angle_of(pose) > pi:
        return False
    return evaluate_at_pulls(packed, pose, states, work, False) and balances(packed, states, work)


@jit
def _step(given, pose, work, share):
    """Take the share *share* of the step in work.base.move: free coordinates first, then the logs of the pulls."""
    move, column = work.base.move, 0
    for k in range(pose.shape[0]):
        if isnan(given[k]):
            pose[k] += share * move[column, 0]
            column += 1
    for i in range(work.pulls.shape[0]):
        work.pulls[i] *= exp(share * move[column + i, 0])


@jit
def _mix(packed, given, pose, work):
    """Set work.mixed and work.base.move to the linear system of the Newton step."""
    base, n, m = work.base, pose.shape[0], work.pulls.shape[0]
    rates_of_rotation(pose, base.rotation)
    column = 0
    for k in range(n):
        base.move[k, 0] = base.wrench[k]
        if not isnan(given[k]):
            continue
        for i in range(n):
            if k < 3:
                work.mixed[i, column] = base.stiffness[i, k]
                continue
            work.mixed[i, column] = 0.0
            for j in range(3):
                work.mixed[i, column] += base.stiffness[i, 3 + j] * base.rotation[j, k - 3]
        column += 1
    for i in range(n):
        for j in range(m):
            work.mixed[i, column + j] = -work.structure[i, j]
    add_reactions(packed, work.mixed, column + m)


@jit
def evaluate_at_pulls(packed, pose, states, work, restart):
    """Evaluate balance and stiffness at *pose* with the pulls held, and their derivatives by the log of each pull.

    *restart*: start from straight lines. False where a line has no solution.
    """
    base = work.base
    place_platform(pose, base.rotation)
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    for i in range(packed.lines.shape[0]):
        row, y, pull = packed.lines[i], states[i], work.pulls[i]
        place(packed.lines, i, pose, base.rotation, base.arms[i], base.planes[i])
        if not hang_line(row, y, pull, pose, i, restart, base, base.spatial, work.column):
            return False
        for k in range(packed.freedoms):
            work.structure[k, i] = work.column[k]
    keep_free(packed, base.wrench)
    return True
