"""Height from a vertical scan: a floor seen by ray geometry, with tilt, heaps and rays astray."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cablewright.estimation.height import HeightSettings, estimate_height
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Scan

PLACE, AXES = (0.22, 0.0, -0.75), ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
KNOWN = HeightSettings(PLACE, AXES)


def flat(_x: float) -> float:
    return 0.0


def scan(z: float, lean: tuple[float, float] = (0.0, 0.0), ground: Callable[[float], float] = flat) -> Scan:
    """The lidar's scan of a *ground*, a height (m) by level x, from a drum whose B is at height *z*."""
    R = Rotation.from_rotvec([*lean, 0.0]).as_matrix()
    first, step = -math.pi, math.tau / 720
    ranges = np.full(720, np.nan)
    origin = R @ PLACE + [0.0, 0.0, z]
    for k in range(720):
        a = first + k * step
        way = R @ (math.cos(a) * np.array(AXES[0]) + math.sin(a) * np.array(AXES[1]))
        if way[2] > -0.3:
            continue
        low, high = 0.0, 5.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            at = origin + middle * way
            low, high = (middle, high) if at[2] > ground(at[0]) else (low, middle)
        ranges[k] = low
    return Scan("vertical", 0.0, 1e-3, first, step, ranges)


@settings(max_examples=15)
@given(st.floats(0.9, 2.5), st.floats(-0.06, 0.06), st.floats(-0.06, 0.06))
def test_a_floor_is_as_far_as_it_is(z: float, x: float, y: float) -> None:
    found = estimate_height(KNOWN, scan(z, (x, y)), (x, y))
    # tilt is corrected to second order, the remainder is its third power times a metre or two
    assert found.over_floor == pytest.approx(z, abs=1e-6 + 0.5 * z * math.hypot(x, y) ** 3)
    assert found.over_structure == pytest.approx(found.over_floor, abs=1e-4)
    assert abs(found.slope) < 1e-3
    assert not found.note


def test_a_tilt_that_is_not_corrected_is_seen_as_a_slope() -> None:
    found = estimate_height(KNOWN, scan(1.2, (0.0, 0.05)), (0.0, 0.0))
    assert abs(found.slope) == pytest.approx(0.05, rel=0.05)


def test_a_heap_counts_for_the_structure_but_not_for_the_floor() -> None:
    found = estimate_height(KNOWN, scan(1.2, ground=lambda x: 0.1 if x > 0.2 else 0.0), (0.0, 0.0))
    assert found.over_floor == pytest.approx(1.2, abs=1e-9)
    assert 1.13 < found.over_structure < 1.17


def test_what_lies_over_where_the_floor_should_be_is_none_and_what_lies_under_it_is() -> None:
    wide = dataclasses.replace(KNOWN, floor_cone=math.radians(70.0), sigma=2e-3)
    covered = scan(1.3, ground=lambda _x: 0.08)
    assert estimate_height(wide, covered, (0.0, 0.0)).over_floor == pytest.approx(1.22, abs=1e-3)
    measured = estimate_height(wide, covered, (0.0, 0.0), 1.3, 0.02)
    assert math.isnan(measured.over_floor)
    assert measured.over_structure == pytest.approx(1.22, abs=1e-3)
    assert measured.note == "no floor in sight near the expected height"
    assert estimate_height(wide, covered, (0.0, 0.0), 1.3, 0.1).over_floor == pytest.approx(1.22, abs=1e-3)
    assert estimate_height(wide, scan(1.3), (0.0, 0.0), 1.1, 0.02).over_floor == pytest.approx(1.3, abs=1e-3)


@pytest.mark.parametrize("slope", [0.3, 0.4])
def test_flanks_are_no_floor_and_what_is_level_between_them_is(slope: float) -> None:
    wide = dataclasses.replace(KNOWN, floor_cone=math.radians(70.0), sigma=2e-3)
    valley = scan(1.1, ground=lambda x: slope * abs(x - 0.2))
    assert math.isnan(estimate_height(wide, valley, (0.0, 0.0), 1.1, 0.02).over_floor)
    trough = scan(1.1, ground=lambda x: slope * max(0.0, abs(x - 0.2) - 0.15))
    assert estimate_height(wide, trough, (0.0, 0.0), 1.1, 0.02).over_floor == pytest.approx(1.1, abs=3e-3)


def test_single_rays_astray_do_not_count() -> None:
    seen = scan(1.2)
    ranges = seen.ranges.copy()
    ranges[[350, 366, 374]] = 0.9, 0.2, 3.0
    found = estimate_height(KNOWN, Scan("vertical", 0.0, 1e-3, seen.first_angle, seen.angle_step, ranges), (0.0, 0.0))
    assert found.over_floor == pytest.approx(1.2, abs=1e-9)


@pytest.mark.parametrize("ground", ["nothing", "noise", "stairs"])
def test_no_floor_is_said(ground: str) -> None:
    seen = scan(1.2, ground=(lambda x: 0.5 * x) if ground == "stairs" else flat)
    ranges = seen.ranges.copy()
    if ground == "nothing":
        ranges[:] = np.nan
    if ground == "noise":
        ranges = np.random.default_rng(1).uniform(0.2, 9.0, 720)
    found = estimate_height(KNOWN, Scan("vertical", 0.0, 1e-3, seen.first_angle, seen.angle_step, ranges), (0.0, 0.0))
    assert math.isnan(found.over_floor)
    assert "floor" in found.note


@pytest.mark.parametrize("sigma", [1e-3, 3e-3])
def test_noise_does_not_make_the_floor_lower(sigma: float) -> None:
    seen, random = scan(1.2), np.random.default_rng(4)
    known = HeightSettings(PLACE, AXES, sigma=sigma)
    found, bare = [], []
    for _ in range(300):
        ranges = seen.ranges + sigma * random.standard_normal(720)
        measured = Scan("vertical", 0.0, 1e-3, seen.first_angle, seen.angle_step, ranges)
        found.append(estimate_height(known, measured, (0.0, 0.0)).over_floor)
        bare.append(estimate_height(KNOWN, measured, (0.0, 0.0)).over_floor)
    assert abs(np.mean(found) - 1.2) < 0.25 * sigma
    assert np.mean(bare) - 1.2 > 1.5 * sigma


def test_a_line_through_one_point_is_rejected() -> None:
    with pytest.raises(InputError, match="lowest_points = 1"):
        HeightSettings(PLACE, AXES, lowest_points=1)
