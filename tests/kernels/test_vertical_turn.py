"""Kernels of a vertical scan against formulas of whole arrays and rotation matrices."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from cablewright.estimation.height import floor_points
from cablewright.estimation.kalman.state import FilterLayout, Mean
from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering import vertical_turn as kernel

M, WALLS = 4, 2
PLACE, AXIS_X, AXIS_Y = np.array([0.22, 0.03, -0.75]), np.array([0.0, 0.1, -1.0]), np.array([1.0, 0.0, 0.0])
LIDAR = np.concatenate([PLACE, AXIS_X, AXIS_Y])
WALL = np.array([0.8, 0.6, -0.6, 0.8, 0.4, 3.1])  # normal, along, reference, distance
FLOOR = 0.05


class Case(NamedTuple):
    """A scan, and the state of the filter by which its points are computed."""

    ranges: Array
    times: Array
    attitudes: Array
    yaw: float
    rotation: Array
    coasting: Array
    displacement: Array
    mean: Mean
    jacobian: Array
    velocity: Array
    estimate: Array


def case(seed: int, n: int = 300, echo: bool = True) -> Case:
    """A scan in a box with random errors of all that the state holds; a third of its rays have no valid echo."""
    random, angles = np.random.default_rng(seed), -math.pi + math.tau / max(n, 1) * np.arange(n)
    down, aside = np.abs(np.cos(angles)) + 1e-9, np.abs(np.sin(angles)) + 1e-9
    ranges = np.minimum(1.2 / down, 2.5 / aside) + 2e-3 * random.standard_normal(n)
    bad = random.random(n) < (0.33 if echo else 1.1)
    ranges[bad] = random.choice([np.nan, np.inf, -np.inf, 0.0, -1.0], n)[bad]
    mean = Mean.of(FilterLayout.of(M, 2, WALLS))
    mean.x[:] = 1e-2 * random.standard_normal(len(mean.x))
    mean.x[mean.layout.position] = 0.3, 0.2, 1.9
    mean.x[mean.layout.radii] = random.uniform(0.05, 0.1, M)
    still = random.random(n) < 0.5
    return Case(
        ranges, 7.0 + 1e-3 * np.arange(n), 0.05 * random.standard_normal((n, 3)), 0.3,
        random.standard_normal((n, M)), np.where(still, 0.0, random.random(n)), 0.1 * random.standard_normal((n, 3)),
        mean, random.standard_normal((3, M)), random.standard_normal(3), mean.x[:3] + 0.01 * random.standard_normal(3),
    )  # fmt: skip


def rays(c: Case) -> Array:
    """The turn as the kernel has it."""
    n = len(c.ranges)
    return np.asarray(
        kernel.rays(
            c.ranges, -math.pi, math.tau / max(n, 1), 7.0, 1e-3, LIDAR, c.attitudes, c.yaw, c.rotation, c.coasting,
            c.displacement, c.mean.x, c.mean.at, 8.1, 8.2,
        )
    )  # fmt: skip


class Drawn(NamedTuple):
    """The rays with an echo, by whole arrays."""

    axis_cosine: Array
    rays: Array  # level, along the drum's axes, like the next two
    points: Array
    beams: Array
    heading: Array  # (k, 2, 2): turns such axes to the world's
    position: Array
    gyro_time: Array
    counted_time: Array
    good: Array


def drawn(c: Case) -> Drawn:
    """The rays with an echo: their vectors are turned by the second-order series of the exponential."""
    good = np.flatnonzero(np.isfinite(c.ranges) & (c.ranges > 0.0))
    angles, x = (-math.pi + math.tau / len(c.ranges) * np.arange(len(c.ranges)))[good], c.mean.x
    straight = np.cos(angles)[:, None] * AXIS_X + np.sin(angles)[:, None] * AXIS_Y
    lean = np.zeros((len(good), 3))
    lean[:, :2] = c.attitudes[good, 1:]
    mount = x[c.mean.layout.vertical_mount]

    def turned(v: Array) -> Array:
        once = np.cross(lean, v)
        return np.asarray(v + once + 0.5 * np.cross(lean, once))

    level = turned(straight)
    level = level + np.cross(mount[3:], level)
    beams = c.ranges[good, None] * level
    points = turned(np.broadcast_to(PLACE + mount[:3], level.shape)) + beams
    yaw = c.yaw + c.attitudes[good, 0]
    heading = np.stack([np.cos(yaw), -np.sin(yaw), np.sin(yaw), np.cos(yaw)], axis=1).reshape(-1, 2, 2)
    position = x[:3] - c.displacement[good]
    counted = 8.2 - c.times[good] - c.coasting[good]
    return Drawn(-straight[:, 2], level, points, beams, heading, position, 8.1 - c.times[good], counted, good)


def since(c: Case) -> Array:
    return np.asarray(c.mean.x[:3] - c.estimate - c.mean.x[c.mean.layout.clock] * c.velocity)


def derivative(c: Case, seen: Drawn, chosen: Array, n: Array) -> Array:
    """Row (size,) of the mean coordinate along *n* (3,), world, of the *chosen* points."""
    lay, row, toward = c.mean.layout, np.zeros(c.mean.layout.size), n @ c.jacobian
    own = np.append(np.mean([n[:2] @ turn for turn in seen.heading[chosen]], axis=0), n[2])
    flat = np.einsum("kij,kj->ki", seen.heading, seen.rays[:, :2])
    row[lay.position], row[lay.velocity] = n, -n * c.coasting[seen.good][chosen].mean()
    row[lay.radii] = -toward * c.mean.x[lay.radii] * c.rotation[seen.good][chosen].mean(axis=0)
    row[lay.stretch] = -toward * seen.counted_time[chosen].mean()
    row[lay.attitude] = np.cross(seen.points[chosen].mean(axis=0), own)
    row[lay.gyro_bias] = seen.gyro_time[chosen].mean() * row[lay.attitude]
    row[lay.range_bias.stop - 1] = -float((flat @ n[:2] + seen.rays[:, 2] * n[2])[chosen].mean())
    row[lay.vertical_mount] = np.append(own, np.cross(seen.beams[chosen].mean(axis=0), own))
    row[lay.clock] = -n @ c.velocity
    return row


@pytest.mark.parametrize(("seed", "n", "echo"), [(1, 300, True), (2, 1, True), (3, 40, False)])
def test_points_and_heights_of_a_scan(seed: int, n: int, echo: bool) -> None:
    c = case(seed, n, echo)
    turn, seen = rays(c), drawn(c)
    assert turn.shape == (len(seen.good), kernel.ROTATION + M)
    assert len(turn) or seed != 1
    assert turn[:, kernel.COSINE] == pytest.approx(seen.axis_cosine, abs=1e-12)
    assert turn[:, kernel.POINT : kernel.BEAM] == pytest.approx(seen.points, abs=1e-12)
    places, heights = np.empty((len(turn), 2)), np.empty(len(turn))
    kernel.locate(turn, c.mean.x, c.mean.at, c.velocity, c.estimate, FLOOR, places, heights)
    there = seen.position + since(c)
    flat = np.einsum("kij,kj->ki", seen.heading, seen.points[:, :2])
    assert places == pytest.approx(there[:, :2] + flat, abs=1e-12)
    bias = c.mean.x[c.mean.layout.range_bias.stop - 1]
    assert heights == pytest.approx(there[:, 2] + seen.points[:, 2] - FLOOR - bias * seen.rays[:, 2], abs=1e-12)


@pytest.mark.parametrize("count", [1, 2, 90])
def test_the_mean_height_and_its_derivative(count: int) -> None:
    c = case(4)
    turn, seen = rays(c), drawn(c)
    chosen = np.isin(np.arange(len(turn)), np.random.default_rng(count).permutation(len(turn))[:count])
    mean, row = np.empty(turn.shape[1]), np.full(c.mean.layout.size, np.nan)
    x, _, at = c.mean
    over = kernel.write_height(turn, chosen, x, at, c.jacobian, c.velocity, c.estimate, FLOOR, mean, row)
    places, heights = np.empty((len(turn), 2)), np.empty(len(turn))
    kernel.locate(turn, x, at, c.velocity, c.estimate, FLOOR, places, heights)
    assert over == pytest.approx(heights[chosen].mean(), abs=1e-12)
    assert mean == pytest.approx(turn[chosen].mean(axis=0), abs=1e-12)
    assert mean[kernel.Z_SQUARE] == pytest.approx(np.mean(seen.rays[chosen, 2] ** 2))
    assert row == pytest.approx(derivative(c, seen, chosen, np.array([0.0, 0.0, 1.0])), abs=1e-12)


@pytest.mark.parametrize("seed", range(5, 11))
@pytest.mark.parametrize("band", [0.02, 0.3, 1.5])
def test_the_points_of_a_wall_and_its_derivative(seed: int, band: float) -> None:
    """The wall is about where the box ends; a narrow band has too few points of it or none."""
    c = case(seed)
    turn, seen, (x, lay, at) = rays(c), drawn(c), c.mean
    rules = np.array([0.5, FLOOR + 0.1, band, 0.3 * band, 8.0])
    there = seen.position + since(c)
    flat, level = (np.einsum("kij,kj->ki", seen.heading, each[:, :2]) for each in (seen.points, seen.rays))
    steep, along = level @ WALL[:2], (there[:, :2] + flat) @ WALL[2:4] - WALL[4]
    off, turn_by = x[lay.walls][2:4]
    beyond = (there[:, :2] + flat) @ WALL[:2] - WALL[5] - off + turn_by * along
    beyond -= x[lay.range_bias.stop - 1] * steep
    flat_ones = (seen.axis_cosine < 0.5) & (seen.position[:, 2] + seen.points[:, 2] > FLOOR + 0.1)
    good = flat_ones & (steep > kernel.STEEP) & (np.abs(beyond) < band)
    if np.count_nonzero(good) >= 8:
        good &= np.abs(beyond - np.median(beyond[good])) < 0.3 * band
    mean, row = np.empty(turn.shape[1]), np.full(lay.size, np.nan)
    count, far = kernel.write_wall(turn, x, at, c.jacobian, c.velocity, c.estimate, WALL, 1, rules, mean, row)
    if np.count_nonzero(good) < 8:
        assert count == 0
        return
    assert count == np.count_nonzero(good)
    assert far == pytest.approx(beyond[good].mean(), abs=1e-12)
    expected = derivative(c, seen, good, np.array([*WALL[:2], 0.0]))
    expected[lay.walls] = 0.0, 0.0, -1.0, along[good].mean()
    assert row == pytest.approx(expected, abs=1e-12)


def test_walls_are_seen_by_some_cases_and_not_by_others() -> None:
    """What the test before this one compares."""
    counts = []
    for seed in range(5, 11):
        c = case(seed)
        mean, row = np.empty(kernel.ROTATION + M), np.empty(c.mean.layout.size)
        for band in (0.02, 0.3, 1.5):
            rules = np.array([0.5, FLOOR + 0.1, band, 0.3 * band, 8.0])
            x, _, at = c.mean
            found = kernel.write_wall(rays(c), x, at, c.jacobian, c.velocity, c.estimate, WALL, 1, rules, mean, row)
            counts.append(found[0])
    assert min(counts) == 0
    assert max(counts) > 20


def floor_by_arrays(heights: Array, along: Array, band: Array, share: float, ceiling: float) -> Array:
    """Floor points by sorted arrays, and lines by polynomial fits."""
    ordered, floor, wide = np.sort(heights), np.zeros(len(heights), np.bool_), band.mean() if len(band) else math.nan
    starts = ordered[: np.searchsorted(ordered, ceiling)]
    if not len(starts):
        return floor
    sizes = np.searchsorted(ordered, starts + wide) - np.arange(len(starts))
    middle = ordered[np.argmax(sizes >= max(share * sizes.max(), min(8, sizes.max())))] + 0.5 * wide
    for _ in range(3):
        near = ordered[np.abs(ordered - middle) < wide]
        middle = near.mean() if len(near) else middle
    near = np.flatnonzero(np.abs(heights - middle) < band)
    for run in np.split(near, np.flatnonzero(np.diff(near) > 4) + 1):
        if len(run) >= 4 and abs(np.polyfit(along[run], heights[run], 1)[0]) < 0.15:
            floor[run] = True
    return floor


@pytest.mark.parametrize("ceiling", [-0.1, 0.02, math.inf])
@pytest.mark.parametrize("k", [0, 1, 3, 12, 200])
def test_the_floor_is_the_lowest_level_in_runs_that_are_level(k: int, ceiling: float) -> None:
    random, marked = np.random.default_rng(k), 0
    for number in range(40):
        along = np.linspace(-2.0, 2.0, k)
        heights = random.choice([0.0, 0.008, 0.05], k) if number % 2 else np.maximum(0.0, 0.4 * (np.abs(along) - 1.0))
        heights = heights + 2e-3 * random.standard_normal(k)
        heights[random.random(k) < 0.1] = math.inf
        band, share = random.uniform(5e-3, 7e-3, k), random.choice([0.1, 0.4])
        found = floor_points(heights, along, band, share, ceiling)
        assert (found == floor_by_arrays(heights, along, band, share, ceiling)).all()
        marked += int(found.sum())
    assert (marked > 0) == (k >= 12 and ceiling > 0.0)
