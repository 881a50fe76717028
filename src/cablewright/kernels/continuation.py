"""Continuation of one equilibrium as cable lengths change, as a control loop calls it every few milliseconds."""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.krawczyk import CERTIFIED, certify
from cablewright.kernels.certificates.system_enclosure import unfold
from cablewright.kernels.dense_systems import copy, copy_rows, largest, min_pivot
from cablewright.kernels.layout import DEAD, FOLD, JUMPED, NOT_CONVERGED, OK, SINGULAR
from cablewright.kernels.statics.equilibrium import condense, evaluate, judge, judge_pivot, newton_step, refine
from cablewright.kernels.statics.line.interface import dips_line
from cablewright.kernels.statics.platform import between

SUBSTEPS = (1, 4, 16, 64)  # numbers of parts that the change of lengths is divided into, tried in turn


@jit(allocates=True)
def follow(packed, before, lengths, pose, states, jump, fold, work):
    """Follow the equilibrium in *pose* and *states*, updated in place, as lengths change from *before* to *lengths*.

    Each part of the change is predicted by the linearisation and corrected by Newton. Where the result is farther than
    *jump* (m, rad) from the prediction, or a dead span begins or ceases to hang in a loop, the change is divided into
    more parts. Codes: JUMPED if no part is small enough or Newton does not converge; FOLD if the smallest pivot of the
    stiffness, as a share of its largest entry, is under *fold*. Returns the code and the smallest pivot.
    """
    start, shape = pose.copy(), states.copy()
    part_lengths = np.empty_like(lengths)
    code = JUMPED
    for parts in SUBSTEPS:
        copy(start, pose)
        copy_rows(shape, states)
        for part in range(1, parts + 1):
            for i in range(lengths.shape[0]):
                part_lengths[i] = before[i] + (lengths[i] - before[i]) * part / parts
            code = _step(packed, lengths if part == parts else part_lengths, pose, states, jump, work)
            if code != OK:
                break
        if code == OK:
            break
    if code != OK:
        return (JUMPED if code == NOT_CONVERGED else code), 0.0
    if not condense(packed, states, work):
        return SINGULAR, 0.0
    pivot = min_pivot(work.stiffness, packed.freedoms)
    code = judge_pivot(pivot)
    if code == OK:
        code = judge(packed, states, work.planes, work.spatial)
    if code == OK and pivot < fold:
        code = FOLD
    return code, pivot


@jit(allocates=True)
def is_certified(packed, lengths, pose, states, tolerance, pool):
    """Return whether interval arithmetic certifies the equilibrium in *pose* and *states* to *tolerance*, m and rad.

    It is separate from `follow`, so that certificates are compiled only for callers that need them.
    """
    return certify(packed, lengths, pose, states, tolerance, unfold(packed, pool)) == CERTIFIED


@jit(allocates=True)
def _step(packed, lengths, pose, states, jump, work):
    """Follow one part of the change, and leave the equilibrium evaluated in *work*. Returns a code."""
    shapes = states.copy()
    evaluate(packed, lengths, pose, states, work)
    possible, _, _ = newton_step(packed, pose, states, work)
    if not possible:
        return SINGULAR
    expected, shift = pose.copy(), np.empty_like(pose)
    code, _, _ = refine(packed, lengths, pose, states, work)
    if code != OK:
        return code
    between(expected, pose, shift)
    jumped = largest(shift, packed.freedoms) > jump or _has_changed_loop(packed, shapes, states, jump)
    return JUMPED if jumped else OK


@jit
def _has_changed_loop(packed, before, after, jump):
    """Whether a dead span began or ceased to dip below its ends, and its length changed by more than *jump* (m).

    The dead span of a slack line may be taut or hang in a loop: two equilibria whose poses are micrometres apart.
    """
    for i in range(packed.lines.shape[0]):
        row, far = packed.lines[i], abs(after[i, DEAD] - before[i, DEAD]) > jump
        if far and dips_line(row, before[i]) != dips_line(row, after[i]):
            return True
    return False
