"""What a lidar's turn is worked on with, against NumPy and SciPy; the lines and places themselves: tests/estimation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from cablewright.kernels.lines_of_scan import explain, median, settle


@settings(deadline=None)
@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=40))
def test_the_median_is_numpys(values: list[float]) -> None:
    given_ = np.array(values)
    assert median(given_, len(values), np.empty(len(values))) == np.median(given_)
    assert given_.tolist() == values


@pytest.mark.parametrize("seed", range(4))
def test_points_are_counted_as_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turned, level, xy = rng.normal(0.0, 1.0, (7, 4, 2)), rng.normal(-1.0, 1.0, (7, 4)), rng.normal(0.0, 1.0, (2, 60))
    sees, scores = rng.random(4) < 0.6, np.zeros(7)
    explain(turned, level, xy, sees, 0.3, 0.9, np.empty((2, 60)), scores)
    off = turned @ xy + level[:, :, None]
    beyond, on = (off > 0.9).any(axis=1), (np.abs(off[:, sees]) <= 0.3).any(axis=1)
    np.testing.assert_array_equal(scores, (on & ~beyond).sum(axis=1) - beyond.sum(axis=1))


@pytest.mark.parametrize("seed", range(4))
def test_the_fit_is_scipys(seed: int) -> None:
    """Two lidars, three walls, of each line yaw and place: what is found, its covariance; one far off is left out."""
    rng = np.random.default_rng(seed)
    truth, azimuths = np.array([0.4, -0.3, 0.2]), np.array([math.pi, 0.0, math.pi / 2])
    wall, lidar = np.tile(np.arange(3), 4), np.repeat([0, 1], 6)
    k, normals = len(wall), np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)[wall]
    mounts = np.array([[0.1, 0.15], [0.0, -0.15]])[lidar]
    slots, slopes = np.tile(np.arange(5), (k, 1)), np.zeros((k, 2, 5))
    slots[:, 3], slots[:, 4] = 3 + lidar, 5 + wall
    slopes[:, 0, 2], slopes[:, 1, :2], slopes[:, 1, 4] = 1.0, normals, -1.0
    slopes[:, :, 3] = rng.normal(0.0, [0.1, 1.0], (k, 2))
    prior = np.concatenate([np.zeros(3), np.full(2, 2e-3**-2.0), np.full(3, 3e-3**-2.0)])
    half = rng.normal(0.0, 1.0, (k, 2, 2)) * 1e3
    weights = half.transpose(0, 2, 1) @ half + 1e4 * np.eye(2)
    known, gates = np.zeros((k, 2)), np.tile([0.02, 0.02], (k, 1))

    def off(q: np.ndarray) -> np.ndarray:
        c, s = math.cos(q[2]), math.sin(q[2])
        place = np.einsum("ki,ki->k", normals, mounts @ np.array([[c, s], [-s, c]]) + q[:2]) + known[:, 1]
        both = np.stack([q[2] - known[:, 0], place], axis=1)
        return both + np.einsum("krs,ks->kr", slopes[:, :, 3:], q[slots[:, 3:]])

    start = np.concatenate([truth, np.zeros(5)])
    known += off(start) * [1.0, -1.0] + rng.normal(0.0, 1e-3, (k, 2))
    known[5, 1] += 0.1
    roots, used = np.linalg.cholesky(weights).transpose(0, 2, 1), np.ones(k, np.bool_)
    used[5] = False

    def residuals(q: np.ndarray) -> np.ndarray:
        return np.concatenate([np.einsum("krs,ks->kr", roots, off(q))[used].ravel(), np.sqrt(prior) * q])

    wanted = least_squares(residuals, start, jac="3-point", method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    q, joined, solved = start.copy(), np.zeros(k, np.bool_), np.empty((8, 4))
    assert settle(slopes, slots, weights, known, mounts, gates, prior, joined, q, np.empty((8, 8)), solved)
    np.testing.assert_array_equal(joined, used)
    np.testing.assert_allclose(q, wanted.x, atol=1e-8)
    covariance = np.linalg.inv(wanted.jac.T @ wanted.jac)[:3, :3]
    np.testing.assert_allclose(solved[:3, 1:], covariance, rtol=1e-4, atol=1e-12)


def test_no_line_is_no_place() -> None:
    none, q = np.zeros((0, 2)), np.zeros(3)
    empty = np.zeros((0, 2, 5)), np.zeros((0, 5), np.int64), np.zeros((0, 2, 2)), none, none, none
    assert not settle(*empty, np.zeros(3), np.zeros(0, np.bool_), q, np.empty((3, 3)), np.empty((3, 4)))
