"""Kernels of the filter against whole matrices, and against grids of forces computed by NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.kernels.filtering import sagging_lines, smoothed_line_angles, wall_matches
from cablewright.kernels.filtering.predict import fade
from cablewright.kernels.filtering.time_rows import interpolate
from cablewright.kernels.filtering.update import correct, size_of

NO_SPREAD, NOTHING = np.zeros((0, 0)), np.zeros(0, np.bool_)


@pytest.mark.parametrize(("k", "spread", "considered"), [(1, False, False), (2, False, True), (5, True, True)])
def test_an_update_is_josephs_form_of_whole_matrices(k: int, spread: bool, considered: bool) -> None:
    random, n = np.random.default_rng(k), 9
    root = random.standard_normal((n, n))
    P, H, R = root @ root.T, random.standard_normal((k, n)), np.diag(random.uniform(0.1, 1.0, k))
    H[:, ::2] = 0.0
    off, wide, kept = random.standard_normal(k), random.standard_normal((k, k)), np.arange(n) < 3
    more = wide @ wide.T if spread else np.zeros((k, k))
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    K[kept if considered else NOTHING.nonzero()] = 0.0
    whole = np.eye(n) - K @ H
    found, correction = P.copy(), np.empty(n)
    correct(found, H, off, R, more if spread else NO_SPREAD, kept if considered else NOTHING, correction)
    assert found == pytest.approx(whole @ P @ whole.T + K @ (R + more) @ K.T, rel=1e-10, abs=1e-12)
    assert (found == found.T).all()
    assert correction == pytest.approx(K @ off, rel=1e-10)
    assert size_of(P, H, off, R) == pytest.approx(off @ np.linalg.solve(S, off), rel=1e-10)


def test_a_measurement_without_any_variance_changes_nothing() -> None:
    P, H, correction = np.eye(3), np.zeros((1, 3)), np.full(3, np.nan)
    correct(P, H, np.ones(1), np.zeros((1, 1)), NO_SPREAD, NOTHING, correction)
    assert (np.eye(3) == P).all()
    assert not correction.any()
    assert size_of(P, H, np.ones(1), np.zeros((1, 1))) == np.inf


def test_states_fade_towards_what_was_known_first() -> None:
    P = np.full((4, 4), 0.5) + np.eye(4)
    keep = fade(P, 1, 3, 0.4, np.array([2.0, 3.0]))
    assert keep == pytest.approx(np.exp(-0.4))
    assert np.diag(P) == pytest.approx([1.5, *(keep**2 * 1.5 + (1.0 - keep**2) * np.array([2.0, 3.0])), 1.5])
    assert P[0, 3] == 0.5
    assert P[0, 1] == P[1, 0] == pytest.approx(0.5 * keep)


@pytest.mark.parametrize("size", [1, 2, 50])
def test_rows_between_two_times_are_numpys(size: int) -> None:
    random = np.random.default_rng(size)
    known, rows = np.cumsum(random.exponential(size=size)), random.standard_normal((size, 3))
    times = np.concatenate([random.uniform(-2.0, known[-1] + 2.0, 40), known])
    found = np.empty((len(times), 3))
    interpolate(known, rows, times, found)
    assert found == pytest.approx(np.column_stack([np.interp(times, known, row) for row in rows.T]), abs=1e-12)


def test_a_line_is_matched_first_with_the_wall_that_fewest_may_be() -> None:
    """Two parallel walls: line 0 may be both, line 1 the second; a line that is matched counts no more."""
    nis = np.array([[4.0, 1.0], [np.inf, 2.0], [0.1, 0.1]])
    found, claims = np.array([wall_matches.REJECTED, wall_matches.REJECTED, 0]), np.array([1, 2])
    assert wall_matches._most_certain(found, nis, claims, 18.4) == (0, 0)
    assert wall_matches._most_certain(found, nis, np.array([2, 2]), 18.4) == (0, 1)
    assert wall_matches._most_certain(found, nis + 20.0, claims, 18.4) == (-1, -1)


LAWS = np.array([
    [3.0, 40.0, 8.0], [2e-5, 1e-5, 4e-5], [1.5, 2.5, 2.0], [-0.3, -0.1, -0.4], np.arctan([-0.3, -0.1, -0.4])
])  # fmt: skip


@pytest.mark.parametrize("excess", [-1e-3, 2e-3, 0.05])
def test_a_force_by_an_excess_gives_that_excess(excess: float) -> None:
    forces = np.empty(3)
    sagging_lines.forces_of(LAWS, np.full(3, excess), forces)
    found = LAWS[sagging_lines.SAGGING] / forces**2 - LAWS[sagging_lines.STRETCHING] * forces
    assert found == pytest.approx(np.full(3, excess), rel=5e-3, abs=2e-5)


@pytest.mark.parametrize("zero", [0.0, 0.02])
def test_the_mixture_of_forces_is_that_of_whole_grids(zero: float) -> None:
    may_be = np.array([[90.0, 150.0, 4.0], [60.0, -40.0, 80.0]])
    unsure = np.array([[[2.0], [3.0], [0.1]], [[1.0], [-2.0], [0.5]]])
    sigmas, now = np.array([0.1, 5e-4, 1e-3, zero, 7.0]), np.array([-1e-3, 4e-4, 0.02])
    measured = np.array([[0.0, 0.016, 1e-6, 0.01], [2.0, 0.11, 1e-6, -0.01]])
    known = np.diag([4e-6, 4e-6, 1e-4, 1e-5, 1e-5])
    mean, forces = np.empty(5), np.empty(3)
    noise, spread = np.empty((2, 5, 5))
    nis = sagging_lines.weigh_forces(LAWS, may_be, unsure, known, now, measured, sigmas, mean, noise, spread, forces)
    shares = np.linspace(0.0, 1.0, 20_001)[1:-1]  # even ones, each as likely before
    h = may_be[0] + shares[:, None] * may_be[1]
    lines = measured[:, 0].astype(int)
    steep = LAWS[sagging_lines.SLOPE] + LAWS[sagging_lines.RISING] / h
    differences = (np.arctan(steep) - LAWS[sagging_lines.ANGLE])[:, lines]
    off = np.hstack([LAWS[0] / h**2 - LAWS[1] * h - now, measured[:, 1] - differences])
    slopes = np.hstack(
        [2.0 * LAWS[0] / h**3 + LAWS[1], (-LAWS[sagging_lines.RISING] / (h**2 * (1.0 + steep**2)))[:, lines]]
    )
    moved = slopes * np.hstack([each := unsure[0, :, 0] + shares[:, None] * unsure[1, :, 0], each[:, lines]])
    own = np.hstack(
        [
            (7.0 * 0.1 * LAWS[1] * h) ** 2 + 5e-4**2 + (0.03 * LAWS[0] / h**2) ** 2,
            1e-3**2 + (7.0 * 0.01 * differences) ** 2 + measured[:, 2],
        ]
    )
    all_noise = moved[:, :, None] * moved[:, None, :] + own[:, :, None] * np.eye(5)
    S = known + all_noise
    sizes = np.einsum("ki,ki->k", off, np.linalg.solve(S, off[:, :, None])[:, :, 0])
    cost = sizes + np.linalg.slogdet(S)[1]
    if zero:
        cost += ((off[:, 3:] + measured[:, 3]) ** 2 / (zero**2 + 1e-3**2 + measured[:, 2])).sum(axis=1)
    weights = np.exp(-0.5 * (cost - cost.min()))
    weights /= weights.sum()
    assert mean == pytest.approx(weights @ off, rel=0.03, abs=2e-5)
    assert forces == pytest.approx(weights @ h, rel=0.01)
    assert noise == pytest.approx(np.tensordot(weights, all_noise, 1), rel=0.05, abs=1e-8)
    away = off - weights @ off
    assert spread == pytest.approx((weights * away.T) @ away, rel=0.1, abs=1e-7)
    assert nis == pytest.approx(sizes.min(), rel=0.05)


def test_angles_that_are_lost_late_or_astray_are_as_they_were() -> None:
    rows, straight = np.zeros((smoothed_line_angles.KNOWN, 4)), np.zeros(4)
    rows[smoothed_line_angles.SCATTER_TIMES], rows[smoothed_line_angles.VARIANCE] = 5.0, 1e-4
    smoothed_line_angles.smooth(rows, np.array([0.01, np.nan, 0.9, 0.02]), straight, 0.1, 0.1, 0.2, 0.15, 0.5)
    assert rows[smoothed_line_angles.DIFFERENCE] == pytest.approx(
        [-np.expm1(-0.5) * 0.01, 0.0, 0.0, -np.expm1(-0.5) * 0.02]
    )
    assert rows[smoothed_line_angles.LAST_TIME].tolist() == [0.1, 0.0, 0.0, 0.1]
    assert rows[smoothed_line_angles.OUTLIERS].tolist() == [0.0, 0.0, 1.0, 0.0]
    assert rows[smoothed_line_angles.VARIANCE, 1] == 1e-4
