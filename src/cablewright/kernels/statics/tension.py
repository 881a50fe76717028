"""Tension distribution: the least-norm tensions that balance a wrench within limits, for any m and any rank.

min sum 1/2 h t^2 - g t subject to A t = b, low <= t <= high (least norm: h = 1, g = 0) has the solution
t = clip((A' lambda + g) / h, low, high) for the n multipliers that maximise a concave, piecewise quadratic dual:
Newton in n unknowns, whatever m is. Where the dual climbs without end, the multipliers are a Farkas certificate
that no tensions within limits exist.
"""

from math import sqrt

from cablewright.kernels import jit
from cablewright.kernels.newton import largest, largest_of_column, solve

STEPS = 100
LEAST_DAMPING = 1e-13  # of the Hessian's trace
NEAR_TOP = 1e-7  # of the load: what is left of the balance where the value is flat
GRAIN = 1e-14  # of the largest multiplier: what rounding leaves of the balance
SOFT = 1e-4  # give of a limit, relative to a tension's own, when the least violation is wanted


@jit
def distribute(structure, load, low, high, curvature, bias, give, tensions, multipliers, hessian, step):
    """Write to *tensions* (m,) the best solution of structure (n, m) tensions = load within limits.

    *curvature* (m,) and *bias* (m,) are h and g of the objective. *give* > 0 softens the limits: the answer then is
    the distribution that violates them least. *multipliers* (n,) start the search and are improved; *hessian* (n, n)
    and *step* (n, 3) are scratch. Returns 1 solved, 0 proved infeasible, -1 not solved.
    """
    n, m = structure.shape
    close = 1e-13 if give == 0.0 else 1e-11  # soft multipliers are large, and so is their rounding
    damping = LEAST_DAMPING
    scale = max(largest(load, n), largest(low, m))
    _begin_free(structure, load, curvature, bias, multipliers, hessian, step)
    value = _evaluate(structure, load, low, high, curvature, bias, give, multipliers, tensions, hessian, step)
    for _ in range(STEPS):
        gap = largest_of_column(step, n)
        if gap <= close * scale:
            return 1
        if give == 0.0 and _impossible(structure, load, low, high, multipliers, scale):
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
            trial = _evaluate(structure, load, low, high, curvature, bias, give, multipliers, tensions, hessian, step)
            # near the top rounding hides what the value gains, but not that the slope falls
            falls = gap <= NEAR_TOP * scale and largest_of_column(step, n) <= 0.5 * gap
            if falls or trial >= value + 1e-4 * reach * slope - 1e-14 * abs(value):
                value = trial
                improved = True
                break
            for k in range(n):
                multipliers[k] -= reach * step[k, 2]
            reach *= 0.5
        # lines at their limits can leave the Hessian all but singular, and its step far too long
        damping = min(1e-3, 100.0 * damping) if reach < 0.1 else max(LEAST_DAMPING, 0.01 * damping)
        if not improved:
            _evaluate(structure, load, low, high, curvature, bias, give, multipliers, tensions, hessian, step)
            break
    gap = largest_of_column(step, n)
    if gap <= 100.0 * close * scale + GRAIN * largest(multipliers, n):
        return 1
    return 0 if give == 0.0 and _impossible(structure, load, low, high, multipliers, scale) else -1


@jit
def _begin_free(structure, load, curvature, bias, multipliers, hessian, step):
    """Where the search has no start, begin as if no line were at a limit."""
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
def _evaluate(structure, load, low, high, curvature, bias, give, multipliers, tensions, hessian, gradient):
    """Dual value at *multipliers*; writes tensions, the gradient load - A t and the negative Hessian A D A'."""
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
def _impossible(structure, load, low, high, multipliers, scale):
    """Farkas: along these multipliers the load exceeds, by more than rounding, what tensions within limits can give."""
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
        given = max(low[i] * pull, high[i] * pull)
        needed -= given
        bulk += abs(given) + 1e-16 * terms * max(abs(low[i]), abs(high[i]))
    return needed > 1e-12 * bulk + 1e-12 * scale * sqrt(size)
