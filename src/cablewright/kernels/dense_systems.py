"""Small dense arrays without allocation: copies, sizes, linear systems, and the smallest pivot of a stiffness."""

from math import sqrt

from cablewright.kernels import jit


@jit
def copy(source, target):
    """Copy the vector *source* to *target*."""
    for k in range(target.shape[0]):
        target[k] = source[k]


@jit
def copy_rows(source, target):
    """Copy the table *source* to *target*.

    Numba's assignment of one array to another also looks whether they overlap or fit, with much more code.
    """
    for j in range(target.shape[0]):
        for k in range(target.shape[1]):
            target[j, k] = source[j, k]


@jit
def along_columns(basis, vector, scratch):
    """Replace the first n entries of *vector* by its p components along the columns of *basis* (n, p)."""
    n, p = basis.shape
    for c in range(p):
        scratch[c] = 0.0
        for k in range(n):
            scratch[c] += basis[k, c] * vector[k]
    for c in range(p):
        vector[c] = scratch[c]


@jit
def solve(matrix, rhs, n, columns):
    """Solve matrix[:n, :n] X = rhs[:n, :columns] in place (LU with row pivoting). False if singular."""
    for k in range(n):
        pivot = k
        largest = abs(matrix[k, k])
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > largest:
                largest = abs(matrix[i, k])
                pivot = i
        if not largest > 0.0:
            return False
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(columns):
                rhs[k, j], rhs[pivot, j] = rhs[pivot, j], rhs[k, j]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                for j in range(columns):
                    rhs[i, j] -= factor * rhs[k, j]
    for k in range(n - 1, -1, -1):
        inverse = 1.0 / matrix[k, k]
        for j in range(columns):
            total = rhs[k, j]
            for i in range(k + 1, n):
                total -= matrix[k, i] * rhs[i, j]
            rhs[k, j] = total * inverse
    return True


@jit
def cholesky(matrix, n):
    """Replace the lower triangle of matrix[:n, :n] by its Cholesky factor. False if not positive definite."""
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i != j:
                matrix[i, j] = total / matrix[j, j]
            elif total > 0.0:
                matrix[i, i] = sqrt(total)
            else:
                return False
    return True


@jit
def largest(vector, n):
    """Return the largest absolute value of vector[:n]; a NaN counts as infinite."""
    size = 0.0
    for k in range(n):
        entry = abs(vector[k])
        if not entry <= size:
            size = entry if entry == entry else 1e300
    return size


@jit
def largest_of_column(columns, n):
    """Return `largest` of the first column, columns[:n, 0]."""
    size = 0.0
    for k in range(n):
        entry = abs(columns[k, 0])
        if not entry <= size:
            size = entry if entry == entry else 1e300
    return size


@jit
def min_pivot(matrix, n):
    """Smallest pivot of the symmetric part of matrix[:n, :n], as a share of the largest diagonal entry of its kind.

    Positive means positive definite. The first three rows are of one kind (forces), the rest of another (moments).
    Destroys the matrix. Elimination stops at the first pivot that is not positive, which is returned with its sign.
    """
    forces, moments = 1e-300, 1e-300
    for i in range(n):
        for j in range(i):
            matrix[i, j] = 0.5 * (matrix[i, j] + matrix[j, i])
        if i < 3:
            forces = max(forces, abs(matrix[i, i]))
        else:
            moments = max(moments, abs(matrix[i, i]))
    smallest = 1.0
    for k in range(n):
        pivot = matrix[k, k]
        smallest = min(smallest, pivot / (forces if k < 3 else moments))
        if not pivot > 0.0:
            return smallest
        for i in range(k + 1, n):
            factor = matrix[i, k] / pivot
            for j in range(k + 1, i + 1):
                matrix[i, j] -= factor * matrix[j, k]
    return smallest
