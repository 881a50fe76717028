"""Vibration modes of small systems, without allocation: Jacobi's method, started from the modes of a neighbour."""

from math import sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import cholesky

SWEEPS = 30
SMALL = 1e-12  # of the largest diagonal entry: an entry beside the diagonal that counts as none


@jit
def follow_modes(mass, stiffness, lower, system, vectors, shapes, values):
    """Write the modes of a pose: their *shapes* (f, f), columns of unit modal mass, and *values* (f,), (rad/s)^2.

    *mass* and *stiffness* (f, f): symmetric; the skew part of the latter is left out. *vectors* (f, f): those of a
    neighbouring pose, orthonormal, which become those of this one; the order of modes stays. *lower*, *system* (f, f):
    scratch. False for a mass that is not positive definite.
    """
    f = mass.shape[0]
    for i in range(f):
        for j in range(i + 1):
            lower[i, j] = 0.5 * (mass[i, j] + mass[j, i])
    if not cholesky(lower, f):
        return False
    for c in range(f):  # shapes: the transposed inverse of lower, times the vectors
        for i in range(f - 1, -1, -1):
            rest = vectors[i, c]
            for k in range(i + 1, f):
                rest -= lower[k, i] * shapes[k, c]
            shapes[i, c] = rest / lower[i, i]
    for c in range(f):
        for d in range(f):
            total = 0.0
            for i in range(f):
                for k in range(f):
                    total += shapes[i, c] * stiffness[i, k] * shapes[k, d]
            system[c, d] = total
    for c in range(f):
        for d in range(c):
            system[c, d] = system[d, c] = 0.5 * (system[c, d] + system[d, c])
    _diagonalise(system, vectors, shapes)
    for c in range(f):
        values[c] = system[c, c]
    return True


@jit
def _diagonalise(system, vectors, shapes):
    """Rotate pairs of columns of *vectors* and *shapes* (f, f) until the symmetric *system* is diagonal."""
    f = system.shape[0]
    for _ in range(SWEEPS):
        largest = beside = 0.0
        for i in range(f):
            largest = max(largest, abs(system[i, i]))
            for j in range(i):
                beside = max(beside, abs(system[i, j]))
        if not beside > SMALL * largest:
            return
        for i in range(f):
            for j in range(i):
                if system[i, j] != 0.0:
                    _rotate(system, vectors, shapes, i, j)


@jit
def _rotate(system, vectors, shapes, i, j):
    """Make the entry *i*, *j* of *system* zero by the smaller rotation of both axes (Golub and Van Loan 8.5.2)."""
    tau = (system[j, j] - system[i, i]) / (2.0 * system[i, j])
    t = 1.0 / (tau + sqrt(1.0 + tau * tau)) if tau >= 0.0 else 1.0 / (tau - sqrt(1.0 + tau * tau))
    c = 1.0 / sqrt(1.0 + t * t)
    s = t * c
    for k in range(system.shape[0]):
        system[k, i], system[k, j] = c * system[k, i] - s * system[k, j], s * system[k, i] + c * system[k, j]
    for k in range(system.shape[0]):
        system[i, k], system[j, k] = c * system[i, k] - s * system[j, k], s * system[i, k] + c * system[j, k]
        vectors[k, i], vectors[k, j] = c * vectors[k, i] - s * vectors[k, j], s * vectors[k, i] + c * vectors[k, j]
        shapes[k, i], shapes[k, j] = c * shapes[k, i] - s * shapes[k, j], s * shapes[k, i] + c * shapes[k, j]
