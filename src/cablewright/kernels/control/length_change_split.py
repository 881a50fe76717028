"""Least squares by Householder's reflections: the part of changes of cable lengths that moves the platform."""

from math import sqrt

from cablewright.kernels import jit

DEPENDENT = 1e-12  # of the largest pivot: a column below that depends on those before it


@jit
def split(work, moving, motion):
    """Divide a change of cable lengths into the part that moves the platform and the rest.

    Writes that part, *moving* (m,), and the *motion* (p,). *work* (m, p + 1): gradients of the lengths by the motions,
    and the change; it is overwritten. *motion* is the least squares solution of gradients times motion = change, with 0
    for a motion that depends on those before.
    """
    m, all_columns = work.shape
    last = all_columns - 1
    p, largest = min(last, m), 0.0
    motion[p:] = 0.0
    for k in range(p):
        square = 0.0
        for i in range(k, m):
            square += work[i, k] * work[i, k]
        pivot = -sqrt(square) if work[k, k] >= 0.0 else sqrt(square)
        largest = max(largest, abs(pivot))
        motion[k] = pivot
        if pivot == 0.0:
            continue
        work[k, k] -= pivot  # the reflection is I - v v' / (-pivot v_k)
        scale = -1.0 / (pivot * work[k, k])
        for j in range(k + 1, all_columns):
            _reflect(work, k, scale, j)
    for k in range(p - 1, -1, -1):  # back through the upper triangle, whose diagonal is in motion
        left = work[k, last]
        for j in range(k + 1, p):
            left -= work[k, j] * motion[j]
        motion[k] = left / motion[k] if abs(motion[k]) > DEPENDENT * largest else 0.0
    for i in range(p, m):
        work[i, last] = 0.0
    for k in range(p - 1, -1, -1):
        square = 0.0
        for i in range(k, m):
            square += work[i, k] * work[i, k]
        if square > 0.0:
            _reflect(work, k, 2.0 / square, last)
    for i in range(m):
        moving[i] = work[i, last]


@jit
def _reflect(work, k, scale, column):
    """Apply to a *column* of *work* the reflection whose vector is column *k* from row k on."""
    along = 0.0
    for i in range(k, work.shape[0]):
        along += work[i, k] * work[i, column]
    along *= scale
    for i in range(k, work.shape[0]):
        work[i, column] -= along * work[i, k]
