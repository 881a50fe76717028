"""Small dense systems, solved in place."""

from cablewright.kernels import jit


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
