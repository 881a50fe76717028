"""Dense solve, rotations and the tension distribution against NumPy, SciPy and an LP."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog, minimize
from scipy.spatial.transform import Rotation

from cablewright.kernels import rotation
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.statics.tension_distribution import SOFT, Program, distribute


@pytest.mark.parametrize("n", range(1, 7))
def test_solve_is_numpys(n: int) -> None:
    rng = np.random.default_rng(n)
    matrix, rhs = rng.standard_normal((n, n)), rng.standard_normal((n, 3))
    wanted = np.linalg.solve(matrix, rhs)
    assert solve(matrix, rhs, n, 3)
    np.testing.assert_allclose(rhs, wanted, rtol=1e-9)


def test_a_singular_matrix_is_reported() -> None:
    assert not solve(np.zeros((3, 3)), np.ones((3, 1)), 3, 1)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 1e-3, 1.0, 3.1])
def test_rotations_are_scipys(size: float) -> None:
    rng = np.random.default_rng(7)
    vector = rng.standard_normal(3)
    vector *= size / np.linalg.norm(vector)
    out = np.zeros((3, 3))
    rotation.matrix(vector, out)
    np.testing.assert_allclose(out, Rotation.from_rotvec(vector).as_matrix(), atol=1e-15)
    turned = vector.copy()
    more = np.array([0.3, -0.2, 0.1])
    rotation.compose(*more, turned)
    wanted = (Rotation.from_rotvec(more) * Rotation.from_rotvec(vector)).as_matrix()
    np.testing.assert_allclose(Rotation.from_rotvec(turned).as_matrix(), wanted, atol=1e-14)


def distributed(structure, load, low, high, give=0.0):
    n, m = structure.shape
    tensions = np.zeros(m)
    program = Program(structure, load, low, high, np.ones(m), np.zeros(m))
    code = distribute(program, give, tensions, np.zeros(n), np.zeros((n, n)), np.zeros((n, 3)))
    return code, tensions


SHAPES = [(3, 3), (3, 4), (3, 6), (3, 8), (6, 6), (6, 7), (6, 8), (6, 12)]


@pytest.mark.parametrize(("n", "m"), SHAPES)
@pytest.mark.parametrize("lost", [0, 1])
def test_it_finds_tensions_where_an_lp_does_and_the_least_of_them(n: int, m: int, lost: int) -> None:
    rng = np.random.default_rng(100 * n + m + lost)
    feasible = 0
    for _ in range(60):
        structure = rng.standard_normal((n, m))
        if lost:  # of lower rank, like a robot that cannot resist yaw
            structure[-1] = structure[:-1].T @ rng.standard_normal(n - 1)
        inside = rng.uniform(0, 12, m)
        load = structure @ inside
        low, high = np.full(m, 1.0), np.full(m, 10.0)
        code, tensions = distributed(structure, load, low, high)
        lp = linprog(np.zeros(m), A_eq=structure, b_eq=load, bounds=list(zip(low, high, strict=True)), method="highs")
        assert code == (1 if lp.status == 0 else 0)
        if code == 1:
            feasible += 1
            np.testing.assert_allclose(structure @ tensions, load, atol=1e-8)
            assert (tensions >= low - 1e-9).all()
            assert (tensions <= high + 1e-9).all()
            assert optimal(structure, tensions, low, high)
    assert feasible > 2


def optimal(structure, tensions, low, high) -> bool:
    """Karush-Kuhn-Tucker: some multipliers make t = A' lambda on free lines and press the others on their limits."""
    free = (tensions > low + 1e-6) & (tensions < high - 1e-6)
    slack = 1e-6
    bounds = [
        (t - slack if is_free or at_high else -np.inf, t + slack if is_free or not at_high else np.inf)
        for t, is_free, at_high in zip(tensions, free, tensions > high - 1e-6, strict=True)
    ]
    A = np.vstack([structure.T, -structure.T])
    b = np.concatenate([[u for _, u in bounds], [-lo for lo, _ in bounds]])
    rows = np.isfinite(b)
    lp = linprog(np.zeros(len(structure)), A_ub=A[rows], b_ub=b[rows], bounds=(None, None), method="highs")
    return lp.status == 0


def test_where_there_are_none_it_breaks_the_limits_least() -> None:
    structure = np.array([[1.0, -1.0, 0.3, 0.1], [0.2, 0.1, 1.0, -1.0], [0.5, 0.6, 0.7, 0.8]])
    load, low, high = np.array([0.0, 0.0, 40.0]), np.full(4, 1.0), np.full(4, 10.0)
    assert distributed(structure, load, low, high)[0] == 0
    code, tensions = distributed(structure, load, low, high, SOFT)
    assert code == 1
    np.testing.assert_allclose(structure @ tensions, load, atol=1e-6)

    def violation(t):
        return np.sum(np.maximum(0, t - high) ** 2 + np.maximum(0, low - t) ** 2)

    best = minimize(violation, tensions, constraints={"type": "eq", "fun": lambda t: structure @ t - load})
    assert violation(tensions) < best.fun * 1.01 + 1e-9
