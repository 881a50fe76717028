"""Forward problem: unstrained lengths to the pose, warm from a neighbour or cold from nothing."""

from math import pi

from cablewright.kernels import jit
from cablewright.kernels.layout import MASSLESS, PLATFORM_WEIGHT
from cablewright.kernels.rotation import angle_of, matrix
from cablewright.kernels.statics.descent import FORCE_TOLERANCE, SETTLED, descend, spring_guess
from cablewright.kernels.statics.equilibrium import (
    LEVER_UNSTABLE,
    NOT_CONVERGED,
    OK,
    OVERSTRETCHED,
    evaluate,
    judge,
    judge_stability,
    refine,
)
from cablewright.kernels.statics.line import guess
from cablewright.kernels.statics.sheave import straight, whole_length
from cablewright.kernels.statics.wrench import place

FIRST_STEP = 0.25  # of the way from taut lengths to the wanted ones
LAST_STEP = 1e-3
ROUGH = 1e-3  # of the weight: where the descent hands over to Newton
LEVER_PULLS = (1.0, 10.0, 100.0)  # times a line's share of the weight, to place levers with
STARTS = 10  # rotations that a rigid body is tried from
UPRIGHT = 0.6  # rad: a body found less turned than this needs no other start


@jit
def solve_warm(packed, lengths, pose, states, work):
    """Solve from *pose* and *states* (improved in place). Returns code, iterations, residual (m)."""
    if packed.platform[MASSLESS] > 0.0:
        iterations, residual = 1, 0.0
        if not descend(packed, lengths, pose, states, work, SETTLED, FORCE_TOLERANCE, packed.freedoms):
            return NOT_CONVERGED, iterations, residual
        evaluate(packed, lengths, pose, states, work)  # for the stability
    else:
        code, iterations, residual = refine(packed, lengths, pose, states, work)
        if code != OK:
            return code, iterations, residual
    code = judge_stability(packed, states, work)
    if code == OK:
        code = judge(packed, states, work.planes)
    return code, iterations, residual


@jit
def _is_found(packed, code):
    """Whether this is an answer that no other start would change.

    A point load has no equilibrium but the overstretched one; a rigid body may have a sound one elsewhere.
    """
    return code == OK or (code == OVERSTRETCHED and packed.freedoms == 3)


@jit(allocates=True)
def solve_near(packed, lengths, pose, states, work):
    """Solve from *pose* alone: line states are guessed there; on failure cold. As `solve_warm`."""
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if _is_found(packed, code):
        return code, iterations, residual
    again, more, residual = solve_cold(packed, lengths, pose, states, work)
    return again, iterations + more, residual


@jit(allocates=True)
def solve_cold(packed, lengths, pose, states, work):
    """Solve for *lengths* without a guess; *pose* and *states* are only written. As `solve_warm`.

    A rigid body is tried unrotated first, then from other rotations, until it is found less than UPRIGHT turned: of
    several equilibria for the same lengths the least turned one is taken.
    """
    if packed.freedoms == 3:
        return _solve_from_springs(packed, lengths, pose, states, work)
    answer, total, left = NOT_CONVERGED, 0, 0.0
    least = 1e300
    best, best_states = pose.copy(), states.copy()
    for start in range(STARTS):
        turn_to_start(pose, start)
        code, iterations, residual = _solve_from_springs(packed, lengths, pose, states, work)
        total += iterations
        turned = angle_of(pose)
        better = turned < least if code == OK and answer == OK else code == OK
        if better or start == 0 or (answer == NOT_CONVERGED and code != OK):
            answer, left, least = code, residual, turned
            best[:], best_states[:] = pose, states
        if answer == OK and least < UPRIGHT:
            break
    pose[:], states[:] = best, best_states
    return answer, total, left


@jit
def turn_to_start(pose, start):
    """Set the rotation that start number *start* begins from: upright, leaning to four sides, then turned about z."""
    pose[3:] = 0.0
    if 1 <= start <= 4:
        pose[3 + (start - 1) // 2] = 0.6 if start % 2 else -0.6
    elif start >= 5:
        pose[5] = pi * (0.25, -0.25, 0.5, -0.5, 1.0)[start - 5]


@jit(allocates=True)
def _solve_from_springs(packed, lengths, pose, states, work):
    """Solve from springs that begin with the rotation in *pose*. As `solve_warm`.

    Springs place the platform; where Newton fails from there the slack lines are let out step by step, and where
    that fails too the platform walks downhill with all lines settled at each step.
    """
    if not spring_guess(packed, lengths, pose, states, work):
        return NOT_CONVERGED, 0, 0.0
    begin = pose.copy()
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if _is_found(packed, code) or packed.platform[MASSLESS] > 0.0:
        return code, iterations, residual
    pose[:] = begin
    code, more, residual = solve_by_homotopy(packed, lengths, pose, states, work)
    if _is_found(packed, code):
        return code, iterations + more, residual
    pose[:] = begin
    if guess_states(packed, lengths, pose, states, work, 1.0):
        descend(packed, lengths, pose, states, work, SETTLED, ROUGH, packed.freedoms)
        code, last, residual = solve_warm(packed, lengths, pose, states, work)
        more += last
    return code, iterations + more, residual


@jit(allocates=True)
def _solve_at(packed, lengths, pose, states, work):
    """Guess the line states at *pose* and solve; where a lever ends on its head, guess it pulled harder."""
    if packed.platform[MASSLESS] > 0.0:
        return solve_warm(packed, lengths, pose, states, work)
    begin = pose.copy()
    total, residual = 0, 0.0
    code = NOT_CONVERGED
    for pull in LEVER_PULLS:
        pose[:] = begin
        if not guess_states(packed, lengths, pose, states, work, pull):
            return NOT_CONVERGED, total, residual
        code, iterations, residual = solve_warm(packed, lengths, pose, states, work)
        total += iterations
        if code != LEVER_UNSTABLE:
            break
    return code, total, residual


@jit(allocates=True)
def solve_by_homotopy(packed, lengths, pose, states, work):
    """From lengths that leave no line slack at *pose*, let the slack lines out step by step. As `solve_warm`."""
    m = packed.lines.shape[0]
    taut = lengths.copy()
    for i in range(m):
        row, y, plane = packed.lines[i], states[i], work.planes[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], plane)
        if not straight(row, plane[2], plane[3], packed.platform[PLATFORM_WEIGHT] / m, y):
            return NOT_CONVERGED, 0, 0.0
        taut[i] = min(lengths[i], whole_length(row, y))
    if not guess_states(packed, taut, pose, states, work, 1.0):
        return NOT_CONVERGED, 0, 0.0
    code, total, residual = solve_warm(packed, taut, pose, states, work)
    if code != OK:
        return code, total, residual
    done, step = 0.0, FIRST_STEP
    while done < 1.0:
        held, held_states = pose.copy(), states.copy()
        share = min(1.0, done + step)
        for i in range(m):
            work.lengths[i] = taut[i] + share * (lengths[i] - taut[i])
        code, iterations, residual = solve_warm(packed, work.lengths, pose, states, work)
        total += iterations
        if code == OK:
            done = share
            step *= 2.0
            continue
        pose[:], states[:] = held, held_states
        step *= 0.5
        if step < LAST_STEP:
            return code, total, residual
    return OK, total, residual


@jit
def guess_states(packed, lengths, pose, states, work, pull):
    """Line states near those of *lengths* at *pose*. False if a platform point lies inside a sheave.

    Levers are placed as if each line bore *pull* times its share of the platform's weight.
    """
    share = pull * packed.platform[PLATFORM_WEIGHT] / packed.lines.shape[0]
    if packed.freedoms == 6:
        matrix(pose[3:], work.rotation)
    for i in range(packed.lines.shape[0]):
        plane = work.planes[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], plane)
        if not guess(packed.lines[i], plane[2], plane[3], lengths[i], share, states[i]):
            return False
    return True
