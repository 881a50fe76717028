"""Tension distributions of straight massless lines at poses, and the margins to their limits.

Closed form: the tensions nearest to the middle of the limits, whatever the limits are (Jung 2020, Eq. 8). Improved:
the line furthest outside is fixed at its limit and the rest distributed anew, until none is outside or no choice is
left (A. Pott, Cable-Driven Parallel Robots, 2018). Least: a convex quadratic of the tensions within the limits. Widest:
as far from the limits as can be. Closure: not a load but whether any can be balanced.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit, prange
from cablewright.kernels.layout import TENSION_MAX, TENSION_MIN, Code, Packed
from cablewright.kernels.statics.tension import SOFT, distribute
from cablewright.kernels.wrench_feasibility.structure_matrix import (
    OK,
    StructureScratch,
    reduce,
    structure_at,
    structure_scratch,
)
from cablewright.kernels.wrench_feasibility.tension_margin import Exchange, exchange_scratch, least_slack, widest

CLOSED, IMPROVED, LEAST, WIDEST, CLOSURE = 0, 1, 2, 3, 4
CHUNK = 256  # rows per task: worth the scratch that each makes
NOT_CONVERGED = int(Code.NOT_CONVERGED)
SINGULAR = int(Code.SINGULAR)
INFEASIBLE = int(Code.INFEASIBLE)
HELD = 1e-12  # share of a line's tension that the other lines leave to choice: less is none
CLOSED_BY = 1e-9  # of the mean tension: what rounding may make of a null vector that only touches zero
UNBOUNDED = 1e3  # of the mean tension: where closure lets a null vector's entries end


class Distributing(NamedTuple):
    """Scratch of one thread."""

    structure: StructureScratch
    exchange: Exchange
    basis: NDArray[np.float64]  # (m, m): rows of an orthonormal basis of the null space, a line each
    gram: NDArray[np.float64]  # (m, m)
    matrix: NDArray[np.float64]  # (n, m): A
    load: NDArray[np.float64]  # (n,)
    fixed: NDArray[np.bool_]  # (m,)
    limits: NDArray[np.float64]  # (2, m): low and high, N, as the lines are numbered
    multipliers: NDArray[np.float64]  # (n,)
    hessian: NDArray[np.float64]  # (n, n)
    step: NDArray[np.float64]  # (n, 3)


@jit(allocates=True)
def distributing_scratch(n, m):
    """Scratch for *n* freedoms and *m* lines."""
    return Distributing(
        structure_scratch(m),
        exchange_scratch(m),
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros((n, m)),
        np.zeros(n),
        np.zeros(m, np.bool_),
        np.zeros((2, m)),
        np.zeros(n),
        np.zeros((n, n)),
        np.zeros((n, 3)),
    )


@jit
def _order_limits(lines, order, middle, half):
    """Middle and half width of the limits in the order of the reduced structure."""
    for i in range(order.shape[0]):
        low, high = lines[order[i], TENSION_MIN], lines[order[i], TENSION_MAX]
        middle[i], half[i] = 0.5 * (high + low), 0.5 * (high - low)


@jit
def _nearest(table, rank, middle, shift, gram):
    """Shifts from the middle of the limits that balance the load with the least sum of squares (Jung 2020, Eq. 8).

    With e the shifts of the decided lines where the free ones are in their middle, and N their table, the free ones
    solve (1 + N' N) d = N' e, which is small and well conditioned, whatever rank A has. Leaves its factor in *gram*.
    """
    m = middle.shape[0]
    free = m - rank
    if free == 2:
        _nearest_of_two(table, rank, middle, shift, gram)
        return
    for i in range(rank):
        shift[i] = table[m, i] - middle[i]
    for j in range(free):
        for i in range(rank):
            shift[i] -= table[rank + j, i] * middle[rank + j]
    for j in range(free):
        total = 0.0
        for i in range(rank):
            total += table[rank + j, i] * shift[i]
        shift[rank + j] = total
        for k in range(j + 1):
            total = 1.0 if k == j else 0.0
            for i in range(rank):
                total += table[rank + j, i] * table[rank + k, i]
            gram[j, k] = total
    _factor(gram, free)
    for j in range(free):
        for k in range(j):
            shift[rank + j] -= gram[j, k] * shift[rank + k]
        shift[rank + j] /= gram[j, j]
    for j in range(free - 1, -1, -1):
        for k in range(j + 1, free):
            shift[rank + j] -= gram[k, j] * shift[rank + k]
        shift[rank + j] /= gram[j, j]
        for i in range(rank):
            shift[i] -= table[rank + j, i] * shift[rank + j]


@jit
def _nearest_of_two(table, rank, middle, shift, gram):
    """`_nearest` with two free lines, the usual case: all sums at once; *gram* is left as it is before its factor."""
    p, q = middle[rank], middle[rank + 1]
    pp, pq, qq, pe, qe = 1.0, 0.0, 1.0, 0.0, 0.0
    for i in range(rank):
        a, b = table[rank, i], table[rank + 1, i]
        e = table[rank + 2, i] - middle[i] - a * p - b * q
        shift[i] = e
        pp += a * a
        pq += a * b
        qq += b * b
        pe += a * e
        qe += b * e
    gram[0, 0], gram[1, 0], gram[1, 1] = pp, pq, qq
    inverse = 1.0 / (pp * qq - pq * pq)
    p = (pe * qq - qe * pq) * inverse
    q = (qe * pp - pe * pq) * inverse
    for i in range(rank):
        shift[i] -= table[rank, i] * p + table[rank + 1, i] * q
    shift[rank], shift[rank + 1] = p, q


@jit
def _factor(gram, free):
    """Cholesky factor of *gram*, in place."""
    for j in range(free):
        for k in range(j + 1):
            total = gram[j, k]
            for q in range(k):
                total -= gram[j, q] * gram[k, q]
            gram[j, k] = sqrt(total) if k == j else total / gram[k, k]


@jit
def _improve(table, rank, half, shift, gram, basis, fixed):
    """Fix the line furthest outside its limits at its limit and distribute the rest anew, as long as that may help.

    The basis Z of the null space is orthonormal: the least change of the others that moves line i is along Z Z[i], and
    what stays free afterwards is Z without its part along Z[i].
    """
    m = fixed.shape[0]
    free = m - rank
    if free == 2:
        _factor(gram, free)
    _span(table, rank, gram, basis)
    for i in range(m):
        fixed[i] = False
    for _ in range(free):
        worst, line = 0.0, -1
        for i in range(m):
            over = abs(shift[i]) - half[i]
            if over > worst:
                worst, line = over, i
        if line < 0:
            return
        square = 0.0
        for j in range(free):
            square += basis[line, j] * basis[line, j]
        if square <= HELD:
            return
        aim = half[line] if shift[line] > 0.0 else -half[line]
        move = (aim - shift[line]) / square
        for i in range(m):
            if fixed[i] or i == line:
                continue
            along = 0.0
            for j in range(free):
                along += basis[i, j] * basis[line, j]
            shift[i] += along * move
            along /= square
            for j in range(free):
                basis[i, j] -= along * basis[line, j]
        shift[line] = aim
        fixed[line] = True
        for j in range(free):
            basis[line, j] = 0.0


@jit
def _span(table, rank, gram, basis):
    """An orthonormal basis of the null space: (-N; 1) L'^-1 with the Cholesky factor L of 1 + N' N."""
    m = basis.shape[0]
    for i in range(m):
        for j in range(m - rank):
            entry = -table[rank + j, i] if i < rank else (1.0 if i == rank + j else 0.0)
            for k in range(j):
                entry -= gram[j, k] * basis[i, k]
            basis[i, j] = entry / gram[j, j]


@jit
def _least(packed, curvature, bias, tensions, work):
    """Least of a diagonal quadratic within limits, or where there is none what breaks them least."""
    m, n, structure = packed.lines.shape[0], packed.freedoms, work.structure
    for i in range(m):
        work.limits[0, i], work.limits[1, i] = packed.lines[i, TENSION_MIN], packed.lines[i, TENSION_MAX]
    for k in range(n):
        work.load[k] = structure.table[m, k]
        work.multipliers[k] = 0.0
        for i in range(m):
            work.matrix[k, i] = structure.table[i, k]
    rank, balanced = reduce(structure.table, structure.scale, structure.order, n, False)
    if not balanced:
        tensions[:] = np.nan
        return INFEASIBLE, -np.inf
    _order_limits(packed.lines, structure.order, work.exchange.middle, work.exchange.half)
    room, sure = widest(structure.table, rank, m, work.exchange)
    answer, solved = 0, 0
    for give in (0.0, SOFT):
        if give == 0.0 and sure and room < 0.0:
            continue
        solved = distribute(
            work.matrix,
            work.load,
            work.limits[0],
            work.limits[1],
            curvature,
            bias,
            give,
            tensions,
            work.multipliers,
            work.hessian,
            work.step,
        )
        if give == 0.0:
            answer = solved
        if solved == 1:
            break
        for k in range(n):
            work.multipliers[k] = 0.0
    margin = 1e300
    for i in range(m):
        margin = min(margin, tensions[i] - work.limits[0, i], work.limits[1, i] - tensions[i])
    if answer == 1:
        return OK, margin
    if solved != 1:
        tensions[:] = np.nan
        margin = np.nan
    return (INFEASIBLE if answer == 0 else NOT_CONVERGED), margin


@jit
def _closure(n, m, work):
    """Wrench closure: full rank, and a null vector with all entries positive."""
    structure, exchange = work.structure, work.exchange
    for k in range(n):
        structure.table[m, k] = 0.0
    structure.table[m, n], structure.scale[n] = float(m), 1.0
    for j in range(m):
        structure.table[j, n] = 1.0
    rank, balanced = reduce(structure.table, structure.scale, structure.order, n + 1, False)
    if not balanced or rank <= n:
        return (SINGULAR if balanced else INFEASIBLE), -np.inf
    for i in range(m):
        exchange.middle[i], exchange.half[i] = 0.5 * UNBOUNDED, 0.5 * UNBOUNDED
    margin, sure = widest(structure.table, rank, m, exchange)
    if not sure:
        return NOT_CONVERGED, np.nan
    return (OK if margin > CLOSED_BY else INFEASIBLE), margin


@jit(allocates=True)
def distribute_rows(packed, poses, method, curvature, bias, tensions, margins, codes, first, last):
    """Distribute tensions at rows *first* to *last* in place; see `distribute_sweep`."""
    work = distributing_scratch(packed.freedoms, packed.lines.shape[1])
    _distribute_each(packed, poses, method, curvature, bias, tensions, margins, codes, first, last, work)


@jit
def _distribute_each(packed, poses, method, curvature, bias, tensions, margins, codes, first, last, work):
    """The loop of `distribute_rows`. It stands whole: to hand the scratch on would cost more than the arithmetic."""
    n, m, structure = packed.freedoms, packed.lines.shape[1], work.structure
    table, scale, order = structure.table, structure.scale, structure.order
    middle, half, shift = work.exchange.middle, work.exchange.half, work.exchange.shift
    for j in range(first, last):
        own = robot_of(packed, j)
        margin = -np.inf
        code = structure_at(own, poses[j], structure)
        if code == OK and method == LEAST:
            codes[j], margins[j] = _least(own, curvature, bias, tensions[j], work)
            continue
        if code == OK and method == CLOSURE:
            code, margin = _closure(n, m, work)
        elif code == OK:
            rank, balanced = reduce(table, scale, order, n, False)
            code = INFEASIBLE
            if balanced:
                _order_limits(own.lines, order, middle, half)
                sure = True
                if method == WIDEST:
                    margin, sure = widest(table, rank, m, work.exchange)
                else:
                    _nearest(table, rank, middle, shift, work.gram)
                    margin = least_slack(half, shift, m)
                    if method == IMPROVED and margin < 0.0:
                        _improve(table, rank, half, shift, work.gram, work.basis, work.fixed)
                        margin = least_slack(half, shift, m)
                if margin >= 0.0:
                    code = OK
                if not sure:
                    code, margin = NOT_CONVERGED, np.nan
        codes[j], margins[j] = code, margin
        for i in range(m):
            tensions[j, order[i]] = middle[i] + shift[i] if margin > -np.inf else np.nan


@jit(parallel=True)
def distribute_sweep(packed, poses, method, curvature, bias, tensions, margins, codes):
    """A batch of poses (N, n): tensions (N, m), margins (N,) and codes (N,) by *method* are written.

    A margin is how far within their limits the tensions are, N, least of all lines; negative: how far outside; -inf:
    no tensions of any size balance the load. *curvature* and *bias* (m,) are the objective of LEAST. CLOSURE writes
    the null vector of mean 1 whose least entry is largest, which is its margin. Lines and platform of *packed* have
    one row or N each.
    """
    rows = poses.shape[0]
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        last = min(rows, first + CHUNK)
        distribute_rows(packed, poses, method, curvature, bias, tensions, margins, codes, first, last)


@jit(allocates=True)
def structure_rows(packed, poses, structures, wrenches, codes):
    """Structure matrices (N, n, m) and wrenches besides the lines' (N, n) at *poses*; NaN where there are none."""
    work = structure_scratch(packed.lines.shape[1])
    _structure_each(packed, poses, structures, wrenches, codes, work)


@jit
def _structure_each(packed, poses, structures, wrenches, codes, work):
    n, m = packed.freedoms, packed.lines.shape[1]
    for j in range(poses.shape[0]):
        codes[j] = structure_at(robot_of(packed, j), poses[j], work)
        good = codes[j] == OK
        for k in range(n):
            wrenches[j, k] = -work.table[m, k] if good else np.nan
            for i in range(m):
                structures[j, k, i] = work.table[i, k] if good else np.nan


@jit
def robot_of(packed, j):
    """The robot of problem *j*; only for kernels that count no references, like this one."""
    line = j if packed.lines.shape[0] > 1 else 0
    platform = j if packed.platform.shape[0] > 1 else 0
    return Packed(packed.freedoms, packed.lines[line], packed.platform[platform])
