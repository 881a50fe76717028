"""Forward problem: unstrained lengths to the pose, warm from a neighbour or cold from nothing."""

from cablewright.kernels import jit
from cablewright.kernels.descent import FORCE_TOLERANCE, SETTLED, descend, spring_guess
from cablewright.kernels.equilibrium import LEVER_UNSTABLE, NOT_CONVERGED, OK, OVERSTRETCHED, judge, refine
from cablewright.kernels.layout import MASSLESS, PLATFORM_WEIGHT
from cablewright.kernels.line import guess
from cablewright.kernels.rotation import matrix
from cablewright.kernels.sheave import straight, whole_length
from cablewright.kernels.wrench import place

FIRST_STEP = 0.25  # of the way from taut lengths to the wanted ones
LAST_STEP = 1e-3
ROUGH = 1e-3  # of the weight: where the descent hands over to Newton
LEVER_PULLS = (1.0, 10.0, 100.0)  # times a line's share of the weight, to place levers with
FOUND = (OK, OVERSTRETCHED)  # an equilibrium that no other start would change


@jit
def solve_warm(packed, lengths, pose, states, work):
    """Solve from *pose* and *states* (improved in place). Returns code, iterations, residual (m)."""
    if packed.platform[MASSLESS] > 0.0:
        arrived = descend(packed, lengths, pose, states, work, SETTLED, FORCE_TOLERANCE)
        return (judge(packed, states, work.planes) if arrived else NOT_CONVERGED), 1, 0.0
    code, iterations, residual = refine(packed, lengths, pose, states, work)
    if code == OK:
        code = judge(packed, states, work.planes)
    return code, iterations, residual


@jit(allocates=True)
def solve_near(packed, lengths, pose, states, work):
    """Solve from *pose* alone: line states are guessed there; on failure cold. As `solve_warm`."""
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if code in FOUND:
        return code, iterations, residual
    again, more, residual = solve_cold(packed, lengths, pose, states, work)
    return again, iterations + more, residual


@jit(allocates=True)
def solve_cold(packed, lengths, pose, states, work):
    """Solve for *lengths* without a guess; *pose* and *states* are only written. As `solve_warm`.

    Springs place the platform; where Newton fails from there the slack lines are let out step by step, and where
    that fails too the platform walks downhill with all lines settled at each step.
    """
    if not spring_guess(packed, lengths, pose, states, work):
        return NOT_CONVERGED, 0, 0.0
    begin = pose.copy()
    code, iterations, residual = _solve_at(packed, lengths, pose, states, work)
    if code in FOUND or packed.platform[MASSLESS] > 0.0:
        return code, iterations, residual
    pose[:] = begin
    code, more, residual = solve_by_homotopy(packed, lengths, pose, states, work)
    if code in FOUND:
        return code, iterations + more, residual
    pose[:] = begin
    if guess_states(packed, lengths, pose, states, work, 1.0):
        descend(packed, lengths, pose, states, work, SETTLED, ROUGH)
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
