"""Walls in whole scans of made-up rooms: noise by range, the device's own housing, glass, people, pillars."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cablewright as cw
from cablewright.estimation.lidar.housing_detection import find_housing
from cablewright.estimation.lidar.noise import estimate_noise_by_range
from cablewright.estimation.lidar.scan import LidarModel, level_points
from cablewright.foundation.errors import InputError
from cablewright.studies.walls import Walls
from cases import often, some
from oracles.lidar_scans import Scanned, judged, scanned
from oracles.room import rectangle, scan

NEAR = LidarModel(min_range=0.02, max_range=100.0)


def found_in(truth: Scanned, **options) -> Walls:
    ranges = np.where(truth.ranges > 0, truth.ranges, math.nan)
    return cw.walls(cw.FileScan(truth.angles, ranges, "m", "rad", ()), **options)


def wrong_in(seed: int, clutter: int = 0) -> tuple[list[str], int]:
    truth = scanned(seed, clutter)
    lines = found_in(truth).lines
    return judged([(line.angle, line.distance, line.ends) for line in lines], truth), len(lines)


@pytest.mark.slow
@pytest.mark.parametrize(("clutter", "right"), [(0, 95.0), (4, 92.0)])
def test_walls_of_500_rooms(clutter: int, right: float) -> None:
    """Without any option: scans with all walls right and none invented, and lines that are invented."""
    wrong, lines = zip(*(wrong_in(seed, clutter) for seed in range(10_000, 10_500)), strict=True)
    share = 100.0 * np.mean([not each for each in wrong])
    invented = 100.0 * sum(one.startswith("invented") for each in wrong for one in each) / sum(lines)
    print(f"{clutter} more things: right walls in {share:g} % of 500 scans, {invented:.2f} % of the lines are invented")
    assert share >= right
    assert invented <= 1.0


@pytest.mark.parametrize("seed", [70077, 70103, 70105])
def test_a_line_along_separate_things_is_no_wall(seed: int) -> None:
    """Rooms with ten more things, of which the sides of some are in one line that most rays pass."""
    assert not any(each.startswith("invented") for each in wrong_in(seed, 10)[0])


def test_walls_of_some_rooms() -> None:
    assert sum(not wrong_in(seed)[0] for seed in range(10_000, 10_020)) >= 18


@pytest.mark.parametrize("growth", [0.002, 0.005, 0.01])
def test_noise_by_range(growth: float) -> None:
    a, r = scan(rectangle(), (0.4, -0.6, 0.2), np.random.default_rng(1), n=1440, sigma=0.0)
    noisy = r + np.random.default_rng(2).standard_normal(len(r)) * (0.002 + growth * r)
    at_zero, per_metre = estimate_noise_by_range(level_points(NEAR, a, noisy))
    for far in (2.0, 5.0):
        assert at_zero + per_metre * far == pytest.approx(0.002 + growth * far, rel=0.3)
    alike = estimate_noise_by_range(level_points(NEAR, a, r + np.random.default_rng(2).normal(0.0, 0.004, len(r))))
    assert alike.at_zero + 3.0 * alike.per_metre == pytest.approx(0.004, rel=0.3)


def test_covariance_of_walls_is_honest_where_noise_grows() -> None:
    """Over many scans, squared errors over their covariance: chi-squared with 2 degrees of freedom, on average 2."""
    squares = []
    for seed in range(often(60, 200)):
        rng = np.random.default_rng(seed)
        a, r = scan(rectangle(window=False, furniture=False), (0.4, -0.6, 0.2), rng, sigma=0.0)
        found = cw.walls(cw.FileScan(a, r + rng.standard_normal(len(r)) * (0.001 + 0.004 * r), "m", "rad", ()))
        north = min(found.lines, key=lambda line: abs(math.remainder(line.angle - math.pi / 2 + 0.2, math.tau)))
        off = np.array([math.remainder(north.angle - math.pi / 2 + 0.2, math.tau), north.distance - 5.7])
        squares.append(off @ np.linalg.solve(north.covariance, off))
    assert 1.2 < np.mean(squares) < 3.0


@pytest.mark.parametrize("seed", some(range(8)))
def test_housing_is_found(seed: int) -> None:
    truth = scanned(seed)
    parts = find_housing(level_points(NEAR, truth.angles, truth.ranges))
    for begin, end in truth.housing:
        bearings = np.linspace(begin + 0.02, end - 0.02, 9)
        others = [other for other in truth.housing if other != (begin, end)]
        for x in bearings:
            hidden = any((x - a + 0.03) % math.tau < b - a + 0.06 for a, b in others)
            assert hidden or any((x - one.begin) % math.tau < one.end - one.begin for one in parts)


def test_near_walls_are_no_housing() -> None:
    """A wall 0.3 m away, 2 m long, and a room of 0.6 m."""
    a = np.linspace(0, math.tau, 720, endpoint=False)
    for x, y in ((0.3, 4.0), (0.3, 0.3)):
        with np.errstate(divide="ignore"):
            r = np.minimum(x / np.abs(np.cos(a)), y / np.abs(np.sin(a)))
        assert find_housing(level_points(NEAR, a, r)) == ()


def test_points_on_no_wall_are_classified() -> None:
    """Half of a window lets rays through, a person stands before a wall, and a pillar."""
    rng = np.random.default_rng(1)
    a, r = scan(rectangle(window=False, furniture=False), (0.0, 0.0, 0.0), rng)
    glass = (np.abs(a - 0.3) < 0.15) & (rng.random(len(a)) < 0.7)
    r[glass] += rng.uniform(1.0, 5.0, glass.sum())
    person, pillar = np.abs(a - 1.5) < 0.1, np.abs(a - 2.6) < 0.1
    r[person] = 2.0 + rng.normal(0.0, 0.04, person.sum())
    r[pillar] = 1.5 - 0.15 * np.sqrt(1.0 - (10.0 * (a[pillar] - 2.6)) ** 2) + rng.normal(0.0, 2e-3, pillar.sum())
    found = cw.walls(cw.FileScan(a, r, "m", "rad", ()))
    kinds = {kind["kind"]: kind["points"] for kind in found.kinds}
    assert kinds["behind"] == pytest.approx(glass.sum(), abs=3)
    assert kinds["rough"] == pytest.approx(person.sum(), abs=4)
    assert kinds["thing"] == pytest.approx(pillar.sum(), abs=4)
    assert sorted(line.distance for line in found.lines) == pytest.approx([2.5, 2.6, 5.1], abs=5e-3)


def test_a_house_behind_glass_is_no_wall() -> None:
    a, r = scan(rectangle(window=False, furniture=False), (0.0, 0.0, 0.0), np.random.default_rng(1))
    glass = np.abs(a - 0.4) < 0.25
    r[glass] = 6.0 / np.cos(a[glass])
    assert sorted(line.distance for line in cw.walls(cw.FileScan(a, r, "m", "rad", ())).lines) == pytest.approx(
        [2.5, 2.6, 5.1], abs=5e-3
    )


def test_growth_of_noise_is_checked() -> None:
    with pytest.raises(InputError, match=r"sigma_per_metre = -0\.1: must be from 0 to 1"):
        LidarModel(sigma_per_metre=-0.1)
