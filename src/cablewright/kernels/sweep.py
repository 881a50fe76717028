"""Batches: the only parallel loops. One status per row; rows of a chunk are solved in order by one thread."""

import numpy as np

from cablewright.kernels import jit, prange
from cablewright.kernels.equilibrium import NOT_CONVERGED, NOT_FINITE, OK, SINGULAR, evaluate, workspace
from cablewright.kernels.forward import solve_cold, solve_near, solve_warm
from cablewright.kernels.inverse import inverse_workspace, lengths_of, solve_inverse
from cablewright.kernels.layout import ARC_COMPLIANCE, DEAD_COMPLIANCE, FREE_COMPLIANCE, Packed
from cablewright.kernels.line import SLACK_TENSION, extremes
from cablewright.kernels.linearise import PARAMETERS, linearise

__all__ = [
    "CHAIN",
    "COLD",
    "NEAR",
    "PARAMETERS",
    "SLACK_TENSION",
    "WARM",
    "examine",
    "forward_rows",
    "forward_sweep",
    "inverse_rows",
    "inverse_sweep",
    "linearise_rows",
    "linearise_sweep",
]

CHUNK = 64  # rows per task; results do not depend on how many threads share the tasks

NO_ANSWER = (NOT_CONVERGED, SINGULAR, NOT_FINITE)
COLD, NEAR, WARM, CHAIN = 0, 1, 2, 3  # what a forward solve starts from


@jit(allocates=True)
def forward_rows(packed, lengths, factors, poses, states, codes, iterations, residuals, start, first, last):
    """Solve rows *first* to *last* of a batch of forward problems in place; see `forward_sweep`."""
    own = Packed(packed.freedoms, packed.lines.copy(), packed.platform)
    work = workspace(own)
    shift = np.zeros(packed.freedoms)
    for j in range(first, last):
        _scale_modulus(packed, factors[j], own)
        if start == COLD:
            result = solve_cold(own, lengths[j], poses[j], states[j], work)
        elif start == WARM:
            result = solve_warm(own, lengths[j], poses[j], states[j], work)
        elif start == NEAR or j == first or codes[j - 1] != OK:
            shift[:] = poses[j]
            result = solve_near(own, lengths[j], poses[j], states[j], work)
            shift[:] = poses[j] - shift
        else:
            result = _follow(own, lengths[j], poses[j], states[j], states[j - 1], shift, work)
        codes[j], iterations[j], residuals[j] = result
        if codes[j] in NO_ANSWER:
            poses[j], states[j] = np.nan, np.nan


@jit(allocates=True)
def _follow(packed, lengths, pose, states, neighbour, shift, work):
    """Solve near *pose* plus the neighbour's *shift*, from the neighbour's line states; else from the pose alone."""
    begin = pose.copy()
    pose += shift
    states[:, :] = neighbour
    result = solve_warm(packed, lengths, pose, states, work)
    if result[0] != OK:
        pose[:] = begin
        result = solve_near(packed, lengths, pose, states, work)
    shift[:] = pose - begin
    return result


@jit
def _scale_modulus(packed, factors, out):
    for i in range(packed.lines.shape[0]):
        for k in (FREE_COMPLIANCE, DEAD_COMPLIANCE, ARC_COMPLIANCE):
            out.lines[i, k] = packed.lines[i, k] / factors[i]


@jit(parallel=True)
def forward_sweep(packed, lengths, factors, poses, states, codes, iterations, residuals, start):
    """A batch of forward problems, in place.

    lengths (N, m); factors (N, m) on each line's modulus; poses (N, n) and states (N, m, 6)
    hold the guesses that *start* speaks of (COLD none, NEAR poses, WARM poses and states, CHAIN poses and the
    row before) and receive the solutions; codes, iterations, residuals (N,) are written.
    """
    rows = lengths.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        last = min(rows, first + CHUNK)
        forward_rows(packed, lengths, factors, poses, states, codes, iterations, residuals, start, first, last)


@jit(allocates=True)
def inverse_rows(packed, poses, states, lengths, codes, violations, chain, first, last):
    """Solve rows *first* to *last* of a batch of inverse problems in place; see `inverse_sweep`."""
    work = inverse_workspace(packed)
    for j in range(first, last):
        known = chain and j > first and codes[j - 1] == OK
        if known:
            states[j] = states[j - 1]
        codes[j], violations[j] = solve_inverse(packed, poses[j], states[j], work, known)
        if known and codes[j] != OK:
            codes[j], violations[j] = solve_inverse(packed, poses[j], states[j], work, False)
        lengths_of(packed, states[j], lengths[j])


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
def linearise_rows(packed, lengths, factors, poses, states, stiffness, motion, codes, first, last):
    """Linearise rows *first* to *last*; see `linearise_sweep`."""
    own = Packed(packed.freedoms, packed.lines.copy(), packed.platform)
    work = workspace(own)
    for j in range(first, last):
        _scale_modulus(packed, factors[j], own)
        codes[j] = linearise(own, lengths[j], poses[j], states[j], work, stiffness[j], motion[j])


@jit(parallel=True)
def linearise_sweep(packed, lengths, factors, poses, states, stiffness, motion, codes):
    """Tangent stiffness (N, n, n) and motion (N, n, m, 5) at solved equilibria; see `linearise.linearise`."""
    rows = lengths.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        last = min(rows, first + CHUNK)
        linearise_rows(packed, lengths, factors, poses, states, stiffness, motion, codes, first, last)


@jit(allocates=True)
def examine(packed, lengths, factors, poses, states, residuals, unbalanced, low, high):
    """What is left of each row's equations, and the extremes of tension along its lines.

    Writes the largest geometric residual (m) and unbalanced force (N) of each row (N,), and the smallest and
    largest tension along each line, N: low and high (N, m).
    """
    own = Packed(packed.freedoms, packed.lines.copy(), packed.platform)
    work = workspace(own)
    for j in range(states.shape[0]):
        _scale_modulus(packed, factors[j], own)
        residuals[j], unbalanced[j], _ = evaluate(own, lengths[j], poses[j], states[j], work)
        for i in range(states.shape[1]):
            low[j, i], high[j, i] = extremes(packed.lines[i], states[j, i])
