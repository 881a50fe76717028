"""Capacity margin: signed distance of a wrench from the boundary of the wrenches that tensions within limits can make.

These wrenches -A t are a zonotope. Each of its facets is parallel to the columns of A of rank - 1 lines; with c normal
to these, the two parallel facets are c . x = sum max(c . a low, c . a high) and the same with min (S. Bouchard, C.
Gosselin, B. Moore, On the ability of a cable-driven robot to generate a prescribed set of wrenches, 2010). c needs no
search in n dimensions: c' A lies in the row space of A, which the reduced structure [1 N] spans, and is zero on these
lines. Every c bounds the margin from above, facet or not, so that nearly parallel columns do no harm.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import INFEASIBLE, OK, TENSION_MAX, TENSION_MIN
from cablewright.kernels.statics.platform import free_rows, free_side
from cablewright.kernels.wrench_feasibility.distribution import robot_view
from cablewright.kernels.wrench_feasibility.structure_matrix import (
    ASIDE,
    StructureScratch,
    reduce,
    structure_at,
    structure_scratch,
    track,
)


class Facets(NamedTuple):
    """Working memory of one thread of `capacity_rows`."""

    structure: StructureScratch
    columns: NDArray[np.float64]  # (m, n): A, transposed
    transform: NDArray[np.float64]  # (n, n): row operations of the elimination of A
    chosen: NDArray[np.int64]  # (m + 1,): the lines that a facet is not parallel to
    held: NDArray[np.int64]  # (n,): those of them whose tension the elimination solved for
    system: NDArray[np.float64]  # (n, n)
    others: NDArray[np.int64]  # (n,): the free lines that a facet is parallel to
    share: NDArray[np.float64]  # (n,)
    normal: NDArray[np.float64]  # (n,)
    middle: NDArray[np.float64]  # (n,): centre of the box of wrenches to balance
    half: NDArray[np.float64]  # (n,): its half sides


@jit(allocates=True)
def facet_scratch(packed):
    """Allocate a `Facets` that fits the robots of a batch."""
    n, m = packed.freedoms, packed.lines.shape[1]
    return Facets(
        structure_scratch(packed.general, m),
        np.zeros((m, n)),
        np.zeros((n, n)),
        np.zeros(m + 1, np.int64),
        np.zeros(n, np.int64),
        np.zeros((n, n)),
        np.zeros(n, np.int64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
    )


@jit
def capacity_at(packed, pose, half, length, work):
    """Return status code, capacity margin (N) and rank of the structure matrix at *pose*.

    The margin is the smallest over all wrenches within *half* (n,) of the platform's own. Moments are divided by
    *length*. Where A is rank-deficient the margin is measured within its column space, and a wrench outside that space
    has minus its distance from it as margin.
    """
    m, structure = packed.lines.shape[0], work.structure
    code = structure_at(packed, pose, structure)
    if code != OK:
        return code, -np.inf, 0
    table = structure.table
    n = free_rows(packed, table, structure.scale, m + 1)
    forces = 3 if n == packed.freedoms else 2
    for k in range(n):
        factor = 1.0 if k < forces else 1.0 / length
        structure.scale[k] *= factor
        for i in range(m + 1):
            table[i, k] *= factor
        for i in range(m):
            work.columns[i, k] = table[i, k]
        work.middle[k] = table[m, k]
        work.half[k] = free_side(packed, half, k) * factor
    track(table, m)
    rank, _ = reduce(table, structure.scale, structure.order, n, True)
    for i in range(n):
        for k in range(n):
            work.transform[i, k] = table[m + 1 + k, i]
    margin = -_aside(n, rank, work) if rank < n else 0.0
    if margin == 0.0:
        margin = _facets(packed, n, m, rank, work)
    return (OK if margin >= 0.0 else INFEASIBLE), margin, rank


@jit
def _aside(n, rank, work):
    """Largest distance (N) of a wrench from the column space of A, 0 if negligible; projects the transform onto it.

    The last n - rank rows of the transform are normal to all columns of A.
    """
    transform = work.transform
    for a in range(rank, n):
        for b in range(rank, a):
            _take_out(transform[a], transform[b], n)
        size = 0.0
        for k in range(n):
            size += transform[a, k] ** 2
        for k in range(n):
            transform[a, k] /= sqrt(size)
        for b in range(rank):
            _take_out(transform[b], transform[a], n)
    farthest, weight = 0.0, 0.0
    for k in range(n):
        weight = max(weight, abs(work.middle[k]) + work.half[k])
    for corner in range(1 << n):
        square = 0.0
        for a in range(rank, n):
            along = 0.0
            for k in range(n):
                side = work.half[k] if corner >> k & 1 else -work.half[k]
                along += transform[a, k] * (work.middle[k] + side)
            square += along * along
        farthest = max(farthest, sqrt(square))
    return farthest if farthest > ASIDE * weight else 0.0


@jit
def _take_out(vector, unit, n):
    """Subtract the component along *unit* from *vector*."""
    along = 0.0
    for k in range(n):
        along += vector[k] * unit[k]
    for k in range(n):
        vector[k] -= along * unit[k]


@jit
def _facets(packed, n, m, rank, work):
    """Smallest distance from the planes of all facets: one for each choice of m - rank + 1 lines not parallel to it."""
    chosen, size = work.chosen, m - rank + 1
    for k in range(size):
        chosen[k] = k
    margin = 1e300
    while True:
        held = 0
        while held < size and chosen[held] < rank:
            work.held[held] = chosen[held]
            held += 1
        _normal_shares(rank, m, size, held, work)
        margin = min(margin, _distance(packed, n, m, held, work))
        at = size - 1
        while at >= 0 and chosen[at] == m - size + at:
            at -= 1
        if at < 0:
            return margin
        chosen[at] += 1
        for k in range(at + 1, size):
            chosen[k] = chosen[k - 1] + 1


@jit
def _normal_shares(rank, m, size, held, work):
    """Write the shares of the held lines' rows of the transform whose sum is normal to all free lines not chosen."""
    table, share, rows = work.structure.table, work.share, work.held
    others, count, next_chosen = work.others, 0, held
    for j in range(rank, m):
        if next_chosen < size and work.chosen[next_chosen] == j:
            next_chosen += 1
        else:
            others[count] = j
            count += 1
    if held == 1:
        share[0] = 1.0
    elif held == 2:
        share[0], share[1] = table[others[0], rows[1]], -table[others[0], rows[0]]
    elif held == 3:
        p, q = others[0], others[1]
        a, b, c = rows[0], rows[1], rows[2]
        share[0] = table[p, b] * table[q, c] - table[p, c] * table[q, b]
        share[1] = table[p, c] * table[q, a] - table[p, a] * table[q, c]
        share[2] = table[p, a] * table[q, b] - table[p, b] * table[q, a]
    else:
        for e in range(held - 1):
            for k in range(held):
                work.system[e, k] = table[others[e], rows[k]]
        _null_vector(work.system, held, others, share)


@jit
def _null_vector(system, size, order, out):
    """Write a null vector of the (size - 1, size) *system* to *out*; *order* is scratch. Destroys the system."""
    for k in range(size):
        order[k] = k
    rank = 0
    while rank < size - 1:
        best, row, column = 0.0, rank, rank
        for i in range(rank, size - 1):
            for j in range(rank, size):
                if abs(system[i, j]) > best:
                    best, row, column = abs(system[i, j]), i, j
        if best == 0.0:
            break
        order[rank], order[column] = order[column], order[rank]
        for j in range(size):
            system[rank, j], system[row, j] = system[row, j], system[rank, j]
        for i in range(size - 1):
            system[i, rank], system[i, column] = system[i, column], system[i, rank]
        for i in range(size - 1):
            if i != rank:
                factor = system[i, rank] / system[rank, rank]
                for j in range(rank, size):
                    system[i, j] -= factor * system[rank, j]
        rank += 1
    for k in range(size):
        out[order[k]] = 0.0
    out[order[rank]] = 1.0
    for k in range(rank):
        out[order[k]] = -system[k, rank] / system[k, k]


@jit
def _distance(packed, n, m, held, work):
    """Smallest distance (N) of the wrenches from the two planes with the normal; 1e300 where there is no normal."""
    transform, A, normal = work.transform, work.columns, work.normal
    square, along, spread = 0.0, 0.0, 0.0
    for k in range(n):
        entry = 0.0
        for a in range(held):
            entry += work.share[a] * transform[work.held[a], k]
        normal[k] = entry
        square += entry * entry
        along += entry * work.middle[k]
        spread += abs(entry) * work.half[k]
    if not square > 0.0:
        return 1e300
    upper, lower = 0.0, 0.0
    for i in range(m):
        pull = 0.0
        for k in range(n):
            pull += normal[k] * A[i, k]
        low, high = pull * packed.lines[i, TENSION_MIN], pull * packed.lines[i, TENSION_MAX]
        upper += max(low, high)
        lower += min(low, high)
    return (min(upper - along, along - lower) - spread) / sqrt(square)


@jit(allocates=True)
def capacity_rows(packed, poses, half, length, margins, ranks, codes, first, last):
    """Write capacity margins (N), ranks and codes (N,) of poses (N, n); see `capacity_at`.

    *half* (n,): half sides of the box of wrenches about the platform's own, N and N m. Lines and platform of *packed*
    have one row or N each.
    """
    work = facet_scratch(packed)
    _capacity_each(packed, poses, half, length, margins, ranks, codes, first, last, work)


@jit
def _capacity_each(packed, poses, half, length, margins, ranks, codes, first, last, work):
    for j in range(first, last):
        codes[j], margins[j], ranks[j] = capacity_at(robot_view(packed, j), poses[j], half, length, work)
