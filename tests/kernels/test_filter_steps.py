"""Predictions and estimate of the filter, of three to eight lines, against whole matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.estimation.kalman.state import FilterLayout, Mean
from cablewright.estimation.tilt import rotation_vector
from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering.estimate import tell
from cablewright.kernels.filtering.predict import JUMPED, reel, roll, turn
from cablewright.kernels.filtering.reckoning import AXES, OF_LINES

LINES = [3, 4, 8]


def some(m: int) -> tuple[np.random.Generator, Mean, Array]:
    """A state of *m* lines, and its covariance."""
    random, mean = np.random.default_rng(m), Mean.of(FilterLayout.of(m, 2, 4))
    mean.x[:] = random.standard_normal(len(mean.x))
    root = 0.01 * random.standard_normal((len(mean.x), len(mean.x)))
    return random, mean, root @ root.T


@pytest.mark.parametrize("m", LINES)
def test_drums_that_roll_move_the_platform_and_lines_with_counterweights_follow(m: int) -> None:
    random, mean, P = some(m)
    (x, lay, at), before, noise = mean, mean.x.copy(), np.array([2e-3, 3e-3, 5e-3, 7e-3])
    jacobian, toward, hung = random.normal(0.0, 0.5, (3, m)), random.normal(0.0, 0.6, (m, 3)), np.arange(m) == 1
    rotation, creep, rates = random.normal(0.0, 0.1, m), random.normal(0.0, 1e-3, m), random.standard_normal(m)
    loosened, coasted, turned = np.ones(m), np.ones(4), rates.copy()
    paid = before[lay.radii] * rotation
    stretched = 0.1 * before[lay.stretch] + 0.1 * creep * before[lay.lengths]
    moved = jacobian @ (paid + stretched)
    paid[1] += toward[1] @ moved
    F = np.eye(lay.size)
    F[lay.position, lay.radii], F[lay.lengths, lay.radii] = jacobian * paid, np.diag(paid)
    expected, far = F @ P @ F.T, float(np.linalg.norm(moved))
    more = np.zeros(lay.size)
    more[lay.position] = more[lay.lengths] = noise[0] ** 2 * far + noise[1] ** 2 * 0.1
    more[lay.radii], more[lay.ground] = noise[2] ** 2 * np.abs(rotation), noise[3] ** 2 * far
    roll(x, P, at, jacobian, toward, hung, rotation, creep, noise, 0.1, 0.25, loosened, coasted, turned)
    assert pytest.approx(expected + np.diag(more), rel=1e-9, abs=1e-14) == P
    changed = before.copy()
    changed[lay.position] += moved
    changed[lay.lengths] += paid + stretched
    assert x == pytest.approx(changed, rel=1e-12)
    assert loosened == pytest.approx(1.0 + paid + stretched - toward @ moved, rel=1e-12)
    assert coasted == pytest.approx([*(1.0 + jacobian @ stretched), 1.0], rel=1e-12)
    assert turned == pytest.approx(rates + 0.25 * (rotation / 0.1 - rates), rel=1e-12)


def test_drums_that_stand_keep_their_rates() -> None:
    _, (x, _, at), P = some(4)
    still, rates = np.zeros(4), np.ones(4)
    jacobian, toward, hung = np.ones((3, 4)), np.ones((4, 3)), np.zeros(4, np.bool_)
    roll(x, P, at, jacobian, toward, hung, still, still, np.ones(4), 0.1, 0.25, np.zeros(4), np.zeros(4), rates)
    assert rates.tolist() == [1.0] * 4


def test_a_gyro_turns_tilts_and_yaw() -> None:
    _, mean, P = some(4)
    (x, lay, at), before, found = mean, mean.x.copy(), np.zeros(3)
    rate = np.array([0.3, -0.2, 0.9])
    wx, wy, wz = rate - before[lay.gyro_bias]
    tilt_x, tilt_y = before[lay.tilt]
    expected = np.array([wx + wz * tilt_y, wy - wz * tilt_x, wz])
    first, second, _ = range(lay.attitude.start, lay.attitude.stop)
    one, two, drifts = np.eye(lay.size), np.eye(lay.size), np.eye(lay.size)
    one[first, second], two[second, first] = 0.1 * wz, -0.1 * wz  # one after the other
    drifts[lay.attitude, lay.gyro_bias] = -0.1 * np.eye(3)
    F, more = drifts @ two @ one, np.zeros(lay.size)
    more[lay.attitude] = 0.02**2 * 0.1
    whole = F @ P @ F.T + np.diag(more)
    turn(x, P, at, *rate, 0.1, 0.02, found)
    assert found == pytest.approx(expected, rel=1e-12)
    changed = before.copy()
    changed[lay.attitude] += 0.1 * expected
    assert x == pytest.approx(changed, rel=1e-12)
    assert pytest.approx(whole, rel=1e-9, abs=1e-14) == P


@pytest.mark.parametrize("m", LINES)
@pytest.mark.parametrize("coasting", [False, True])
@pytest.mark.parametrize("late", [(0.03, 0.02), (-0.1, -0.1), (0.5, 0.5)])
def test_an_estimate_is_the_state_at_the_present_time(m: int, coasting: bool, late: tuple[float, float]) -> None:
    random, mean, P = some(m)
    (x, lay, at), sigmas = mean, np.array([0.1, 0.2, 0.3, 0.4])
    jacobian, toward = random.standard_normal((3, m)), random.standard_normal((m, 3))
    taut, there, rates, rate = (random.standard_normal(size) for size in (m, 3, m, 3))
    velocity = x[lay.velocity].copy() if coasting else jacobian @ (x[lay.radii] * rates)
    found, doubt = np.empty(OF_LINES + 3 * m + AXES**2), 1e-3 * np.outer(there, there)
    variance, sound = tell(
        x, P, at, jacobian, taut, toward, there, rates, rate, sigmas, doubt, *late, 0.15, coasting, found
    )
    since, turning = (min(max(each, 0.0), 0.15) for each in late)
    since = 0.0 if coasting else since
    tilt_x, tilt_y, yaw = x[lay.attitude]
    wx, wy, wz = turning * rate
    assert x[lay.velocity] == pytest.approx(velocity, rel=1e-12)
    assert found[:3] == pytest.approx(x[lay.position] + since * velocity, rel=1e-12)
    assert found[3:6] == pytest.approx(velocity, rel=1e-12)
    assert found[6:9] == pytest.approx(rotation_vector(yaw + wz, tilt_x + wx, tilt_y + wy), rel=1e-12)
    lengths, excess, radii = found[OF_LINES : OF_LINES + 3 * m].reshape(3, m)
    assert lengths == pytest.approx(x[lay.lengths] + since * x[lay.radii] * rates, rel=1e-12)
    assert excess == pytest.approx(x[lay.lengths] - taut - toward @ (x[lay.position] - there), rel=1e-10)
    assert radii.tolist() == x[lay.radii].tolist()
    G = np.zeros((AXES, lay.size))
    G[:3, lay.position] = np.eye(3)
    G[3:6, lay.velocity if coasting else lay.radii] = np.eye(3) if coasting else jacobian * x[lay.radii] * rates
    c, s = math.cos(yaw), math.sin(yaw)
    G[6:, lay.attitude] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    own = np.repeat([0.0, 0.1**2, 0.2**2], 3)
    if late[1] > 0.15:
        own[6:] += 0.3**2, 0.3**2, 0.4**2 * late[1] * (1.0 + late[1])
    covariance = found[OF_LINES + 3 * m :].reshape(AXES, AXES)
    expected = G @ P @ G.T + np.diag(own)
    expected[:3, :3] += doubt
    assert covariance == pytest.approx(expected, rel=1e-9, abs=1e-14)
    assert (covariance == covariance.T).all()
    assert variance == pytest.approx(np.trace(expected[:3, :3]), rel=1e-9)
    assert math.isfinite(sound)
    P[-1, 0] = math.nan
    assert math.isnan(
        tell(x, P, at, jacobian, taut, toward, there, rates, rate, sigmas, doubt, *late, 0.15, coasting, found)[1]
    )


@pytest.mark.parametrize(("unknown", "most"), [(0, 2e-3), (1, 2e-3), (2, 0.5)])
def test_counts_move_the_platform_as_the_rotation_that_they_show(unknown: int, most: float) -> None:
    """Two lines share a winch, one of them wound the other way, and one has a counterweight."""
    random, mean, P = some(4)
    (x, _, at), winch, sense = mean, np.array([0, 0, -1, 1]), np.array([1.0, -1.0, 0.0, 1.0])
    jacobian, toward, hung = random.normal(0.0, 0.5, (3, 4)), random.normal(0.0, 0.6, (4, 3)), np.arange(4) == 2
    noise, law, excess = np.array([2e-3, 3e-3, 5e-3, 7e-3, 0.5]), np.array([100.0, 40.0, 0.2]), np.zeros(4)
    excess[:unknown] = math.nan
    expected = 0.01 * np.array([10.0, -10.0, 0.0, -20.0])  # rad
    states: list[list[Array]] = []
    for by_counts in (True, False):
        own = [x.copy(), P.copy(), np.ones(4), np.ones(4), np.ones(4), np.ones(4)]
        state, covariance, loosened, coasted, rates, angles = own
        linear, creep, rotation = (state, covariance, at, jacobian, toward, hung), np.full(4, 1e-3), np.empty(4)
        if by_counts:
            counts = np.array([10, -20]), np.array([0, 0])
            last = loosened, coasted, rates, angles, rotation
            assert reel(*linear, *counts, winch, sense, law, True, False, excess, creep, noise, 0.1, *last) == 3
            assert rotation == pytest.approx(expected, rel=1e-12)
        else:
            angles += expected
            noise[0] = most
            roll(*linear, expected, creep, noise, 0.1, 0.5, loosened, coasted, rates)
        states.append(own)
    for one, other in zip(*states, strict=True):
        assert one == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize(
    ("turned", "rolls", "pauses", "shown"),
    [(0, False, False, 0), (0, True, True, 0), (0, True, False, 2), (3, False, False, 1), (3, True, True, 3),
     (801, True, False, JUMPED)],
)  # fmt: skip
def test_counts_say_whether_drums_turned_and_whether_that_moved_the_platform(
    turned: int, rolls: bool, pauses: bool, shown: int
) -> None:
    _, (x, _, at), P = some(3)
    law, ones, each = np.array([100.0, 40.0, 0.2]), np.ones(3), np.arange(3)
    before, own = (x.copy(), P.copy()), [np.ones(3), np.ones(4), np.ones(3), np.ones(3), np.empty(3)]
    linear = x, P, at, np.ones((3, 3)), np.ones((3, 3)), np.zeros(3, np.bool_)
    counts = np.full(3, turned), np.zeros(3, np.int64)
    assert reel(*linear, *counts, each, ones, law, rolls, pauses, ones, ones, np.ones(5), 0.1, *own) == shown
    moved = (x != before[0]).any() or (before[1] != P).any()
    assert moved == (shown in (2, 3))
    assert (own[3] == 1.0 + 0.01 * turned * (shown == 3)).all()
