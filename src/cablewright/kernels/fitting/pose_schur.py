"""Least squares over unknowns shared by all poses and the poses themselves, eliminated by a Schur complement.

Levenberg-Marquardt: [U W^T; W V] (d, e) = (g, h), with V a block for each pose, so (U - W^T V^-1 W) d = g - W^T V^-1 h.
Its damping is Nielsen's (Damping parameter in Marquardt's method, 1999), but may fall faster: where unknowns are hardly
determined it settles, and few steps are rejected.
The cost of a step is linear in the number of poses. A pose moves in its p free directions: all n, or those in a plane.
Damping stays positive: undetermined unknowns keep their start.
Unknowns stay within bounds: steps are projected on them, and an unknown that the cost pushes out is held at its bound.
"""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import along_columns, cholesky, copy
from cablewright.kernels.fitting.calibration_residuals import RowReading, place_unknowns, read_row, reading
from cablewright.kernels.layout import NOT_CONVERGED, NOT_FINITE, OK
from cablewright.kernels.statics.platform import move_freely, place_platform

MIN_DAMPING, MAX_DAMPING = 1e-12, 1e12
FLOOR = 1e-30  # added to damped diagonal entries, so that a row of zeros has a pivot
ROUNDING = 1e-11  # relative change of the cost that may be rounding
NO_BETTER = 1e-8  # m: size of a step after which only rounding is left: it is the last


class StopRule(NamedTuple):
    """Stop criteria and initial damping of a least squares run."""

    step: float  # m, rad: a step all of whose entries are smaller ends the run
    fall: float  # relative decrease of the cost: a smaller one ends the run
    max_steps: int
    damping: float  # at the start


class Scratch(NamedTuple):
    """Working memory of one least squares run."""

    row: RowReading
    U: NDArray[np.float64]  # (k, k)
    S: NDArray[np.float64]  # (k, k)
    g: NDArray[np.float64]  # (k,)
    step: NDArray[np.float64]  # (k,)
    V: NDArray[np.float64]  # (N, p, p)
    W: NDArray[np.float64]  # (N, p, k)
    h: NDArray[np.float64]  # (N, p)
    L: NDArray[np.float64]  # (N, p, p)
    Y: NDArray[np.float64]  # (N, p, k)
    e: NDArray[np.float64]  # (N, p)
    theta: NDArray[np.float64]  # (k,)
    poses: NDArray[np.float64]  # (N, n)


@jit(allocates=True)
def scratch(rows, n, k):
    """Allocate a `Scratch` for *rows*, *n* coordinates of a pose and *k* unknowns."""
    poses, p = rows.start.shape[0] - 1, rows.freedoms
    return Scratch(
        reading(rows),
        np.zeros((k, k)),
        np.zeros((k, k)),
        np.zeros(k),
        np.zeros(k),
        np.zeros((poses, p, p)),
        np.zeros((poses, p, k)),
        np.zeros((poses, p)),
        np.zeros((poses, p, p)),
        np.zeros((poses, p, k)),
        np.zeros((poses, p)),
        np.zeros(k),
        np.zeros((poses, n)),
    )


@jit
def normal_equations(rows, free, theta, poses, values, weights, work):
    """Write U, V, W and the right sides g, h at *theta* and *poses*.

    Returns the cost, half the sum of squared weighted residuals; infinite where one is undefined.
    """
    total = 0.0
    place_unknowns(rows, theta, work.row)
    work.U[:, :], work.g[:] = 0.0, 0.0
    work.V[:, :, :], work.W[:, :, :], work.h[:, :] = 0.0, 0.0, 0.0
    in_plane = rows.freedoms < free.shape[0]
    for j in range(poses.shape[0] + 1):
        alone = j == poses.shape[0]
        pose = poses[0 if alone else j]
        place_platform(pose, work.row.rotation)
        for i in range(rows.start[j], values.shape[0] if alone else rows.start[j + 1]):
            if weights[i] > 0.0:
                off, count = read_row(rows, i, j, values[i], pose, work.row)
                total += (weights[i] * off) ** 2
                if in_plane:
                    along_columns(free, work.row.slope, work.row.turn)
                _add(work, j, count, weights[i] * weights[i], off, rows.freedoms, alone)
    for q in range(rows.linear.shape[0]):
        row = rows.linear[q]
        off = -rows.wanted[q]
        for a in range(theta.shape[0]):
            off += row[a] * theta[a]
        total += off * off
        for a in range(theta.shape[0]):
            work.g[a] -= row[a] * off
            for b in range(a + 1):
                work.U[a, b] += row[a] * row[b]
    return 0.5 * total if total < inf else inf


@jit
def _add(work, j, count, weight, off, n, alone):
    """Add one row to the normal equations; of U only the lower triangle is used."""
    gradient, index, slope = work.row.gradient, work.row.unknown, work.row.slope
    for p in range(count):
        a, one = index[p], weight * gradient[p]
        work.g[a] -= one * off
        for q in range(count):
            if index[q] <= a:
                work.U[a, index[q]] += one * gradient[q]
    if alone:
        return
    V, W, h = work.V[j], work.W[j], work.h[j]
    for c in range(n):
        one = weight * slope[c]
        h[c] -= one * off
        for d in range(c + 1):
            V[c, d] += one * slope[d]
        for p in range(count):
            W[c, index[p]] += one * gradient[p]


@jit
def reduce_poses(work, damping, k, n):
    """Eliminate all poses: write the Schur complement S, lower triangle, and right side to `step`.

    False if singular.
    """
    S, rhs = work.S, work.step
    copy(work.g, rhs)
    for a in range(k):
        for b in range(a + 1):
            S[a, b] = work.U[a, b]
        S[a, a] += damping * work.U[a, a] + FLOOR
    for j in range(work.V.shape[0]):
        V, L, Y, e = work.V[j], work.L[j], work.Y[j], work.e[j]
        for c in range(n):
            copy(V[c], L[c])
            L[c, c] += damping * V[c, c] + FLOOR
        if not cholesky(L, n):
            return False
        for c in range(n):
            row, total = Y[c], work.h[j, c]
            copy(work.W[j, c], row)
            for d in range(c):
                one, above = L[c, d], Y[d]
                total -= one * e[d]
                for a in range(k):
                    row[a] -= one * above[a]
            scale = 1.0 / L[c, c]
            e[c] = total * scale
            for a in range(k):
                row[a] *= scale
        c = 0
        while c + 3 <= n:  # three rows at a time: S is read and written a third as often
            _take_three(Y[c], Y[c + 1], Y[c + 2], e[c], e[c + 1], e[c + 2], S, rhs)
            c += 3
        while c < n:
            _take_one(Y[c], e[c], S, rhs)
            c += 1
    return True


@jit
def _take_three(first, second, third, e, f, g, S, rhs):
    """Subtract the products of three rows with each other from S, lower triangle, and with e, f and g from *rhs*."""
    for a in range(rhs.shape[0]):
        x, y, z, row = first[a], second[a], third[a], S[a]
        rhs[a] -= x * e + y * f + z * g
        if x != 0.0 or y != 0.0 or z != 0.0:
            for b in range(a + 1):
                row[b] -= x * first[b] + y * second[b] + z * third[b]


@jit
def _take_one(first, e, S, rhs):
    """As `_take_three`, of one row."""
    for a in range(rhs.shape[0]):
        x, row = first[a], S[a]
        rhs[a] -= x * e
        if x != 0.0:
            for b in range(a + 1):
                row[b] -= x * first[b]


@jit
def hold_at_bounds(limits, theta, work):
    """Remove unknowns that the cost pushes out of their bounds from the reduced equations."""
    for a in range(theta.shape[0]):
        if (theta[a] <= limits[0, a] and work.g[a] < 0.0) or (theta[a] >= limits[1, a] and work.g[a] > 0.0):
            for b in range(theta.shape[0]):
                work.S[a, b], work.S[b, a] = 0.0, 0.0
            work.S[a, a], work.step[a] = 1.0, 0.0


@jit
def _solve_reduced(S, step, k):
    """Solve S step = step in place by Cholesky; S is destroyed. False if it is not positive definite."""
    if not cholesky(S, k):
        return False
    for c in range(k):
        total = step[c]
        for s in range(c):
            total -= S[c, s] * step[s]
        step[c] = total / S[c, c]
    for c in range(k - 1, -1, -1):
        total = step[c]
        for s in range(c + 1, k):
            total -= S[s, c] * step[s]
        step[c] = total / S[c, c]
    return True


@jit
def _try_step(free, limits, theta, poses, damping, work):
    """Write unknowns and poses after the step to *work*. Returns its largest entry and the predicted cost decrease."""
    k, n = theta.shape[0], free.shape[1]
    largest, promised = 0.0, 0.0
    for a in range(k):
        moved = theta[a] + work.step[a]
        work.theta[a] = min(max(moved, limits[0, a]), limits[1, a])
        if work.theta[a] != moved:
            work.step[a] = work.theta[a] - theta[a]  # poses follow the projected step
        change = work.step[a]
        largest = max(largest, abs(change))
        promised += change * (work.g[a] + damping * work.U[a, a] * change)
    for j in range(poses.shape[0]):
        L, e = work.L[j], work.e[j]
        for c in range(n - 1, -1, -1):  # L^T e_new = e - Y d, with e from `reduce_poses`
            total = e[c]
            for a in range(k):
                total -= work.Y[j, c, a] * work.step[a]
            for s in range(c + 1, n):
                total -= L[s, c] * e[s]
            e[c] = total / L[c, c]
        for c in range(n):
            largest = max(largest, abs(e[c]))
            promised += e[c] * (work.h[j, c] + damping * work.V[j, c, c] * e[c])
        move_freely(free, poses[j], e, work.poses[j])
    return largest, 0.5 * promised


@jit
def less_damping(gain):
    """Return the factor of the damping after an accepted step, by the ratio of the real and the predicted decrease."""
    return max(1.0 / 30.0, 1.0 - (2.0 * gain - 1.0) ** 3)


@jit
def adjust(rows, free, limits, theta, poses, values, weights, settings, work):
    """Move the unknowns *theta* (k,) and *poses* (N, n) to the nearest minimum of the cost.

    Returns a code, the number of steps and the cost.
    """
    k, n = theta.shape[0], rows.freedoms
    now = normal_equations(rows, free, theta, poses, values, weights, work)
    if not now < inf:
        return NOT_FINITE, 0, inf
    damping, growth, steps = settings.damping, 2.0, 1
    for _ in range(settings.max_steps):
        regular = reduce_poses(work, damping, k, n)
        hold_at_bounds(limits, theta, work)
        if not (regular and _solve_reduced(work.S, work.step, k)):
            damping = max(10.0 * damping, MIN_DAMPING)
            if damping > MAX_DAMPING:
                return NOT_CONVERGED, steps, now
            continue
        size, promised = _try_step(free, limits, theta, poses, damping, work)
        then = normal_equations(rows, free, work.theta, work.poses, values, weights, work)
        if then <= now or (size < NO_BETTER and then <= (1.0 + ROUNDING) * now):
            gain = (now - then) / promised if promised > ROUNDING * now else 1.0
            fell = now - then
            copy(work.theta, theta)
            for j in range(poses.shape[0]):
                copy(work.poses[j], poses[j])
            done = size < settings.step or fell <= settings.fall * now
            now = then
            if done:
                return OK, steps, now
            steps, growth = steps + 1, 2.0
            damping = max(damping * less_damping(gain), MIN_DAMPING)
        else:
            if size < NO_BETTER:
                return OK, steps, now
            damping, growth = growth * damping, 2.0 * growth
            if damping > MAX_DAMPING:
                return NOT_CONVERGED, steps, now
            normal_equations(rows, free, theta, poses, values, weights, work)
    return NOT_CONVERGED, steps, now


@jit(allocates=True)
def adjust_runs(rows, free, limits, theta, poses, values, weights, settings, codes, steps, costs):
    """Run `adjust` for B starts or sets of values.

    theta (B, k), poses (B, N, n), values, weights (B or 1, R); writes codes, steps, costs (B,). *free* (n, p): an
    orthonormal basis of the directions in which poses are free. *limits* (2, k): min and max of the unknowns. They are
    an argument of their own, since the rows are passed on for every reading.
    """
    work = scratch(rows, poses.shape[2], theta.shape[1])
    for run in range(theta.shape[0]):
        own, weight = values[run % values.shape[0]], weights[run % weights.shape[0]]
        codes[run], steps[run], costs[run] = adjust(
            rows, free, limits, theta[run], poses[run], own, weight, settings, work
        )
