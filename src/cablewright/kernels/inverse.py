"""Inverse problem: pose to unstrained lengths and tensions, under tension limits.

With sag a line's end force is not proportional to its tension, so the distribution is a sequence of quadratic
programs on the lines linearised at their present tensions; with straight cables the first is already exact.
"""

from math import exp, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.equilibrium import BAD_WRAP, NOT_CONVERGED, OK, OVERSTRETCHED, UNDER_EXIT, Work, workspace
from cablewright.kernels.layout import (
    BREAKING,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    PLATFORM_WEIGHT,
    TAU,
    TENSION_MAX,
    TENSION_MIN,
    WEIGHT,
    Code,
)
from cablewright.kernels.line import extremes, force_change, length_of, settle_at_tension, start_force
from cablewright.kernels.rotation import matrix
from cablewright.kernels.sheave import straight, unstrain, wrap
from cablewright.kernels.tension import SOFT, least_norm
from cablewright.kernels.wrench import add_force, place, start_balance

PROGRAMS = 40
TENSION_TOLERANCE = 1e-11  # of the largest tension
INFEASIBLE = int(Code.INFEASIBLE)
INSIDE_SHEAVE = int(Code.INSIDE_SHEAVE)
UNDERCONSTRAINED = int(Code.UNDERCONSTRAINED)


class InverseWork(NamedTuple):
    """Scratch of the inverse problem beside that of the equilibrium."""

    base: Work
    structure: NDArray[np.float64]  # (n, m): wrench per tension at the sheave, reversed
    load: NDArray[np.float64]  # (n,)
    low: NDArray[np.float64]  # (m,): limits on the tension at the sheave
    high: NDArray[np.float64]
    wanted: NDArray[np.float64]  # (m,)
    multipliers: NDArray[np.float64]  # (n,)
    column: NDArray[np.float64]  # (n,)


@jit
def inverse_workspace(packed):
    """Scratch that fits *packed*."""
    m, n = packed.lines.shape[0], packed.freedoms
    return InverseWork(
        workspace(packed), np.zeros((n, m)), np.zeros(n), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(n), np.zeros(n)
    )


@jit
def solve_inverse(packed, pose, states, work, known):
    """Least-norm tensions and line states at *pose*; *known* says that *states* hold a neighbour's solution.

    Returns code and the largest violation of a tension limit (N, 0 where feasible). Where limits cannot be met
    *states* hold the distribution that violates them least.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    if m < n:
        return UNDERCONSTRAINED, 0.0
    code = _begin(packed, pose, states, work.base, known)
    if code != OK:
        return code, 0.0
    if not known:
        work.multipliers[:] = 0.0
    give = 0.0
    for _ in range(PROGRAMS):
        code, change = _program(packed, states, work, give)
        if code == INFEASIBLE:
            if give > 0.0:
                return INFEASIBLE, 0.0
            give = SOFT
            work.multipliers[:] = 0.0
            continue
        if code != OK:
            return code, 0.0
        if change < TENSION_TOLERANCE:
            return _verdict(packed, states, work, give)
    return NOT_CONVERGED, 0.0


@jit
def _begin(packed, pose, states, base, known):
    """Place all lines; without known states start from straight lines at a fair share of the load."""
    share = packed.platform[PLATFORM_WEIGHT] / packed.lines.shape[0]
    if packed.freedoms == 6:
        matrix(pose[3:], base.rotation)
    for i in range(packed.lines.shape[0]):
        row, y, plane = packed.lines[i], states[i], base.planes[i]
        place(packed.lines, i, pose, base.rotation, base.arms[i], plane)
        if plane[2] <= 1e-9:
            return UNDER_EXIT
        if not known:
            if not straight(row, plane[2], plane[3], max(share, row[TENSION_MIN], 1.0), y):
                return INSIDE_SHEAVE
            unstrain(row, y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
    return OK


@jit
def _program(packed, states, work, give):
    """Settle the lines at their tensions, linearise, distribute. Returns code and the relative change."""
    m, n = packed.lines.shape[0], packed.freedoms
    base = work.base
    start_balance(packed, base.rotation, base.wrench, base.stiffness)
    for k in range(n):
        work.load[k] = base.wrench[k]
    largest = 0.0
    for i in range(m):
        row, y, plane, steps = packed.lines[i], states[i], base.planes[i], base.steps[i]
        if not settle_at_tension(row, plane[2], plane[3], y, base.blocks[i], steps):
            return NOT_CONVERGED, 0.0
        tension = exp(y[TAU])
        largest = max(largest, tension)
        h, v = start_force(y)
        dh, dv = force_change(h, v, row[WEIGHT], steps[:, 1])
        v += row[WEIGHT] * y[FREE]
        dh, dv = dh / tension, dv / tension
        work.column[:] = 0.0
        add_force(base.arms[i], dh * plane[0], dh * plane[1], dv, work.column)
        for k in range(n):
            work.structure[k, i] = work.column[k]
        # the part of the end force that is not proportional to the tension belongs to the load
        h, v = h - dh * tension, v - dv * tension
        add_force(base.arms[i], -h * plane[0], -h * plane[1], -v, work.load)
        least, most = extremes(row, y)
        work.low[i] = row[TENSION_MIN] + tension - least
        work.high[i] = row[TENSION_MAX] + tension - most
    solved = least_norm(
        work.structure, work.load, work.low, work.high, give, work.wanted, work.multipliers, base.stiffness, base.move
    )
    if solved <= 0:
        return (INFEASIBLE if solved == 0 else NOT_CONVERGED), 0.0
    change = 0.0
    for i in range(m):
        tension = exp(states[i, TAU])
        wanted = max(work.wanted[i], 0.2 * tension)  # a softened limit may ask for less than nothing
        change = max(change, abs(wanted - tension) / largest)
        states[i, TAU] = log(wanted)
    return OK, change


@jit
def _verdict(packed, states, work, give):
    """Code and largest violation of a tension limit (N) of the settled lines."""
    violation = 0.0
    code = OK
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        least, most = extremes(row, y)
        violation = max(violation, row[TENSION_MIN] - least, most - row[TENSION_MAX])
        angle = wrap(row, y)
        if angle < 0.0 or angle > 6.283185307179586:
            code = BAD_WRAP
        elif most > row[BREAKING]:
            code = OVERSTRETCHED
    return (INFEASIBLE if give > 0.0 else code), violation


@jit
def lengths_of(packed, states, out):
    """Unstrained lengths of all lines, m."""
    for i in range(packed.lines.shape[0]):
        out[i] = length_of(packed.lines[i], states[i])
