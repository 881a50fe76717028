"""Simulated readings and loads, and lengths by counts, against the same formulas with whole arrays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering import body_lengths, reckoning
from cablewright.kernels.plant import sensor_errors
from cablewright.kernels.plant.machine_step import ANGLES, LINES, OF_EACH, PULLS, SWIVELS, WINCH_PULLS

LINE_COUNTS = [3, 8]


def told_of(m: int) -> tuple[np.random.Generator, Array, Array]:
    """What sensors of a machine with *m* lines measure: as one array, and the numbers (7, m) of its lines in it."""
    random = np.random.default_rng(m)
    told = random.normal(0.0, 1.0, LINES + OF_EACH * m)
    return random, told, told[LINES:].reshape(OF_EACH, m)


def chances(random: np.random.Generator, m: int) -> Array:
    """The first line's reading is lost, the second's is an outlier."""
    drawn = random.uniform(0.3, 0.7, 2 * m)
    drawn[0], drawn[1] = 0.05, 0.95
    return drawn


@pytest.mark.parametrize("m", LINE_COUNTS)
def test_angles_of_lines_have_zeros_noise_losses_and_outliers(m: int) -> None:
    random, told, of_lines = told_of(m)
    zeros, noise, chance, shown = *random.normal(size=(2, m)), chances(random, m), np.empty(m)
    sensor_errors.show_angles(told, zeros, np.array([0.1, 0.1, 0.1]), noise, chance, shown)
    assert math.isnan(shown[0])
    assert shown[1] == pytest.approx(math.pi * (chance[m + 1] - 0.5))
    assert shown[2:] == pytest.approx((of_lines[ANGLES] + zeros + 0.1 * noise)[2:], rel=1e-12)


@pytest.mark.parametrize("m", LINE_COUNTS)
def test_swivels_show_angles_within_a_turn_and_others_none(m: int) -> None:
    random, told, of_lines = told_of(m)
    of_lines[SWIVELS] *= 4.0
    zeros, noise, chance, shown = *random.normal(size=(2, m)), chances(random, m), np.empty(m)
    there = np.arange(m) != m - 1
    sensor_errors.show_swivels(told, there, zeros, np.array([0.1, 0.1, 0.1]), noise, chance, shown)
    assert np.isnan(shown).tolist() == [i in (0, m - 1) for i in range(m)]
    assert shown[1] == pytest.approx(math.pi * (2.0 * chance[m + 1] - 1.0))
    turns = (shown - of_lines[SWIVELS] - zeros - 0.1 * noise)[2 : m - 1] / (2.0 * math.pi)
    assert turns == pytest.approx(np.rint(turns), abs=1e-12)
    assert (np.abs(shown[1 : m - 1]) <= math.pi).all()


@pytest.mark.parametrize("m", LINE_COUNTS)
@pytest.mark.parametrize("talk", [0.0, 0.2])
def test_cells_show_the_mean_of_both_sides_with_drifting_zeros_up_to_their_range(m: int, talk: float) -> None:
    random, told, of_lines = told_of(m)
    of_lines[PULLS] += 10.0
    of_lines[PULLS, 2] = 1e4
    pulls, zeros = np.empty(m), random.normal(size=m)
    factors, noise, chance, shown = (
        random.normal(1.0, 0.1, m),
        random.normal(size=2 * m),
        chances(random, m),
        np.empty(m),
    )
    before = zeros.copy()
    sensor_errors.pull_of_cells(told, pulls)
    assert pulls == pytest.approx(0.5 * (of_lines[PULLS] + of_lines[WINCH_PULLS]), rel=1e-12)
    numbers = np.array([0.3, 0.1, 0.1, 2e3, 0.05, talk])
    sensor_errors.show_tensions(pulls, factors, zeros, numbers, noise, chance, shown)
    assert zeros == pytest.approx(before + 0.05 * noise[m:], rel=1e-12)
    expected = factors * pulls + 0.5 * talk * (np.roll(pulls, 1) + np.roll(pulls, -1)) + zeros + 0.3 * noise[:m]
    assert math.isnan(shown[0])
    assert shown[1] == pytest.approx(2e3 * chance[m + 1])
    assert shown[2] == 2e3
    assert shown[3:] == pytest.approx(np.minimum(expected, 2e3)[3:], rel=1e-12)


@pytest.mark.parametrize("outlier", [False, True])
def test_an_inertial_unit_at_rest_measures_gravity_upwards(outlier: bool) -> None:
    random, told, _ = told_of(3)
    told[:LINES], noise, shown = 0.0, random.normal(size=6), np.empty(6)
    bias, deviation, most = random.normal(size=6), random.uniform(0.1, 0.2, 6), np.full(6, 50.0)
    draws, eye = random.uniform(0.3, 0.7, 7), np.eye(3)
    draws[sensor_errors.CHANCE] = 0.95 if outlier else 0.5
    given = eye, np.array([0.1, 0.2, 0.3]), np.zeros(6), told, 9.81, eye, bias, deviation, 0.1, most
    sensor_errors.show_motion(*given, noise, draws, shown)
    expected = bias + deviation * noise + [0.0, 0.0, 9.81, 0.0, 0.0, 0.0]
    assert shown == pytest.approx(50.0 * (2.0 * draws[1:] - 1.0) if outlier else expected, rel=1e-12)


def tables(m: int, turns: int = 20) -> tuple[Array, Array, np.ndarray]:
    """Coils of *m* lines with rising radii: radii and wound lengths after each turn, and the number of turns."""
    radii = np.array([np.linspace(0.05, 0.06 + 0.001 * i, turns + 1) for i in range(m)])
    wound = np.concatenate([np.zeros((m, 1)), np.cumsum(math.pi * (radii[:, :-1] + radii[:, 1:]), axis=1)], axis=1)
    return radii, wound, np.full(m, turns)


def test_counts_pay_out_what_a_coil_loses_and_cables_slide_that_way() -> None:
    own, counts = tables(4), np.array([50, -30])
    winch, sense, begin = np.array([0, 0, 1, 1]), np.array([1.0, -1.0, 1.0, 0.0]), np.full(4, 30.0)
    before, sliding, angles, paid = np.zeros(4), np.array([0.0, 0.9, -0.999, 0.5]), *np.empty((2, 4))
    given = counts, np.array([10, 10]), winch, sense, 20.0, begin, *own, 1.0, before, sliding, angles, paid
    assert body_lengths.wind(*given)
    assert angles == pytest.approx([28.0, 32.0, 32.0, 30.0])
    turns = np.arange(21.0) * 2.0 * math.pi
    left = [np.interp(angle, turns, wound) for angle, wound in zip(angles, own[1], strict=True)]
    start = [np.interp(30.0, turns, wound) for wound in own[1]]
    assert paid == pytest.approx(np.subtract(start, left), abs=2e-4)  # the radius rises within a turn, too
    assert sliding == pytest.approx(np.clip(np.array([0.0, 0.9, -0.999, 0.5]) + paid, -1.0, 1.0))
    assert not body_lengths.wind(np.array([50, 9000]), *given[1:])
    rotation = np.empty(4)
    assert reckoning.unwind(counts, np.array([10, 10]), winch, sense, 20.0, begin, *own, rotation, paid)
    assert rotation == pytest.approx(begin - angles)


def test_an_estimate_of_a_body_has_its_numbers_in_their_places() -> None:
    random, m, (radii, _, turns) = np.random.default_rng(6), 4, tables(4)
    pose, velocity, lengths, straight = (random.normal(size=k) for k in (6, 6, m, m))
    uneven, covariance = random.normal(0.0, 0.1, m), random.normal(size=(6, 6))
    found, angles = np.full(9 + 3 * m + 81, math.nan), np.full(m, 4.0 * math.pi)
    trace = body_lengths.tell(pose, velocity, lengths, straight, radii, turns, angles, uneven, covariance, 1e-4, found)
    assert trace == pytest.approx(np.trace(covariance))
    assert found[:9].tolist() == [*pose[:3], *velocity[:3], *pose[3:]]
    assert found[9 : 9 + 3 * m] == pytest.approx([*lengths, *(lengths - straight), *(radii[:, 2] * (1.0 + uneven))])
    whole, kept = found[9 + 3 * m :].reshape(9, 9), [0, 1, 2, 6, 7, 8]
    assert (whole[np.ix_(kept, kept)] == covariance).all()
    assert np.diagonal(whole)[3:6].tolist() == [1e-4] * 3
    assert np.count_nonzero(whole) == 39
