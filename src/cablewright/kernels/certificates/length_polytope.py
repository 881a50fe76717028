"""Polytopes of cable lengths (a box intersected with slabs): bounds of linear functions, and points inside.

The set is low <= x <= high, slab_low <= S (x - origin) <= slab_high. The bound of a linear function is that of weak
duality: any weights of the slabs give a valid one, so that their choice affects its tightness only.
"""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import GAMMA

UNDERFLOW = 1e-290
SWEEPS = 2  # over the weights, where there are several
ROUNDS = 100
HALVINGS = 20


@jit
def upper_bound(row, sign, left, right, slabs, below, above, weights):
    """Return an upper bound of *sign* * row . x for left <= x <= right, below <= slabs x <= above.

    Writes the *weights* of the slabs (dual variables) that prove the bound.
    """
    m, count = left.shape[0], below.shape[0]
    weights[:] = 0.0
    for _ in range(SWEEPS if count > 1 else count):
        for k in range(count):
            _weigh(row, sign, left, right, slabs, below, above, weights, k)
    total, bulk = 0.0, 0.0
    for i in range(m):
        rest, size = sign * row[i], abs(row[i])
        for k in range(count):
            rest -= weights[k] * slabs[k, i]
            size += abs(weights[k] * slabs[k, i])
        total += max(rest * left[i], rest * right[i])
        bulk += size * max(abs(left[i]), abs(right[i]))
    for k in range(count):
        total += max(weights[k] * below[k], weights[k] * above[k])
        bulk += abs(weights[k]) * max(abs(below[k]), abs(above[k]))
    return total + GAMMA * bulk + UNDERFLOW


@jit
def _weigh(row, sign, left, right, slabs, below, above, weights, k):
    """Set the best weight of slab *k* with the others fixed: the bound is convex, its corners are where a term is 0."""
    m = left.shape[0]
    weights[k] = 0.0
    best, smallest = 0.0, np.inf
    for j in range(m + 1):
        trial = 0.0
        if j < m:
            if slabs[k, j] == 0.0:
                continue
            trial = _rest(row, sign, slabs, weights, j) / slabs[k, j]
        total = max(trial * below[k], trial * above[k])
        for i in range(m):
            rest = _rest(row, sign, slabs, weights, i) - trial * slabs[k, i]
            total += max(rest * left[i], rest * right[i])
        if total < smallest:
            best, smallest = trial, total
    weights[k] = best


@jit
def _rest(row, sign, slabs, weights, i):
    """Entry *i* of sign row less the weighted slabs."""
    rest = sign * row[i]
    for k in range(weights.shape[0]):
        rest -= weights[k] * slabs[k, i]
    return rest


@jit
def offset(slabs, k, origin, x):
    """Return the position slabs[k] . (x - origin) of a point across slab *k*, and the sum of its absolute terms."""
    total, bulk = 0.0, 0.0
    for i in range(x.shape[0]):
        part = slabs[k, i] * (x[i] - origin[i])
        total += part
        bulk += abs(part)
    return total, bulk


@jit
def holds(low, high, slab_low, slab_high, slabs, origin, x, pads):
    """Return whether the point *x* is in the set, with its slabs widened by half of *pads* on each side."""
    for i in range(x.shape[0]):
        if not low[i] <= x[i] <= high[i]:
            return False
    for k in range(slabs.shape[0]):
        at, _ = offset(slabs, k, origin, x)
        if not slab_low[k] - 0.5 * pads[k] <= at <= slab_high[k] + 0.5 * pads[k]:
            return False
    return True


@jit
def centre_of(low, high, slab_low, slab_high, slabs, origin, x, pads, inner):
    """Write a point near the middle of the polytope to *x*, and return whether *x* is inside.

    *inner* is a point known to be inside.
    """
    for i in range(x.shape[0]):
        x[i] = 0.5 * (low[i] + high[i])
    for _ in range(ROUNDS):
        worst = 0.0
        for k in range(slabs.shape[0]):
            at, _ = offset(slabs, k, origin, x)
            lack = _middle(slabs, k, origin, low, high, slab_low[k], slab_high[k]) - at
            worst = max(worst, abs(lack) / (slab_high[k] - slab_low[k] + pads[k]))
            _shift(slabs, k, low, high, lack, x)
        if worst < 0.1:
            break
    for _ in range(HALVINGS):
        if holds(low, high, slab_low, slab_high, slabs, origin, x, pads):
            return True
        for i in range(x.shape[0]):
            x[i] = 0.5 * (x[i] + inner[i])
    return False


@jit
def _middle(slabs, k, origin, low, high, first, last):
    """Middle of the slab's interval intersected with the range of its form over the box."""
    lower, upper = 0.0, 0.0
    for i in range(low.shape[0]):
        a, b = slabs[k, i] * (low[i] - origin[i]), slabs[k, i] * (high[i] - origin[i])
        lower += min(a, b)
        upper += max(a, b)
    return 0.5 * (max(first, lower) + min(last, upper))


@jit
def _shift(slabs, k, low, high, lack, x):
    """Move entries of *x* that are not at a limit so that slabs[k] . x grows by *lack*, as far as the box allows."""
    free = 0.0
    for i in range(x.shape[0]):
        if _may_move(slabs[k, i] * lack, low[i], high[i], x[i]):
            free += slabs[k, i] ** 2
    if not free > 0.0:
        return
    for i in range(x.shape[0]):
        if _may_move(slabs[k, i] * lack, low[i], high[i], x[i]):
            x[i] = min(max(x[i] + lack * slabs[k, i] / free, low[i]), high[i])


@jit
def _may_move(way, low, high, x):
    return (way > 0.0 and x < high) or (way < 0.0 and x > low)
