"""Tension distribution: the least-norm tensions that balance a wrench within limits, for any m and any rank.

min sum 1/2 h t^2 - g t subject to A t = b, low <= t <= high (least norm: h = 1, g = 0) has the solution
t = clip((A' lambda + g) / h, low, high) for the n multipliers that maximise a concave, piecewise quadratic dual:
Newton in n unknowns for any m. Where the dual is unbounded, the multipliers are a Farkas certificate that no tensions
within limits exist.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import largest, largest_of_column, solve

STEPS = 100
MIN_DAMPING = 1e-13  # of the Hessian's trace
NEAR_TOP = 1e-7  # of the load: unbalanced part under which the dual value is flat to rounding
GRAIN = 1e-14  # of the largest multiplier: unbalanced part due to rounding
SOFT = 1e-4  # compliance of a limit, relative to that of a tension, with which the smallest violation is found


class Program(NamedTuple):
    """Quadratic program min sum h t^2 / 2 - g t subject to A t = b, low <= t <= high."""

    structure: NDArray[np.float64]  # (n, m): A
    load: NDArray[np.float64]  # (n,): b
    low: NDArray[np.float64]  # (m,)
    high: NDArray[np.float64]  # (m,)
    curvature: NDArray[np.float64]  # (m,): h
    bias: NDArray[np.float64]  # (m,): g


@jit
def distribute(program, give, tensions, multipliers, hessian, step):
    """Write the solution of *program* to *tensions* (m,). Returns 1 solved, 0 proved infeasible, -1 not solved.

    *give* > 0 softens the limits: the solution is then the distribution that violates them least. *multipliers* (n,)
    are the start of the search and receive its end; *hessian* (n, n) and *step* (n, 3) are scratch.
    """
    n, m = program.structure.shape
    close = 1e-13 if give == 0.0 else 1e-11  # soft multipliers are large, and so is their rounding
    damping = MIN_DAMPING
    scale = max(largest(program.load, n), largest(program.low, m))
    _begin_free(program, multipliers, hessian, step)
    value = _evaluate(program, give, multipliers, tensions, hessian, step)
    for _ in range(STEPS):
        gap = largest_of_column(step, n)
        if gap <= close * scale:
            return 1
        if give == 0.0 and _is_infeasible(program, multipliers, scale):
            return 0
        trace = 1e-300
        for k in range(n):
            trace += hessian[k, k]
        for k in range(n):
            step[k, 1] = step[k, 0]
            hessian[k, k] += damping * trace + (1e-6 if trace < 1e-200 else 0.0)
        if not solve(hessian, step, n, 1):
            return -1
        slope = 0.0
        for k in range(n):
            slope += step[k, 1] * step[k, 0]
            step[k, 2] = step[k, 0]
        reach = 1.0
        improved = False
        for _ in range(60):
            for k in range(n):
                multipliers[k] += reach * step[k, 2]
            trial = _evaluate(program, give, multipliers, tensions, hessian, step)
            # near the maximum rounding hides the gain in value, but not the fall of the slope
            falls = gap <= NEAR_TOP * scale and largest_of_column(step, n) <= 0.5 * gap
            if falls or trial >= value + 1e-4 * reach * slope - 1e-14 * abs(value):
                value = trial
                improved = True
                break
            for k in range(n):
                multipliers[k] -= reach * step[k, 2]
            reach *= 0.5
        # with lines at their limits the Hessian can be nearly singular, and the step far too long
        damping = min(1e-3, 100.0 * damping) if reach < 0.1 else max(MIN_DAMPING, 0.01 * damping)
        if not improved:
            _evaluate(program, give, multipliers, tensions, hessian, step)
            break
    gap = largest_of_column(step, n)
    if gap <= 100.0 * close * scale + GRAIN * largest(multipliers, n):
        return 1
    return 0 if give == 0.0 and _is_infeasible(program, multipliers, scale) else -1


@jit
def _begin_free(program, multipliers, hessian, step):
    """Where *multipliers* are zero, start with those of the program without limits."""
    structure, load, curvature, bias = program.structure, program.load, program.curvature, program.bias
    n, m = structure.shape
    trace = 1e-300
    for k in range(n):
        if multipliers[k] != 0.0:
            return
        step[k, 0] = load[k]
        for i in range(m):
            step[k, 0] -= structure[k, i] * bias[i] / curvature[i]
        for j in range(n):
            hessian[k, j] = 0.0
            for i in range(m):
                hessian[k, j] += structure[k, i] * structure[j, i] / curvature[i]
        trace += hessian[k, k]
    for k in range(n):
        hessian[k, k] += 1e-13 * trace
    if solve(hessian, step, n, 1):
        for k in range(n):
            multipliers[k] = step[k, 0]


@jit
def _evaluate(program, give, multipliers, tensions, hessian, gradient):
    """Dual value at *multipliers*; writes tensions, the gradient load - A t and the negative Hessian A D A'."""
    structure, load, low, high, curvature, bias = program
    n, m = structure.shape
    value = 0.0
    for k in range(n):
        value += load[k] * multipliers[k]
        gradient[k, 0] = load[k]
        for j in range(n):
            hessian[k, j] = 0.0
    for i in range(m):
        free = bias[i]
        for k in range(n):
            free += structure[k, i] * multipliers[k]
        free /= curvature[i]
        bound = min(max(free, low[i]), high[i])
        weight = (1.0 if bound == free else give) / curvature[i]
        t = bound + give * (free - bound)
        tensions[i] = t
        beyond = free - bound
        value -= curvature[i] * (free * bound - 0.5 * bound * bound + 0.5 * give * beyond * beyond)
        for k in range(n):
            a = structure[k, i]
            gradient[k, 0] -= a * t
            for j in range(n):
                hessian[k, j] += weight * a * structure[j, i]
    return value


@jit
def _is_infeasible(program, multipliers, scale):
    """Farkas: whether, along *multipliers*, the load exceeds all tensions within limits by more than rounding."""
    structure, load, low, high, _, _ = program
    n, m = structure.shape
    needed, size, bulk = 0.0, 0.0, 0.0
    for k in range(n):
        needed += load[k] * multipliers[k]
        size += multipliers[k] * multipliers[k]
    for i in range(m):
        pull, terms = 0.0, 0.0
        for k in range(n):
            pull += structure[k, i] * multipliers[k]
            terms += abs(structure[k, i] * multipliers[k])
        available = max(low[i] * pull, high[i] * pull)
        needed -= available
        bulk += abs(available) + 1e-16 * terms * max(abs(low[i]), abs(high[i]))
    return needed > 1e-12 * bulk + 1e-12 * scale * sqrt(size)
