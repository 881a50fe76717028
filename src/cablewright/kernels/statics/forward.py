"""Forward problem: from unstrained lengths to the pose, from a neighbouring solution or without any guess."""

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, copy_rows
from cablewright.kernels.layout import LEVER_UNSTABLE, MASSLESS, NOT_CONVERGED, OK, OVERSTRETCHED
from cablewright.kernels.statics.descent import EXACT, FORCE_TOLERANCE, descend, spring_guess
from cablewright.kernels.statics.equilibrium import (
    BALANCED,
    LENGTH_TOLERANCE,
    evaluate,
    grains,
    judge,
    judge_stability,
    newton_step,
    refine,
)
from cablewright.kernels.statics.line.interface import draw_line, guess_line
from cablewright.kernels.statics.line.upright import SLACK_TENSION, is_slack
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import angle_of, load_scale, place_platform, starts_of, turn_to_start

FIRST_STEP = 0.25  # of the homotopy from taut lengths to the requested ones
MIN_STEP = 1e-3
POLISHES = 4  # Newton steps that balance taut lines where a pose's digits are too few to
ROUGH = 1e-3  # of the load: unbalanced force at which Newton takes over from the descent
LEVER_PULLS = (1.0, 10.0, 100.0)  # times a line's share of the load, at which levers are placed
UPRIGHT = 0.6  # rad: a solution rotated by less than this ends the search


@jit
def solve_warm(packed, lengths, pose, states, work):
    """Solve the forward problem from the guesses *pose* and *states*, updated in place.

    Returns code, iterations, residual (m).
    """
    if packed.platform[MASSLESS] > 0.0:
        iterations, residual = 1, 0.0
        if not descend(packed, lengths, pose, states, work, EXACT, FORCE_TOLERANCE, packed.freedoms):
            return NOT_CONVERGED, iterations, residual
        if not _polish(packed, lengths, pose, states, work):
            return NOT_CONVERGED, iterations, residual
    else:
        code, iterations, residual = refine(packed, lengths, pose, states, work)
        if code != OK:
            return code, iterations, residual
    code = judge_stability(packed, states, work)
    if code == OK:
        code = judge(packed, states, work.planes, work.spatial)
    return code, iterations, residual


@jit
def _polish(packed, lengths, pose, states, work):
    """Balance the descended platform. False if it stays unbalanced. Leaves it evaluated, as `judge_stability` needs it.

    The descent solves each line at the pose. Of short, stiff lines the last digit of the pose is a force that shows in
    the balance; the lines' tensions, unknowns of their own, have digits enough.
    """
    size, grain = grains(lengths, pose)
    for step in range(POLISHES + 1):
        worst, unbalanced, scale = evaluate(packed, lengths, pose, states, work)
        if worst <= LENGTH_TOLERANCE * size + grain and unbalanced <= BALANCED * scale:
            return step == 0 or _hang_slack(packed, lengths, pose, states, work, LENGTH_TOLERANCE * size + grain)
        if step == POLISHES or not newton_step(packed, pose, states, work)[0]:
            return False
    return False


@jit
def _hang_slack(packed, lengths, pose, states, work, tolerance):
    """Draw the slack lines to where the evaluated platform is now. False if one is too short to be slack there."""
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if not is_slack(row, y):
            continue
        drawn = draw_line(row, y, pose, i, SLACK_TENSION, work, work.spatial)
        if drawn < 0.0 or drawn > lengths[i] + tolerance:
            return False
    return True


@jit
def _is_found(packed, code):
    """Whether no other start can improve on *code*.

    A rigid body may have a sound one beside an overstretched one; a point load as a rule has no other.
    """
    return code == OK or (code == OVERSTRETCHED and packed.freedoms == 3)


@jit(allocates=True)
def solve_near(packed, lengths, pose, states, work):
    """Solve the forward problem from a guessed *pose* alone; if that fails, without a guess.

    Returns as `solve_warm`.
    """
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if _is_found(packed, code):
        return code, iterations, residual
    again, more, residual = solve_cold(packed, lengths, pose, states, work)
    return again, iterations + more, residual


@jit(allocates=True)
def solve_cold(packed, lengths, pose, states, work):
    """Solve for *lengths* without a guess; *pose* and *states* are only written. Returns as `solve_warm`.

    A rigid body is tried unrotated first, then from other rotations, until the solution is rotated by less than
    UPRIGHT: of several equilibria for the same lengths the one with the smallest rotation angle is returned.
    """
    answer, total, left = NOT_CONVERGED, 0, 0.0
    min_angle = 1e300
    best, best_states = pose.copy(), states.copy()
    for start in range(starts_of(packed)):
        turn_to_start(packed, pose, start)
        code, iterations, residual = _solve_from_springs(packed, lengths, pose, states, work)
        total += iterations
        angle = angle_of(pose)
        better = angle < min_angle if code == OK and answer == OK else code == OK
        if better or start == 0 or (answer == NOT_CONVERGED and code != OK):
            answer, left, min_angle = code, residual, angle
            copy(pose, best)
            copy_rows(states, best_states)
        if answer == OK and min_angle < UPRIGHT:
            break
    copy(best, pose)
    copy_rows(best_states, states)
    return answer, total, left


@jit(allocates=True)
def _solve_from_springs(packed, lengths, pose, states, work):
    """Solve from `spring_guess` with the rotation given in *pose*. Returns as `solve_warm`.

    Where Newton fails from that guess, a homotopy pays the slack lines out step by step; where that fails too, the
    potential is descended with all lines solved at each step.
    """
    if not spring_guess(packed, lengths, pose, states, work):
        return NOT_CONVERGED, 0, 0.0
    begin = pose.copy()
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if _is_found(packed, code) or packed.platform[MASSLESS] > 0.0:
        return code, iterations, residual
    copy(begin, pose)
    code, more, residual = solve_by_homotopy(packed, lengths, pose, states, work)
    if _is_found(packed, code):
        return code, iterations + more, residual
    copy(begin, pose)
    if guess_states(packed, lengths, pose, states, work, 1.0):
        descend(packed, lengths, pose, states, work, EXACT, ROUGH, packed.freedoms)
        code, last, residual = solve_warm(packed, lengths, pose, states, work)
        more += last
    return code, iterations + more, residual


@jit(allocates=True)
def _solve_at(packed, lengths, pose, states, work):
    """Guess line states at *pose* and solve; where a lever ends unstable, guess again with a stronger pull."""
    if packed.platform[MASSLESS] > 0.0:
        return solve_warm(packed, lengths, pose, states, work)
    begin = pose.copy()
    code, total, residual = NOT_CONVERGED, 0, 0.0
    for pull in LEVER_PULLS:
        copy(begin, pose)
        if not guess_states(packed, lengths, pose, states, work, pull):
            return NOT_CONVERGED, total, residual
        code, iterations, residual = solve_warm(packed, lengths, pose, states, work)
        total += iterations
        if code != LEVER_UNSTABLE:
            break
    return code, total, residual


@jit(allocates=True)
def solve_by_homotopy(packed, lengths, pose, states, work):
    """Solve the forward problem from lengths that leave no line slack at *pose*, paying slack lines out by steps.

    Returns as `solve_warm`.
    """
    m = packed.lines.shape[0]
    taut = lengths.copy()
    for i in range(m):
        row, y = packed.lines[i], states[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], work.planes[i])
        drawn = draw_line(row, y, pose, i, load_scale(packed) / m, work, work.spatial)
        if drawn < 0.0:
            return NOT_CONVERGED, 0, 0.0
        taut[i] = min(lengths[i], drawn)
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
        copy(held, pose)
        copy_rows(held_states, states)
        step *= 0.5
        if step < MIN_STEP:
            return code, total, residual
    return OK, total, residual


@jit
def guess_states(packed, lengths, pose, states, work, pull):
    """Guess line states for *lengths* at *pose*. False if a platform point lies inside a sheave.

    Levers are placed as if each line carried *pull* times its share of the load.
    """
    share = pull * load_scale(packed) / packed.lines.shape[0]
    place_platform(pose, work.rotation)
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], work.planes[i])
        if not guess_line(row, y, pose, i, lengths[i], share, work, work.spatial):
            return False
    return True
