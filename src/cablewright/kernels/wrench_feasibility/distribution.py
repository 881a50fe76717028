"""Tension distributions of straight massless lines at poses, and their margins to the limits.

CLOSED: the tensions nearest to the middle of the limits in closed form, which may violate the limits (Jung 2020, Eq.
8). IMPROVED: the line that violates its limits most is fixed at its limit and the rest distributed again, until none
violates or none is free (A. Pott, Cable-Driven Parallel Robots, 2018). LEAST: minimum of a convex quadratic of the
tensions within the limits. WIDEST: largest margin to the limits. CLOSURE: whether every load can be balanced.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import cholesky
from cablewright.kernels.layout import INFEASIBLE, NOT_CONVERGED, OK, SINGULAR, TENSION_MAX, TENSION_MIN, Packed
from cablewright.kernels.statics.platform import free_rows, keep_free, keep_free_columns
from cablewright.kernels.statics.tension_distribution import SOFT, Program, distribute
from cablewright.kernels.wrench_feasibility.structure_matrix import (
    StructureScratch,
    reduce,
    structure_at,
    structure_scratch,
)
from cablewright.kernels.wrench_feasibility.tension_margin import Exchange, exchange_scratch, min_slack, widest

CLOSED, IMPROVED, LEAST, WIDEST, CLOSURE = 0, 1, 2, 3, 4
HELD = 1e-12  # squared norm of a line's row of the null space basis under which its tension is not free
CLOSED_BY = 1e-9  # of the mean tension: min entry of a null vector that counts as positive
UNBOUNDED = 1e3  # of the mean tension: upper limit of a null vector's entries for CLOSURE


class Distributing(NamedTuple):
    """Working memory of one thread of `distribute_rows`."""

    structure: StructureScratch
    exchange: Exchange
    basis: NDArray[np.float64]  # (m, m): orthonormal basis of the null space, one row for each line
    gram: NDArray[np.float64]  # (m, m)
    matrix: NDArray[np.float64]  # (n, m): A
    load: NDArray[np.float64]  # (n,)
    fixed: NDArray[np.bool_]  # (m,)
    limits: NDArray[np.float64]  # (2, m): low and high, N, as the lines are numbered
    multipliers: NDArray[np.float64]  # (n,)
    hessian: NDArray[np.float64]  # (n, n)
    step: NDArray[np.float64]  # (n, 3)


@jit(allocates=True)
def distributing_scratch(packed):
    """Allocate a `Distributing` that fits the robots of a batch."""
    n, m = packed.freedoms, packed.lines.shape[1]
    return Distributing(
        structure_scratch(packed.general, m),
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
    """Write middle and half width of the tension limits in the order of the reduced structure."""
    for i in range(order.shape[0]):
        low, high = lines[order[i], TENSION_MIN], lines[order[i], TENSION_MAX]
        middle[i], half[i] = 0.5 * (high + low), 0.5 * (high - low)


@jit
def _nearest(table, rank, middle, shift, gram):
    """Write the shifts from the middle of the limits that balance the load with the least norm (Jung 2020, Eq. 8).

    With e the shifts of the dependent lines while the free ones are in their middle, and N their table, the free ones
    solve (1 + N' N) d = N' e, which is well conditioned for any rank of A. Leaves its Cholesky factor in *gram*.
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
    cholesky(gram, free)
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
    """As `_nearest`, with two free lines, the usual case, in closed form; *gram* is left unfactored."""
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
def _improve(table, rank, half, shift, gram, basis, fixed):
    """Fix the line that violates its limits most at its limit and distribute the rest again, while that can help.

    The basis Z of the null space is orthonormal: the smallest change of the others that moves line i is along Z Z[i],
    and the remaining null space is Z without its component along Z[i].
    """
    m = fixed.shape[0]
    free = m - rank
    if free == 2:
        cholesky(gram, free)
    _write_null_space(table, rank, gram, basis)
    fixed[:] = False
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
def _write_null_space(table, rank, gram, basis):
    """Write an orthonormal basis of the null space: (-N; 1) L'^-1 with the Cholesky factor L of 1 + N' N."""
    m = basis.shape[0]
    for i in range(m):
        for j in range(m - rank):
            entry = -table[rank + j, i] if i < rank else (1.0 if i == rank + j else 0.0)
            for k in range(j):
                entry -= gram[j, k] * basis[i, k]
            basis[i, j] = entry / gram[j, j]


@jit
def _least(packed, n, curvature, bias, tensions, work):
    """Write the tensions that minimise a diagonal quadratic within limits, or else violate them least; code, margin."""
    m, structure = packed.lines.shape[0], work.structure
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
    widest_margin, sure = widest(structure.table, rank, m, work.exchange)
    answer, solved = 0, 0
    for give in (0.0, SOFT):
        if give == 0.0 and sure and widest_margin < 0.0:
            continue
        program = Program(work.matrix, work.load, work.limits[0], work.limits[1], curvature, bias)
        solved = distribute(program, give, tensions, work.multipliers, work.hessian, work.step)
        if give == 0.0:
            answer = solved
        if solved == 1:
            break
        work.multipliers[:] = 0.0
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
    """Code and margin of wrench closure: full rank, and a null vector whose entries are all positive."""
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
    """Write tensions (N, m), margins (N,) and codes (N,) at poses (N, n) by a *method* of tension distribution.

    A margin is the smallest distance of a tension from its limits, N; negative: the largest violation; -inf: no
    tensions of any size balance the load. *curvature* and *bias* (m,) are the objective of LEAST. CLOSURE writes the
    null vector of mean 1 with the largest min entry, which is its margin. Lines and platform of *packed* have one row
    or N each.
    """
    work = distributing_scratch(packed)
    _distribute_each(packed, poses, method, curvature, bias, tensions, margins, codes, first, last, work)


@jit
def _distribute_each(packed, poses, method, curvature, bias, tensions, margins, codes, first, last, work):
    """The loop of `distribute_rows`, in one function: passing the scratch on would cost more than the arithmetic."""
    m, structure = packed.lines.shape[1], work.structure
    table, scale, order = structure.table, structure.scale, structure.order
    middle, half, shift = work.exchange.middle, work.exchange.half, work.exchange.shift
    for j in range(first, last):
        own = robot_view(packed, j)
        margin = -np.inf
        code = structure_at(own, poses[j], structure)
        n = free_rows(own, table, scale, m + 1)
        if code == OK and method == LEAST:
            codes[j], margins[j] = _least(own, n, curvature, bias, tensions[j], work)
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
                    margin = min_slack(half, shift, m)
                    if method == IMPROVED and margin < 0.0:
                        _improve(table, rank, half, shift, work.gram, work.basis, work.fixed)
                        margin = min_slack(half, shift, m)
                if margin >= 0.0:
                    code = OK
                if not sure:
                    code, margin = NOT_CONVERGED, np.nan
        codes[j], margins[j] = code, margin
        for i in range(m):
            tensions[j, order[i]] = middle[i] + shift[i] if margin > -np.inf else np.nan


@jit(allocates=True)
def structure_rows(packed, poses, structures, wrenches, codes):
    """Write structure matrices (N, n, m) and the platform's own wrenches (N, n) at *poses*; NaN where undefined."""
    work = structure_scratch(packed.general, packed.lines.shape[1])
    _structure_each(packed, poses, structures, wrenches, codes, work)


@jit
def _structure_each(packed, poses, structures, wrenches, codes, work):
    n, m = packed.freedoms, packed.lines.shape[1]
    for j in range(poses.shape[0]):
        codes[j] = structure_at(robot_view(packed, j), poses[j], work)
        good = codes[j] == OK
        for k in range(n):
            wrenches[j, k] = -work.table[m, k] if good else np.nan
            for i in range(m):
                structures[j, k, i] = work.table[i, k] if good else np.nan
        keep_free_columns(robot_view(packed, j), structures[j])
        keep_free(robot_view(packed, j), wrenches[j])


@jit
def robot_view(packed, j):
    """Return the robot of problem *j* as views; call it only from kernels without reference counting."""
    line = j if packed.lines.shape[0] > 1 else 0
    platform = j if packed.platform.shape[0] > 1 else 0
    return Packed(packed.freedoms, packed.lines[line], packed.platform[platform], packed.general)
