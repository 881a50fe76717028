"""Sagging lines in the filter, with the platform point B at one position: sag, stiffness, possible forces."""

from math import atan, cos, exp, inf, log, nan, tan

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy_rows, solve
from cablewright.kernels.filtering.estimate import excess_of
from cablewright.kernels.filtering.update import CLOCK, COMPLIANCES
from cablewright.kernels.layout import SPANS, WEIGHT
from cablewright.kernels.statics.taut import SOFTNESS, STRETCH, soften

# Rows of the laws of lines: N^2 m; m/N; N at the sensor; slope of the straight line, negative downwards; angle, rad.
SAGGING, STRETCHING, RISING, SLOPE, ANGLE = 0, 1, 2, 3, 4
LAWS = 5

FORCES = 160  # of the table by which an excess gives the horizontal force ...
LEAST_FORCE, MOST_FORCE = 0.2, 2e4  # ... in N

FREE = 1e-14  # of the largest pivot of a stiffness: one that is rounding alone

PLACES = 80  # in the range of the unknown force
REFINEMENTS = 4
ENOUGH = 10  # likely forces
UNLIKELY = 12.0  # twice the logarithm of a likelihood below the largest
LEAST_SHARE = 1e-4  # of the range of the unknown force
SHAPE_ERROR = 0.01  # of an angle near the platform: no line is a parabola
SLACK_ERROR = 0.03  # of the excess of one

# Standard deviations of measurements by angles: share of the stretch, m, rad, rad; and how often one error repeats.
BY_STRETCH, BY_EXCESS, BY_ANGLE, BY_ZERO, REPEATS = 0, 1, 2, 3, 4


@jit(allocates=True)
def laws_of(lines, angles, free, lengths, toward, compliances, from_platform, laws):
    """Write the force-length *laws* (LAWS, m) of *lines* (m, COLUMNS) from their straight shapes, see `taut.draw`.

    *compliances* (m,): shares of those described; *from_platform*: distance of the sensors along the cable, m.
    """
    m = lines.shape[0]
    softness = np.empty((m, SOFTNESS))
    soften(lines, lengths, toward, softness)
    for i in range(m):
        c, weight = cos(angles[i]), lines[i, WEIGHT]
        laws[SAGGING, i] = lines[i, SPANS] * (weight * free[i] * c**2) ** 2 * free[i] / 24.0
        laws[STRETCHING, i] = compliances[i] * softness[i, STRETCH] / c
        laws[RISING, i] = weight * (0.5 * free[i] - from_platform)
        laws[SLOPE, i] = tan(angles[i])
        laws[ANGLE, i] = angles[i]


@jit
def force_at(laws, i, excess):
    """Return the horizontal force, N, of line *i* with an *excess* length, m, from a table with `FORCES` rows."""
    step = log(MOST_FORCE / LEAST_FORCE) / (FORCES - 1)
    low, high = 0, FORCES - 1
    if excess >= _excess(laws, i, LEAST_FORCE):
        return LEAST_FORCE
    if excess <= _excess(laws, i, MOST_FORCE):
        return MOST_FORCE
    while high - low > 1:
        middle = (low + high) // 2
        if _excess(laws, i, LEAST_FORCE * exp(step * middle)) > excess:
            low = middle
        else:
            high = middle
    below, above = LEAST_FORCE * exp(step * low), LEAST_FORCE * exp(step * high)
    first, last = _excess(laws, i, below), _excess(laws, i, above)
    return below + (above - below) * (first - excess) / (first - last)


@jit
def forces_of(laws, excess, forces):
    """Write the horizontal *forces* (m,), N, of lines with an *excess* (m,) of length, m."""
    for i in range(excess.shape[0]):
        forces[i] = force_at(laws, i, excess[i])


@jit
def _excess(laws, i, force):
    """Return the excess, m, of line *i* by its horizontal *force*, N."""
    return laws[SAGGING, i] / force**2 - laws[STRETCHING, i] * force


@jit(allocates=True)
def soften_at(
    lines, hung, angles, free, lengths, toward, compliances, laws, excess, stiffness, jacobian, by_compliance
):
    """Write how point B moves with the cable lengths, for lines with an *excess* (m,), m, and the laws of `laws_of`.

    *hung* (m,): lines with a counterweight, which do not stiffen. *stiffness* (3, 3), N/m, of all lines at B;
    *jacobian* (3, m): motion of B per length; *by_compliance* (3, m): per excess and logarithm of a compliance. Returns
    whether lines hold B in every direction: if not, none of these is valid.
    """
    m = lines.shape[0]
    softness, own, solved = np.empty((m, SOFTNESS)), np.empty(m), np.empty((3, m))
    soften(lines, lengths, toward, softness)
    for i in range(m):
        c, h = cos(angles[i]), force_at(laws, i, excess[i])
        sag = lines[i, SPANS] * (lines[i, WEIGHT] * c) ** 2 * free[i] ** 3 / (12.0 * h**3)
        stretching = compliances[i] * softness[i, STRETCH]
        own[i] = 0.0 if hung[i] else 1.0 / (stretching + sag + 1e-12)
        for k in range(3):
            solved[k, i] = toward[i, k] * own[i]
    work = np.zeros((3, 3))
    for i in range(m):
        for k in range(3):
            for j in range(3):
                work[k, j] += solved[k, i] * toward[i, j]
    copy_rows(work, stiffness)
    if not solve(work, solved, 3, m):
        return False
    pivots = abs(work[0, 0]), abs(work[1, 1]), abs(work[2, 2])
    for i in range(m):
        for k in range(3):
            jacobian[k, i] = solved[k, i]
            by_compliance[k, i] = -solved[k, i] * own[i] * compliances[i] * softness[i, STRETCH]
    return min(pivots) > FREE * max(pivots)


@jit(allocates=True)
def hang(lines, x, at, hung, from_platform, there, angles, free, lengths, toward, laws, jacobian, by_compliance):
    """Write the laws of sagging lines with point B at *there* (3,), m, and how B moves with their lengths.

    *x* (n,): the state, with its parts from *at* on; all others as of `laws_of` and `soften_at`. Returns the motion
    (3,) of B, m/N, per force upwards; NaN where lines do not hold B in every direction.
    """
    excess, stiffness, own = np.empty(lines.shape[0]), np.empty((3, 3)), x[at[COMPLIANCES] : at[CLOCK]]
    laws_of(lines, angles, free, lengths, toward, own, from_platform, laws)
    excess_of(x, at, lengths, toward, there, excess)
    solved, rising = np.zeros((3, 1)), np.empty(3)
    solved[2, 0] = 1.0
    held = soften_at(lines, hung, angles, free, lengths, toward, own, laws, excess, stiffness, jacobian, by_compliance)
    held = held and solve(stiffness, solved, 3, 1)
    for k in range(3):
        rising[k] = solved[k, 0] if held else nan
    return rising


@jit
def share_at(place):
    """Map *place*, from 0 to 1, to a share of a range, with more points near both ends, where a line is slack."""
    near = min(place, 1.0 - place)
    share = LEAST_SHARE * (0.5 / LEAST_SHARE) ** (2.0 * near)
    return share if place <= 0.5 else 1.0 - share


@jit(allocates=True)
def weigh_forces(laws, may_be, unsure, known, now, measured, sigmas, mean, noise, spread, forces):
    """Write mean and covariance of the innovations of m excesses and j angles, averaged over all possible forces.

    *may_be* (2, m), N: first horizontal forces and their change over the range; *unsure* (2, m, q): how both change
    with q numbers of standard deviation 1. *known* (m + j, m + j): covariance by the state; *now* (m,), m, the excess.
    *measured* (j, 4): line, angle, variance and zero. *mean* (m + j,), *noise*, *spread* (m + j, m + j), *forces* (m,),
    N. The grid of forces is refined until several of them are about as likely. Returns the normalised square of the
    likeliest one.
    """
    m, d, last = now.shape[0], known.shape[0], PLACES - 1
    at, shares, cost, sizes = np.empty(PLACES), np.empty(PLACES), np.empty(PLACES), np.empty(PLACES)
    off, own, h = np.empty((PLACES, d)), np.empty((PLACES, d, d)), np.empty((PLACES, m))
    low, high = 0.0, 1.0
    for _ in range(REFINEMENTS):
        for p in range(PLACES):
            at[p] = low + p * (high - low) / last
            shares[p] = share_at(at[p])
        for p in range(PLACES):
            sizes[p], cost[p] = _judge(
                laws, may_be, unsure, known, now, measured, sigmas, shares[p], h[p], off[p], own[p]
            )
            before, after = max(p - 1, 0), min(p + 1, last)
            cost[p] -= 2.0 * log((shares[after] - shares[before]) / (after - before))
        best = cost.min()
        first, final, count = last, 0, 0
        for p in range(PLACES):
            if cost[p] <= best + UNLIKELY:
                first, final, count = min(first, p), p, count + 1
        if count >= ENOUGH:
            break
        low, high = at[max(first - 1, 0)], at[min(final + 1, last)]
    total = 0.0
    for p in range(PLACES):
        cost[p] = exp(-0.5 * (cost[p] - best))
        total += cost[p]
    for a in range(d):
        mean[a] = 0.0
        for p in range(PLACES):
            mean[a] += cost[p] / total * off[p, a]
    for i in range(m):
        forces[i] = 0.0
        for p in range(PLACES):
            forces[i] += cost[p] / total * h[p, i]
    for a in range(d):
        for b in range(d):
            noise[a, b] = spread[a, b] = 0.0
            for p in range(PLACES):
                noise[a, b] += cost[p] / total * own[p, a, b]
                spread[a, b] += cost[p] / total * (off[p, a] - mean[a]) * (off[p, b] - mean[b])
    return sizes.min()


@jit(allocates=True)
def _judge(laws, may_be, unsure, known, now, measured, sigmas, share, h, off, noise):
    """Write forces *h* (m,), N, at a *share* of their range, innovations *off* (m + j,) by them, and the *noise*.

    Returns the normalised square of the innovations, and twice its negative logarithm of likelihood.
    """
    m, d, q = now.shape[0], known.shape[0], unsure.shape[2]
    slopes, S, solved, by_zeros = np.empty(d), np.empty((d, d)), np.empty((d, 1)), 0.0
    moved = np.empty((d, q))
    for i in range(m):
        h[i] = may_be[0, i] + share * may_be[1, i]
        slack, stretch = laws[SAGGING, i] / h[i] ** 2, laws[STRETCHING, i] * h[i]
        off[i] = slack - stretch - now[i]
        slopes[i] = 2.0 * slack / h[i] + laws[STRETCHING, i]
        S[i, 0] = (sigmas[REPEATS] * sigmas[BY_STRETCH] * stretch) ** 2
        S[i, 0] += sigmas[BY_EXCESS] ** 2 + (SLACK_ERROR * slack) ** 2
        for c in range(q):
            moved[i, c] = slopes[i] * (unsure[0, i, c] + share * unsure[1, i, c])
    for a in range(m, d):
        i = int(measured[a - m, 0])
        steep = laws[SLOPE, i] + laws[RISING, i] / h[i]
        difference = atan(steep) - laws[ANGLE, i]
        off[a] = measured[a - m, 1] - difference
        slopes[a] = -laws[RISING, i] / (h[i] ** 2 * (1.0 + steep**2))
        own = sigmas[BY_ANGLE] ** 2 + measured[a - m, 2]
        S[a, 0] = own + (sigmas[REPEATS] * SHAPE_ERROR * difference) ** 2
        for c in range(q):
            moved[a, c] = slopes[a] * (unsure[0, i, c] + share * unsure[1, i, c])
        if sigmas[BY_ZERO] > 0.0:  # zeros do not wander off step by step from those of the owner
            by_zeros += (off[a] + measured[a - m, 3]) ** 2 / (sigmas[BY_ZERO] ** 2 + own)
    for a in range(d):
        solved[a, 0] = off[a]
        for b in range(d):
            noise[a, b] = S[a, 0] if a == b else 0.0
            for c in range(q):
                noise[a, b] += moved[a, c] * moved[b, c]
    for a in range(d):
        for b in range(d):
            S[a, b] = known[a, b] + noise[a, b]
    if not solve(S, solved, d, 1):
        return inf, inf
    size, cost = 0.0, 0.0
    for a in range(d):
        size += off[a] * solved[a, 0]
        cost += log(abs(S[a, a]))
    return size, size + cost + by_zeros
