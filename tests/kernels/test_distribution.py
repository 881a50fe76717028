"""The reduced structure, the largest margin, null vectors of random lines, against numpy and HiGHS: any m, any rank."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.kernels.wrench_feasibility.capacity_margin import _null_vector
from cablewright.kernels.wrench_feasibility.structure_matrix import reduce, structure_scratch, track
from cablewright.kernels.wrench_feasibility.tension_margin import exchange_scratch, widest
from cases import often
from oracles import linear_program

SHAPES = [(3, 1), (3, 3), (3, 4), (3, 5), (3, 9), (6, 4), (6, 6), (6, 7), (6, 8), (6, 9), (6, 12), (6, 20)]


def reduced(A: np.ndarray, w: np.ndarray, tracked: bool = False):
    n, m = A.shape
    work = structure_scratch(None, m)
    work.table[:m, :n] = A.T
    work.table[m, :n] = -w
    if tracked:
        track(work.table, m)
    rank, balanced = reduce(work.table, work.scale, work.order, n, tracked)
    return work, rank, balanced


def random_lines(rng: np.random.Generator, n: int, m: int, lost: int) -> np.ndarray:
    A = rng.standard_normal((n, m))
    for k in range(lost):
        A[-1 - k] = rng.standard_normal(n - lost) @ A[: n - lost]
    return A


@pytest.mark.parametrize(("n", "m"), SHAPES)
@pytest.mark.parametrize("lost", [0, 1, 2])
def test_the_reduced_structure_has_all_solutions(n: int, m: int, lost: int) -> None:
    rng = np.random.default_rng(1000 * n + 10 * m + lost)
    A = random_lines(rng, n, m, lost)
    w = -A @ rng.uniform(0.0, 10.0, m)
    work, rank, balanced = reduced(A, w, tracked=True)
    assert rank == np.linalg.matrix_rank(A)
    assert balanced
    tensions = np.zeros(m)
    tensions[work.order[rank:]] = rng.uniform(-5.0, 5.0, m - rank)
    free = tensions[work.order[rank:]]
    tensions[work.order[:rank]] = work.table[m, :rank] - free @ work.table[rank:m, :rank]
    np.testing.assert_allclose(A @ tensions, -w, atol=1e-9)
    done = work.table[m + 1 : m + 1 + n, :n].T
    np.testing.assert_allclose((done @ A)[:rank, work.order[:rank]], np.eye(rank), atol=1e-9)
    np.testing.assert_allclose((done @ A)[rank:], 0.0, atol=1e-9)
    if rank < n:
        assert not reduced(A, w + np.linalg.svd(A)[0][:, -1])[2]


@pytest.mark.parametrize(("n", "m"), SHAPES)
@pytest.mark.parametrize("kind", ["random", "narrow", "whole numbers"])
@pytest.mark.parametrize("lost", [0, 1])
def test_the_largest_margin_is_the_linear_programs(n: int, m: int, kind: str, lost: int) -> None:
    rng = np.random.default_rng(1000 * n + 10 * m + lost + len(kind))
    for _ in range(often(6, 12)):
        A = random_lines(rng, n, m, lost)
        if kind == "whole numbers":  # ties at every step
            A = np.round(A)
            A[-lost:] = A[0] if lost else A[-lost:]
        low = rng.uniform(0.0, 5.0, m)
        high = low + rng.uniform(0.5, 20.0, m)
        if kind == "narrow":  # lines that cannot be in the middle, and one that hardly may move
            high[0] = low[0] + 1e-3
        if kind == "whole numbers":
            low, high = np.full(m, 1.0), np.full(m, 9.0)
        w = -A @ rng.uniform(-2.0, 12.0, m)
        work, rank, balanced = reduced(A, w)
        assert balanced
        exchange = exchange_scratch(m)
        exchange.middle[:] = (0.5 * (low + high))[work.order]
        exchange.half[:m] = (0.5 * (high - low))[work.order]
        margin, sure = widest(work.table, rank, m, exchange)
        assert sure
        wanted = linear_program.margin(A, w, low, high)
        assert margin == pytest.approx(wanted, rel=1e-9, abs=1e-9)
        tensions = np.zeros(m)
        tensions[work.order] = exchange.middle + exchange.shift[:m]
        np.testing.assert_allclose(A @ tensions, -w, atol=1e-9 * max(1.0, np.abs(tensions).max()))
        assert np.minimum(tensions - low, high - tensions).min() == pytest.approx(margin, abs=1e-9)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("lost", [0, 1])
def test_a_null_vector_is_one(size: int, lost: int) -> None:
    rng = np.random.default_rng(size)
    system = np.zeros((6, 6))
    system[: size - 1, :size] = rng.standard_normal((size - 1, size))
    if lost and size > 2:
        system[0] = 2.0 * system[size - 2]
    kept, out = system.copy(), np.zeros(6)
    _null_vector(system, size, np.zeros(6, np.int64), out)
    assert np.abs(out).max() >= 1.0
    np.testing.assert_allclose(kept[: size - 1] @ out, 0.0, atol=1e-12)
