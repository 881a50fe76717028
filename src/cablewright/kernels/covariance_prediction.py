"""Prediction of the covariance matrix of a filter's state, in place."""

from cablewright.kernels import jit


@jit
def add_multiples(P, to, source, weights):
    """Predict the covariance *P* (n, n) after states x[to:] grow by *weights* (a, b) times states x[source:].

    One after another: where the a and the b overlap, later ones grow by the new values of earlier ones.
    """
    n, (rows, columns) = P.shape[0], weights.shape
    for i in range(rows):
        for k in range(columns):
            weight = weights[i, k]
            if weight != 0.0:
                for j in range(n):
                    P[to + i, j] += weight * P[source + k, j]
    for i in range(rows):
        for k in range(columns):
            weight = weights[i, k]
            if weight != 0.0:
                for j in range(n):
                    P[j, to + i] += weight * P[j, source + k]
