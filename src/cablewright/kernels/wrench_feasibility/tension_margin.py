"""The largest s such that tensions within [low + s, high - s] balance a load: exactly, for any m and any rank.

With d = t - (low + high) / 2 and half = (high - low) / 2 this is s = max over t of min over lines of half - |d|, a
linear program in the m - rank free tensions and s. It is solved by exchange (dual simplex; Stiefel's method for
Chebyshev approximation): a reference of free + 1 lines, each at the margin s from one of its limits, bounds s from
above; the line that violates that bound most enters the reference, and s falls until no line does.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit

STEPS_PER_LINE = 10
PLAIN_STEPS = 3  # per line: exchanges before the rule that cannot cycle takes over
BEYOND = 1e-14  # of the largest half width and the margin: smallest violation of the bound that counts
MIN_PIVOT = 1e-12
AGREED = 1e-9  # of the largest tension: largest difference of upper bound and margin found at the optimum


class Exchange(NamedTuple):
    """Working memory of the exchange method.

    d of each line outside the reference = start + coefficients w, with w >= 0 the slacks of those inside. The bound is
    s = s0 - weights w. One additional line represents s <= the smallest half width.
    """

    middle: NDArray[np.float64]  # (m,): of the limits, in the order of the reduced structure
    half: NDArray[np.float64]  # (m + 1,)
    start: NDArray[np.float64]  # (m + 1,)
    coefficients: NDArray[np.float64]  # (m + 1, m + 1)
    lines: NDArray[np.int64]  # (m + 1,): which line each row is of
    reference: NDArray[np.int64]  # (m + 1,): lines of the reference
    signs: NDArray[np.float64]  # (m + 1,): the limit each is at: 1 high, -1 low
    weights: NDArray[np.float64]  # (m + 1,): not negative, sum 1
    entering: NDArray[np.float64]  # (m + 1,)
    shift: NDArray[np.float64]  # (m + 1,): d of every line


@jit(allocates=True)
def exchange_scratch(m):
    """Allocate an `Exchange` for *m* lines."""
    return Exchange(
        np.zeros(m),
        np.zeros(m + 1),
        np.zeros(m + 1),
        np.zeros((m + 1, m + 1)),
        np.zeros(m + 1, np.int64),
        np.zeros(m + 1, np.int64),
        np.zeros(m + 1),
        np.zeros(m + 1),
        np.zeros(m + 1),
        np.zeros(m + 1),
    )


@jit
def widest(table, rank, m, work):
    """Find the tensions with the largest margin to their limits; return that margin, N, and whether it is proved.

    The tensions are `work.shift` + `work.middle`. *table* is that of a structure reduced to *rank*; `work.middle` and
    `work.half` hold the limits.
    """
    free = m - rank
    min_half, max_half = 1e300, 0.0
    for i in range(m):
        min_half = min(min_half, work.half[i])
        max_half = max(max_half, work.half[i])
    for i in range(rank):
        shift = table[m, i] - work.middle[i]
        for j in range(rank, m):
            shift -= table[j, i] * work.middle[j]
        work.shift[i] = shift
    if rank == 0:
        work.shift[:m] = 0.0
    if free == 0 or rank == 0:
        return min_slack(work.half, work.shift, m), True
    work.half[m] = min_half
    bound = _begin(table, rank, m, work)
    bound, settled = _exchange(rank, free, max_half, bound, work)
    _write_back(table, rank, m, bound, work)
    margin = min_slack(work.half, work.shift, m)
    return margin, settled and bound - margin <= AGREED * (max_half + abs(bound))


@jit
def min_slack(half, shift, m):
    """Return the smallest distance of a tension from its limits, N; negative where one is violated."""
    slack = 1e300
    for i in range(m):
        slack = min(slack, half[i] - abs(shift[i]))
    return slack


@jit
def _begin(table, rank, m, work):
    """Set the first reference, the free lines and the other one with the smallest bound; returns that bound.

    `work.shift` holds d of the dependent lines while the free ones are in the middle of their limits.
    """
    free = m - rank
    bound, chosen, total = 1e300, 0, 1.0
    for i in range(rank):
        size, slack = 1.0, work.half[i] - abs(work.shift[i])
        for j in range(free):
            share = abs(table[rank + j, i])
            size += share
            slack += share * work.half[rank + j]
        if slack < bound * size:
            bound, chosen, total = slack / size, i, size
    side = 1.0 if work.shift[chosen] > 0.0 else -1.0
    work.reference[0], work.signs[0], work.weights[0] = chosen, side, 1.0 / total
    for j in range(free):
        share = side * table[rank + j, chosen]
        work.reference[j + 1] = rank + j
        work.signs[j + 1] = 1.0 if share > 0.0 else -1.0
        work.weights[j + 1] = abs(share) / total
    for i in range(rank):
        if i == chosen:  # its row becomes that of the additional line
            work.lines[i], work.start[i] = m, 0.0
            for j in range(free + 1):
                work.coefficients[i, j] = 0.0
            continue
        work.lines[i] = i
        along, start = 0.0, work.shift[i]
        for j in range(free):
            share = table[rank + j, i] * work.signs[j + 1]
            along += share
            start -= share * work.half[rank + j]
            work.coefficients[i, j + 1] = share
        work.start[i] = start + along * bound
        work.coefficients[i, 0] = 0.0
        for j in range(free + 1):
            work.coefficients[i, j] -= along * work.weights[j]
    return bound


@jit
def _exchange(rows, free, max_half, bound, work):
    """Exchange lines until none violates the *bound*; returns it, and whether that was reached."""
    start, coefficients, weights, entering = work.start, work.coefficients, work.weights, work.entering
    for step in range(STEPS_PER_LINE * (rows + free + 1)):
        plain = step < PLAIN_STEPS * (rows + free + 1)
        worst, row, line = BEYOND * (max_half + abs(bound)), -1, 1 << 30
        for i in range(rows):
            over = abs(start[i]) - work.half[work.lines[i]] + bound
            if over > worst and (plain or work.lines[i] < line):
                row, line = i, work.lines[i]
                if plain:
                    worst = over
        if row < 0:
            return bound, True
        side = 1.0 if start[row] > 0.0 else -1.0
        over = abs(start[row]) - work.half[line] + bound
        leaving, ratio = -1, 1e300
        for j in range(free + 1):
            a = weights[j] - side * coefficients[row, j]
            entering[j] = a
            if a <= MIN_PIVOT:
                continue
            if weights[j] < ratio * a:
                leaving, ratio = j, weights[j] / a
            elif weights[j] == ratio * a and leaving >= 0:
                better = a > entering[leaving] if plain else work.reference[j] < work.reference[leaving]
                leaving = j if better else leaving
        if leaving < 0:
            return bound, False
        bound = _swap(rows, free, row, leaving, side, over, bound, work)
    return bound, False


@jit
def _swap(rows, free, row, leaving, side, over, bound, work):
    """Take the line of *row* into the reference at its limit *side*, in place of *leaving*; returns the new bound."""
    start, coefficients, weights, entering = work.start, work.coefficients, work.weights, work.entering
    inverse = 1.0 / entering[leaving]
    gone, sign = work.reference[leaving], work.signs[leaving]
    far = over * inverse  # slack of the line that leaves
    work.reference[leaving], work.signs[leaving] = work.lines[row], side
    entering[leaving] = -1.0
    for j in range(free + 1):
        entering[j] *= -inverse  # the slack that leaves = far + entering w
    for i in range(rows):
        c = coefficients[i, leaving]
        start[i] += c * far
        coefficients[i, leaving] = 0.0
        for j in range(free + 1):
            coefficients[i, j] += c * entering[j]
    share = weights[leaving]
    bound -= share * far
    weights[leaving] = 0.0
    for j in range(free + 1):
        weights[j] = max(weights[j] + share * entering[j], 0.0)
    # d of the line that left: sign (half - s - its slack)
    work.lines[row] = gone
    start[row] = sign * (work.half[gone] - bound - far)
    for j in range(free + 1):
        coefficients[row, j] = sign * (weights[j] - entering[j])
    return bound


@jit
def _write_back(table, rank, m, bound, work):
    """Write the tensions at the end of the exchange: free lines from the reference, the others by the balance."""
    for i in range(rank):
        work.shift[work.lines[i]] = work.start[i]
    for j in range(m - rank + 1):
        line = work.reference[j]
        work.shift[line] = work.signs[j] * (work.half[line] - bound)
    for i in range(rank):
        tension = table[m, i]
        for j in range(rank, m):
            tension -= table[j, i] * (work.middle[j] + work.shift[j])
        work.shift[i] = tension - work.middle[i]
