"""Updates of a Kalman filter's state and covariance by one measurement, in Joseph's form."""

from math import exp, inf

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import solve

# Parts of the state, in the order of their first indices, `at`; the last is the size of the state.
POSITION, VELOCITY, ATTITUDE, LENGTHS, RADII, GYRO, ACCELEROMETER, RANGES, GROUND = 0, 1, 2, 3, 4, 5, 6, 7, 8
STRETCH, WALLS, MOUNTS, VERTICAL, ZEROS, COMPLIANCES, CLOCK, SIZE = 9, 10, 11, 12, 13, 14, 15, 16

MOST_RADIUS = 0.2  # largest correction of a radius, ...
MOST_COMPLIANCE = 0.5  # ... and of a compliance, as logarithms


@jit(allocates=True)
def entering(H):
    """Return the indices of the states that a measurement with the matrix *H* (k, n) depends on."""
    k, n = H.shape
    found, count = np.empty(n, np.int64), 0
    for j in range(n):
        for a in range(k):
            if H[a, j] != 0.0:
                found[count] = j
                count += 1
                break
    return found[:count]


@jit(allocates=True)
def project(P, H, R, used, S):
    """Return the covariances (k, n) of a measurement with the state, and write *S* (k, k), that of its innovation.

    *H* (k, n) is 0 except in the columns *used*; *R* (k, k): noise.
    """
    k, n = H.shape
    PH = np.zeros((k, n))
    for a in range(k):
        for j in used:
            for i in range(n):
                PH[a, i] += H[a, j] * P[j, i]
    for a in range(k):
        for b in range(k):
            total = 0.0
            for j in used:
                total += H[b, j] * PH[a, j]
            S[b, a] = total + R[b, a]
    return PH


@jit(allocates=True)
def size_of(P, H, innovation, R):
    """Return the squared Mahalanobis distance of an *innovation* (k,); infinity where its covariance is 0."""
    k = H.shape[0]
    S, solved = np.empty((k, k)), np.empty((k, 1))
    project(P, H, R, entering(H), S)
    for a in range(k):
        solved[a, 0] = innovation[a]
    if not solve(S, solved, k, 1):
        return inf
    total = 0.0
    for a in range(k):
        total += innovation[a] * solved[a, 0]
    return total


@jit(allocates=True)
def correct(P, H, innovation, R, spread, considered, correction):
    """Update the covariance *P* (n, n) by a measurement, and write the *correction* (n,) of the state.

    *H* (k, n), *innovation* (k,), *R* (k, k). *spread* (k, k), or empty: covariance of several innovations that may be,
    whose mean is the given one. *considered* (n,), or empty: states that are not corrected. Nothing changes, and the
    correction is 0, where the covariance of the innovation is singular.
    """
    k, n = H.shape
    S, W, own, used = np.empty((k, k)), np.empty(k), R.copy(), entering(H)
    PH = project(P, H, R, used, S)
    K = PH.copy()
    for i in range(n):
        correction[i] = 0.0
    if not solve(S, K, k, n):
        return
    for i in range(considered.shape[0]):
        for a in range(k):
            K[a, i] = 0.0 if considered[i] else K[a, i]
    for a in range(spread.shape[0]):
        for b in range(k):
            own[a, b] += spread[a, b]
    for i in range(n):
        for a in range(k):
            correction[i] += K[a, i] * innovation[a]
            for j in range(n):
                P[i, j] -= K[a, i] * PH[a, j]
        for a in range(k):
            W[a] = 0.0
            for j in used:
                W[a] += P[i, j] * H[a, j]
            for b in range(k):
                W[a] -= K[b, i] * own[b, a]
        for a in range(k):
            for j in range(n):
                P[i, j] -= W[a] * K[a, j]
    for i in range(n):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])


@jit
def inject(x, at, correction):
    """Add a *correction* of the error state to the state *x*, both (n,).

    The corrections of radii and compliances are relative.
    """
    for i in range(x.shape[0]):
        x[i] += correction[i]
    for i in range(at[RADII], at[GYRO]):
        x[i] = (x[i] - correction[i]) * exp(min(max(correction[i], -MOST_RADIUS), MOST_RADIUS))
    for i in range(at[COMPLIANCES], at[CLOCK]):
        x[i] = (x[i] - correction[i]) * exp(min(max(correction[i], -MOST_COMPLIANCE), MOST_COMPLIANCE))


@jit(allocates=True)
def update(x, P, at, H, innovation, R, spread, considered):
    """Update the state *x* (n,) and its covariance *P* (n, n) by a measurement, as `correct`."""
    correction = np.empty(x.shape[0])
    correct(P, H, innovation, R, spread, considered, correction)
    inject(x, at, correction)
