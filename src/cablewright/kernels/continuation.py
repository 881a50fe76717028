"""Following one equilibrium as lengths change: what a control loop calls every few milliseconds."""

from math import exp, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.krawczyk import CERTIFIED, certify
from cablewright.kernels.certificates.system_enclosure import unfold
from cablewright.kernels.layout import DEAD, PSI, TAU, UNKNOWNS, WEIGHT
from cablewright.kernels.newton import largest, least_pivot
from cablewright.kernels.rotation import between
from cablewright.kernels.statics.equilibrium import (
    FOLD,
    JUMPED,
    NOT_CONVERGED,
    OK,
    SINGULAR,
    UNCERTIFIED,
    condense,
    evaluate,
    judge,
    judge_pivot,
    newton_step,
    refine,
)

SUBSTEPS = (1, 4, 16, 64)  # parts that a step is cut into where a single one strays


@jit(allocates=True)
def follow(packed, before, lengths, pose, states, jump, fold, tolerance, work, pool):
    """Follow the equilibrium in *pose* and *states* from lengths *before* to *lengths*; both are improved in place.

    Each part of the way goes by the linearisation and then Newton. Where that ends farther than *jump* (m, rad) from
    what the linearisation said, or a dead span falls into a loop or out of one, the part is cut; JUMPED if none is
    small enough, or Newton leads nowhere. FOLD where the least pivot of the stiffness, as a share of its largest, is
    under *fold*. With a *tolerance* over 0 the end is certified to it, else UNCERTIFIED. Returns code and least pivot.
    """
    start, shape = pose.copy(), states.copy()
    between = np.empty_like(lengths)
    code = JUMPED
    for parts in SUBSTEPS:
        pose[:], states[:, :] = start, shape
        for part in range(1, parts + 1):
            for i in range(lengths.shape[0]):
                between[i] = before[i] + (lengths[i] - before[i]) * part / parts
            code = _step(packed, lengths if part == parts else between, pose, states, jump, work)
            if code != OK:
                break
        if code == OK:
            break
    if code != OK:
        return (JUMPED if code == NOT_CONVERGED else code), 0.0
    if not condense(packed, states, work):
        return SINGULAR, 0.0
    pivot = least_pivot(work.stiffness, packed.freedoms)
    code = judge_pivot(pivot)
    if code == OK:
        code = judge(packed, states, work.planes)
    if code == OK and pivot < fold:
        code = FOLD
    if (
        code == OK
        and tolerance > 0.0
        and certify(packed, lengths, pose, states, tolerance, unfold(packed, pool)) != CERTIFIED
    ):
        code = UNCERTIFIED
    return code, pivot


@jit(allocates=True)
def _step(packed, lengths, pose, states, jump, work):
    """One part of the way. Leaves the equilibrium evaluated."""
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
    strayed = largest(shift, packed.freedoms) > jump or _fell(packed, shapes, states, jump)
    return JUMPED if strayed else OK


@jit
def _fell(packed, before, after, jump):
    """Whether a dead span began or ceased to dip below its ends, and changed by more than *jump* (m) in length.

    A slack line may hang with its dead span taut or in a loop: two equilibria, micrometres apart in pose.
    """
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        far = row[UNKNOWNS] > 3.0 and abs(after[i, DEAD] - before[i, DEAD]) > jump
        if far and _dips(row, before[i]) != _dips(row, after[i]):
            return True
    return False


@jit
def _dips(row, y):
    """Whether the dead span is lower somewhere than at both its ends."""
    v = exp(y[TAU]) * sin(y[PSI])
    return v * (v + row[WEIGHT] * y[DEAD]) < 0.0
