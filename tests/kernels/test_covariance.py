"""Predictions of a covariance, against products of whole matrices."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.kernels.covariance_prediction import add_multiples


@pytest.mark.parametrize(("to", "source", "shape"), [(0, 3, (3, 4)), (5, 1, (2, 4)), (6, 0, (1, 1))])
def test_it_is_the_product_of_whole_matrices(to: int, source: int, shape: tuple[int, int]) -> None:
    random = np.random.default_rng(to)
    root, weights = random.standard_normal((7, 7)), random.standard_normal(shape)
    before = root @ root.T
    F = np.eye(7)
    F[to : to + shape[0], source : source + shape[1]] += weights
    P = before.copy()
    add_multiples(P, to, source, weights)
    np.testing.assert_allclose(P, F @ before @ F.T, rtol=1e-13, atol=1e-13)


def test_states_that_grow_by_each_other_do_so_one_after_another() -> None:
    """By a small turn two axes are turned, up to its square, and their covariance keeps its determinant."""
    turn, before = 1e-4, np.array([[2.0, 0.3], [0.3, 1.0]])
    c, s = np.cos(turn), np.sin(turn)
    F = np.array([[c, s], [-s, c]])
    P = before.copy()
    add_multiples(P, 0, 0, np.array([[0.0, turn], [-turn, 0.0]]))
    np.testing.assert_allclose(P, F @ before @ F.T, atol=4.0 * turn**2)
    assert np.linalg.det(P) == pytest.approx(np.linalg.det(before), rel=1e-13)
    assert (P == P.T).all()
