"""Free vibrations between samples against the matrix exponential, at frequencies far apart."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.linalg import cholesky, expm

from cablewright.kernels.motion.swing import CARRIED, PLACE, RATE, swing_rows

RATIO = 0.02


def system(rng: np.random.Generator, frequencies: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, stiffness and damping (f, f) with these *frequencies*, Hz, and `RATIO`."""
    f = len(frequencies)
    root = rng.normal(size=(f, f)) + 3.0 * np.eye(f)
    mass = root.T @ root
    turned = np.linalg.qr(rng.normal(size=(f, f)))[0]
    rates = 2.0 * np.pi * frequencies
    shapes = np.linalg.solve(cholesky(mass), turned)  # of unit modal mass
    weighted = mass @ shapes
    return mass, (weighted * rates**2) @ weighted.T, (weighted * 2.0 * RATIO * rates) @ weighted.T


def followed(mass, stiffness, moves, spent, dwell, point, pull, offsets=None) -> dict[str, np.ndarray]:
    b, f = moves.shape
    m = len(pull)
    carried, fresh = np.zeros((CARRIED, f)), np.zeros(b, np.bool_)
    fresh[0] = True
    names = {"displacement": (b,), "frequency": (b,), "drop": (b, m), "rise": (b, m)}
    out = {name: np.zeros(shape) for name, shape in names.items()} | {"codes": np.ones(b, np.int64)}

    def each(table: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(np.broadcast_to(table, (b, *table.shape)))

    offsets = np.zeros((b, f)) if offsets is None else offsets
    swing_rows(each(mass), each(stiffness), each(point), each(pull), each(np.zeros((m, f))), moves, offsets, spent,
               dwell, fresh, RATIO, carried, *out.values())  # fmt: skip
    return out | {"carried": carried}


@pytest.mark.parametrize("frequencies", [[0.03, 1.8, 40.0], [1.8, 1.8, 4.0], [0.5, 0.7, 2.0, 9.0, 11.0, 2000.0]])
def test_states_and_extremes_are_those_of_the_matrix_exponential(frequencies: list[float]) -> None:
    rng = np.random.default_rng(3)
    f, b = len(frequencies), 12
    mass, stiffness, damping = system(rng, np.array(frequencies))
    moves, spent = 0.1 * rng.normal(size=(b, f)), rng.uniform(0.02, 0.6, b)
    dwell = np.where(np.arange(b) % 4 == 3, 0.5, 0.0)
    point, pull = rng.normal(size=(3, f)), rng.normal(size=(2, f))
    found = followed(mass, stiffness, moves, spent, dwell, point, pull)
    assert not found["codes"].any()
    fine = 4000
    inverse = np.linalg.inv(mass)
    change = np.block([[np.zeros((f, f)), np.eye(f)], [-inverse @ stiffness, -inverse @ damping]])
    state, speed = np.zeros(2 * f), np.zeros(f)
    for k in range(1, b):
        far, changes = 0.0, np.zeros(2)
        for duration, wanted in ((spent[k], moves[k] / spent[k]), (dwell[k], np.zeros(f))):
            if duration == 0.0:
                continue
            state[f:] += speed - wanted
            speed, step = wanted, expm(change * duration / fine)
            course = np.empty((fine, 2 * f))
            for i in range(fine):
                course[i] = state = step @ state
            far = max(far, float(np.linalg.norm(course[:, :f] @ point.T, axis=1).max()))
            changes = np.maximum(changes, (course[:, :f] @ pull.T).max(axis=0))
        assert found["displacement"][k] == pytest.approx(far, rel=0.03)
        assert found["rise"][k] == pytest.approx(changes, rel=0.03, abs=0.03 * float(changes.max()))
    scale = np.abs(state).max()
    np.testing.assert_allclose(found["carried"][PLACE], state[:f], atol=1e-6 * scale)
    np.testing.assert_allclose(found["carried"][RATE], state[f:], atol=1e-6 * scale)


def test_what_lengths_account_for_moves_nothing() -> None:
    """With the offsets of an acceleration that the path has, the platform stays on it but for the jumps of samples."""
    mass, stiffness, _ = system(np.random.default_rng(5), np.array([1.0, 1.5, 3.0]))
    b, step, size = 400, 0.01, np.array([0.3, -0.2, 0.1])
    times = step * np.arange(b)
    place, acceleration = np.outer(times - np.sin(times), size), np.outer(np.sin(times), size)
    moves = np.diff(place, axis=0, prepend=place[:1])
    offsets = acceleration @ mass.T @ np.linalg.inv(stiffness).T
    spent, point, pull = np.full(b, step), np.eye(3), np.zeros((1, 3))
    ahead = followed(mass, stiffness, moves, spent, np.zeros(b), point, pull, offsets)["displacement"]
    without = followed(mass, stiffness, moves, spent, np.zeros(b), point, pull)["displacement"]
    assert ahead.max() < 0.1 * without.max()


def test_a_long_stand_and_a_million_short_ways_cost_little() -> None:
    mass, stiffness, _ = system(np.random.default_rng(4), np.array([1.8, 2.0, 300.0]))
    point, pull = np.eye(3), np.eye(3)
    followed(mass, stiffness, np.zeros((2, 3)), np.ones(2), np.zeros(2), point, pull)
    b = 100_000
    moves, spent, dwell = np.full((b, 3), 1e-4), np.full(b, 1e-3), np.zeros(b)
    moves[1::2] *= -1.0
    dwell[-1] = 1e6
    begin = time.process_time()
    found = followed(mass, stiffness, moves, spent, dwell, point, pull)
    assert time.process_time() - begin < 2.0
    assert np.isfinite(found["displacement"]).all()


def test_an_unstable_pose_is_not_known_and_what_follows_begins_at_rest() -> None:
    mass, stiffness, _ = system(np.random.default_rng(4), np.array([1.8, 2.0, 3.0]))
    moves = np.full((3, 3), 0.01)
    found = followed(mass, -stiffness, moves, np.ones(3), np.zeros(3), np.eye(3), np.eye(3))
    assert found["codes"].all()
    assert np.isnan(found["displacement"]).all()
