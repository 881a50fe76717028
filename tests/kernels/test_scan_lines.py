"""What a lidar's turn is worked on with, against NumPy; the lines and places themselves: tests/estimation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.kernels.fitting.scan_lines import TURN, choose, median, sweep
from cablewright.kernels.fitting.walls_seen import explain
from cases import some


@settings(deadline=None)
@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=40))
def test_the_median_is_numpys(values: list[float]) -> None:
    given_ = np.array(values)
    assert median(given_, len(values), np.empty(len(values))) == np.median(given_)
    assert given_.tolist() == values


@pytest.mark.parametrize("seed", some(range(4)))
def test_points_are_counted_as_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turned, level, xy = rng.normal(0.0, 1.0, (7, 4, 2)), rng.normal(-1.0, 1.0, (7, 4)), rng.normal(0.0, 1.0, (2, 60))
    sees, scores = rng.random(4) < 0.6, np.zeros(7)
    explain(turned, level, xy, sees, 0.3, 0.9, np.empty((2, 60)), scores)
    off = turned @ xy + level[:, :, None]
    beyond, on = (off > 0.9).any(axis=1), (np.abs(off[:, sees]) <= 0.3).any(axis=1)
    np.testing.assert_array_equal(scores, (on & ~beyond).sum(axis=1) - beyond.sum(axis=1))


@pytest.mark.parametrize("seed", some(range(6)))
def test_rays_are_left_out_as_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles, ranges = rng.uniform(-10.0, 10.0, 80), rng.uniform(0.0, 3.0, 80)
    tilts, drift = rng.normal(size=(80, 2)), rng.normal(size=(80, 3))
    for array in (angles, ranges, tilts, drift):
        array.ravel()[rng.integers(0, array.size, 5)] = rng.choice([np.nan, np.inf, -np.inf], 5)
    masks, chosen, bearing = np.array([[3.0, 3.6], [-0.2, 0.3]]), np.empty(80, np.int64), np.empty(80)
    count = choose(angles, ranges, tilts, drift, np.array([0.2, 2.5]), masks, chosen, bearing)
    with np.errstate(invalid="ignore"):
        masked = sum((angles - begin) % TURN <= (end - begin) % TURN for begin, end in masks)
    finite = np.isfinite(np.column_stack([angles, ranges, tilts, drift])).all(axis=1)
    good = np.flatnonzero(finite & (ranges >= 0.2) & (ranges <= 2.5) & ~masked.astype(bool))
    assert chosen[:count].tolist() == good.tolist()
    assert bearing[:count] == pytest.approx(np.mod(angles[good], TURN))
    assert choose(angles, ranges, np.zeros((1, 2)), drift[:0], np.array([0.2, 2.5]), masks, chosen, bearing) >= count


@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_a_line_is_swept_when_its_rays_are(sense: float) -> None:
    """A wall at x = 2 m from the lidar, seen in a turn of 0.1 s: times, and what an error of the rate of turn does."""
    mount, yaw, tangents = np.array([0.1, -0.2]), 0.3, np.tan(np.linspace(-0.5, 0.5, 2001))
    ends = mount + np.array([[[2.0, 2.0 * tangents[0]], [2.0, 2.0 * tangents[-1]]]])
    step, count = sense * TURN / 400, 400
    last, found = -1.0 + step * (count - 1), np.empty((1, 6))
    own = np.append(mount, yaw), np.array([last, step, 0.1 / count])
    sweep(np.zeros(1), np.array([2.0]), ends[:, ::-1] if sense < 0.0 else ends, *own, found)
    bearings = np.arctan(tangents)
    times = 0.1 / TURN * (sense * (last - (bearings - yaw)) % TURN)  # s until the end
    to_end, along, slope, aside, by_rate, off_by_rate = found[0]
    assert to_end == pytest.approx(times.mean(), abs=1e-6)
    assert along == pytest.approx(2.0 * tangents.mean(), abs=1e-6)
    assert aside == pytest.approx(mount[1])
    about, turned = 2.0 * tangents - 2.0 * tangents.mean(), times * (2.0 * tangents + mount[1])
    assert slope == pytest.approx(about @ times / (about @ about), rel=0.02)
    assert by_rate == pytest.approx(about @ turned / (about @ about), rel=0.02)
    assert off_by_rate == pytest.approx(turned.mean(), abs=0.02 * np.abs(turned).mean())
