"""Structure matrix A of straight massless lines, A t + w = 0, and all tensions that solve it.

Column i of A (n, m) is the wrench that line i exerts on the platform per newton of tension: u along the line from the
platform to the point where it leaves its mounting, and r x u about the platform's origin.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    OK,
    PULLS,
    STATE,
)
from cablewright.kernels.statics.equilibrium import Work, workspace_of
from cablewright.kernels.statics.line.interface import aim_line_at
from cablewright.kernels.statics.line.vertical_plane import AXIS_DISTANCE
from cablewright.kernels.statics.platform import gradient_by_pose, own_load, place_platform

DEPENDENT = 1e-10  # of a row's size: largest pivot of a freedom that the other degrees of freedom determine
WIDTH = 8  # rows of A, n or n + 1, padded so that a column fills whole registers
ASIDE = 1e-9  # of the load: largest distance of a balanced load from the column space of A


class StructureScratch(NamedTuple):
    """Working memory of one pose: the two sides of A t = -w, one column of them in each row of `table`.

    After `reduce`, t[i] = table[m, i] - sum table[j, i] t[j] over rank <= j < m, for i < rank, lines as in `order`.
    """

    table: NDArray[np.float64]  # (m + 1 + WIDTH, WIDTH): A, -w, and after `track` the row operations
    scale: NDArray[np.float64]  # (WIDTH,): size of the entries in each row of A
    order: NDArray[np.int64]  # (m,): the line at each position
    base: Work  # of one line
    state: NDArray[np.float64]  # (STATE,)


@jit(allocates=True)
def structure_scratch(general, m):
    """Allocate a `StructureScratch` for *m* lines; *general*: see `Packed`."""
    return StructureScratch(
        np.zeros((m + 1 + WIDTH, WIDTH)),
        np.ones(WIDTH),
        np.arange(m),
        workspace_of(general, 6, 1),
        np.zeros(STATE),
    )


@jit
def structure_at(packed, pose, work):
    """Write the structure matrix and the load -w at *pose* (n,) to `table`. Returns a status code.

    A line over a sheave leaves along the tangent; a lever has its angle at the mean of the line's tension limits.
    """
    n, lines, table, arm = packed.freedoms, packed.lines, work.table, work.base.arms[0]
    place_platform(pose, work.base.rotation)
    m, reach = lines.shape[0], AXIS_DISTANCE
    for i in range(m):
        code, x, y, z = aim_line_at(lines, i, pose, work.state, work.base, work.base.spatial)
        if code != OK:
            return code
        pulls = lines[i, PULLS]
        gradient_by_pose(arm, pulls * x, pulls * y, pulls * z, table[i, :n])
        reach = max(reach, abs(arm[0]), abs(arm[1]), abs(arm[2]))
    own_load(packed, work.base.rotation, table[m])
    for k in range(n):
        table[m, k] = -table[m, k]
        work.scale[k] = 1.0 if k < 3 else reach
    return OK


@jit
def track(table, m):
    """Append an identity matrix to *table*, which then records row operations: column k in table[m + 1 + k]."""
    for j in range(WIDTH):
        for k in range(WIDTH):
            table[m + 1 + j, k] = 1.0 if j == k else 0.0


@jit
def reduce(table, scale, order, n, tracked):
    """Solve the first *n* rows of A t = -w in place for as many of the m tensions as they determine.

    Gauss-Jordan elimination by rows with the largest entry of a row as pivot; dependent rows are moved to the end.
    Returns the rank, and whether the load is in the column space of A: otherwise no tensions balance it. *tracked*:
    `track` was called.
    """
    m = order.shape[0]
    last_column = m + 1 + (WIDTH if tracked else 0)
    weight = 0.0
    for k in range(n):
        weight = max(weight, abs(table[m, k]) / scale[k])
    for j in range(m):
        order[j] = j
    rank, last = 0, n
    while rank < last and rank < m:
        best, pivot = 0.0, rank
        for j in range(rank, m):
            size = abs(table[j, rank])
            if size > best:
                best, pivot = size, j
        if best <= DEPENDENT * scale[rank]:
            last -= 1
            scale[rank], scale[last] = scale[last], scale[rank]
            for j in range(last_column):
                table[j, rank], table[j, last] = table[j, last], table[j, rank]
            continue
        c0, c1, c2, c3 = table[pivot, 0], table[pivot, 1], table[pivot, 2], table[pivot, 3]
        c4, c5, c6, c7 = table[pivot, 4], table[pivot, 5], table[pivot, 6], table[pivot, 7]
        inverse = 1.0 / table[pivot, rank]
        if pivot != rank:  # the pivot's own column is not read again
            order[rank], order[pivot] = order[pivot], order[rank]
            for k in range(WIDTH):
                table[pivot, k] = table[rank, k]
        for j in range(rank + 1, last_column):
            factor = table[j, rank] * inverse
            table[j, 0] -= factor * c0
            table[j, 1] -= factor * c1
            table[j, 2] -= factor * c2
            table[j, 3] -= factor * c3
            table[j, 4] -= factor * c4
            table[j, 5] -= factor * c5
            table[j, 6] -= factor * c6
            table[j, 7] -= factor * c7
            table[j, rank] = factor
        rank += 1
    balanced = True
    for k in range(rank, n):
        balanced = balanced and abs(table[m, k]) <= ASIDE * weight * scale[k]
    return rank, balanced
