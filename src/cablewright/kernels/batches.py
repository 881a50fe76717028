"""Batches: the only parallel loops. One status per row; rows of a chunk are solved in order by one thread."""

import numpy as np

from cablewright.kernels import jit, prange
from cablewright.kernels.certificates.krawczyk import certify, levers
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.kernels.layout import Packed
from cablewright.kernels.newton import largest
from cablewright.kernels.rotation import between, compose
from cablewright.kernels.statics.equilibrium import NOT_CONVERGED, NOT_FINITE, OK, SINGULAR, evaluate, workspace
from cablewright.kernels.statics.forward import solve_cold, solve_near, solve_warm
from cablewright.kernels.statics.inverse import inverse_workspace, lengths_of, solve_inverse
from cablewright.kernels.statics.lever_starts import start_at
from cablewright.kernels.statics.line import extremes
from cablewright.kernels.statics.linearise import linearise, tension_changes
from cablewright.kernels.statics.underactuated import solve_hanging

CHUNK = 64  # rows per task; results do not depend on how many threads share the tasks

ASTRAY = 0.05  # m, rad: neighbours on a path go nearly the same way

NO_ANSWER = (NOT_CONVERGED, SINGULAR, NOT_FINITE)
COLD, NEAR, WARM, CHAIN = 0, 1, 2, 3  # what a forward solve starts from


@jit(allocates=True)
def _one(packed, j):
    """The robot of problem *j*."""
    row = j if packed.lines.shape[0] > 1 else 0
    return Packed(packed.freedoms, packed.lines[row], packed.platform[row])


@jit(allocates=True)
def forward_rows(packed, lengths, poses, states, codes, iterations, residuals, start, first, last):
    """Solve rows *first* to *last* of a batch of forward problems in place; see `forward_sweep`."""
    work = workspace(_one(packed, first))
    guess = np.zeros(packed.freedoms)
    shift = np.zeros(packed.freedoms)
    for j in range(first, last):
        own = _one(packed, j)
        if start == COLD:
            result = solve_cold(own, lengths[j], poses[j], states[j], work)
        elif start == WARM:
            result = solve_warm(own, lengths[j], poses[j], states[j], work)
        elif start == NEAR or j == first or codes[j - 1] != OK:
            guess[:] = poses[j]
            result = solve_near(own, lengths[j], poses[j], states[j], work)
            between(guess, poses[j], shift)
        else:
            guess[:] = poses[j]
            result = _follow(own, lengths[j], poses[j], states[j], states[j - 1], shift, work)
            between(guess, poses[j], shift)
        codes[j], iterations[j], residuals[j] = result
        if codes[j] in NO_ANSWER:
            poses[j], states[j] = np.nan, np.nan


@jit(allocates=True)
def _follow(packed, lengths, pose, states, neighbour, shift, work):
    """Solve near *pose* plus the neighbour's *shift*, from the neighbour's line states; else from the pose alone.

    Of several equilibria that a rigid body has, line states of another place may lead to one far away.
    """
    begin = pose.copy()
    _shifted(pose, shift)
    expected, moved = pose.copy(), np.zeros(packed.freedoms)
    states[:, :] = neighbour
    result = solve_warm(packed, lengths, pose, states, work)
    between(expected, pose, moved)
    if result[0] != OK or (packed.freedoms == 6 and largest(moved, 6) > ASTRAY):
        pose[:] = begin
        result = solve_near(packed, lengths, pose, states, work)
    return result


@jit
def _shifted(pose, shift):
    """Move *pose* by *shift*."""
    for k in range(3):
        pose[k] += shift[k]
    if pose.shape[0] == 6:
        compose(shift[3], shift[4], shift[5], pose[3:])


@jit(parallel=True)
def forward_sweep(packed, lengths, poses, states, codes, iterations, residuals, start):
    """A batch of forward problems, in place.

    *packed* has one row or N; lengths (N, m). poses (N, n) and states (N, m, 6) hold the guesses that *start* speaks
    of (COLD none, NEAR poses, WARM poses and states, CHAIN poses and the row before) and receive the solutions; codes,
    iterations, residuals (N,) are written.
    """
    rows = lengths.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        last = min(rows, first + CHUNK)
        forward_rows(packed, lengths, poses, states, codes, iterations, residuals, start, first, last)


@jit(allocates=True)
def inverse_rows(packed, poses, states, lengths, codes, violations, chain, first, last):
    """Solve rows *first* to *last* of a batch of inverse problems in place; see `inverse_sweep`."""
    work = inverse_workspace(_one(packed, first))
    for j in range(first, last):
        own = _one(packed, j)
        known = chain and j > first and codes[j - 1] == OK
        if known:
            states[j] = states[j - 1]
        codes[j], violations[j] = solve_inverse(own, poses[j], states[j], work, known)
        if known and codes[j] != OK:
            codes[j], violations[j] = solve_inverse(own, poses[j], states[j], work, False)
        lengths_of(own, states[j], lengths[j])


@jit(parallel=True)
def inverse_sweep(packed, poses, states, lengths, codes, violations, chain):
    """A batch of inverse problems: poses (N, n) to states (N, m, 6), lengths (N, m), codes and violations (N,).

    *chain* says that neighbouring rows are neighbours on a path.
    """
    rows = poses.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        inverse_rows(packed, poses, states, lengths, codes, violations, chain, first, min(rows, first + CHUNK))


@jit(allocates=True)
def hanging_rows(packed, poses, states, lengths, codes, violations, first, last):
    """Solve rows *first* to *last* of inverse problems with fewer lines than freedoms; see `hanging_sweep`."""
    work = inverse_workspace(_one(packed, first))
    for j in range(first, last):
        own = _one(packed, j)
        codes[j], violations[j] = solve_hanging(own, poses[j], states[j], work)
        lengths_of(own, states[j], lengths[j])


@jit(parallel=True)
def hanging_sweep(packed, poses, states, lengths, codes, violations):
    """As `inverse_sweep`, with fewer lines than freedoms: what is free in a pose is NaN, and is written."""
    rows = poses.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        hanging_rows(packed, poses, states, lengths, codes, violations, first, min(rows, first + CHUNK))


@jit(allocates=True)
def linearise_rows(packed, lengths, poses, states, stiffness, motion, codes, first, last):
    """Linearise rows *first* to *last*; see `linearise_sweep`."""
    work = workspace(_one(packed, first))
    for j in range(first, last):
        codes[j] = linearise(_one(packed, j), lengths[j], poses[j], states[j], work, stiffness[j], motion[j])


@jit(parallel=True)
def linearise_sweep(packed, lengths, poses, states, stiffness, motion, codes):
    """Tangent stiffness (N, n, n) and motion (N, n, m, 5) at solved equilibria; see `linearise.linearise`."""
    rows = lengths.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        linearise_rows(packed, lengths, poses, states, stiffness, motion, codes, first, min(rows, first + CHUNK))


@jit(allocates=True)
def tension_rows(packed, lengths, poses, states, own, by_point, codes):
    """Changes (N, m, 10) and (N, m, 3) of tensions at solved equilibria; see `linearise.tension_changes`."""
    work = workspace(_one(packed, 0))
    for j in range(lengths.shape[0]):
        codes[j] = tension_changes(_one(packed, j), lengths[j], poses[j], states[j], work, own[j], by_point[j])


@jit(allocates=True)
def start_rows(packed, lengths, poses, heads, pull, states, started):
    """Line states (N, m, 6) to start from at *poses*, levers of *heads* (N, m) on their head; see `start_at`."""
    work = workspace(_one(packed, 0))
    for j in range(lengths.shape[0]):
        started[j] = start_at(_one(packed, j), lengths[j], poses[j], heads[j], pull, states[j], work)


@jit(allocates=True)
def certify_rows(packed, lengths, poses, states, tolerance, codes, bounds, boxes, signs, first, last):
    """Certify rows *first* to *last*; see `certify_sweep`."""
    own = _one(packed, first)
    work = unfold(own, certificate_pool(own))
    at = work.offsets[-1]
    for j in range(first, last):
        own = _one(packed, j)
        codes[j] = certify(own, lengths[j], poses[j], states[j], tolerance, work)
        signs[j] = levers(own, work)
        bounds[j] = work.bound[at:]
        boxes[j] = work.radius[at:]


@jit(parallel=True)
def certify_sweep(packed, lengths, poses, states, tolerance, codes, bounds, boxes, signs):
    """Certificates of solved rows: codes and signs of levers (N,), bound and box of the pose (N, n).

    *tolerance* (m, rad) is how near the pose has to be. See `certify.certify`.
    """
    rows = lengths.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        last = min(rows, first + CHUNK)
        certify_rows(packed, lengths, poses, states, tolerance, codes, bounds, boxes, signs, first, last)


@jit(allocates=True)
def examine(packed, lengths, poses, states, residuals, unbalanced, low, high):
    """What is left of each row's equations, and the extremes of tension along its lines.

    Writes the largest geometric residual (m) and unbalanced force (N) of each row (N,), and the smallest and
    largest tension along each line, N: low and high (N, m).
    """
    work = workspace(_one(packed, 0))
    for j in range(states.shape[0]):
        own = _one(packed, j)
        residuals[j], unbalanced[j], _ = evaluate(own, lengths[j], poses[j], states[j], work)
        for i in range(states.shape[1]):
            low[j, i], high[j, i] = extremes(own.lines[i], states[j, i])
