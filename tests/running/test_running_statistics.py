"""Moments in portions are those of all numbers together; thinned rows are evenly spaced and never too many."""

import numpy as np
import pytest

from cablewright.running.running_statistics import Histogram, Moments, ThinnedRows


@pytest.mark.parametrize("portion", [1, 7, 1000])
def test_moments_in_portions_are_those_of_all(portion: int) -> None:
    rng = np.random.default_rng(3)
    values = 1e3 + rng.normal(0.0, [1e-3, 2.0, 5.0], (2500, 3))
    values[rng.random(values.shape) < 0.1] = np.nan
    values[:, 2] = np.nan
    moments = Moments(3)
    for begin in range(0, len(values), portion):
        moments.add(values[begin : begin + portion])
    for column in (0, 1):
        known = values[np.isfinite(values[:, column]), column]
        summary = moments.summary(column)
        assert summary.count == len(known)
        assert summary.mean == pytest.approx(known.mean(), rel=1e-14)
        assert summary.variance == pytest.approx(known.var(), rel=1e-9)
        assert (summary.min, summary.max) == (known.min(), known.max())
        assert summary.size == np.abs(known).max()
    none = moments.summary(2)
    assert none.count == 0
    assert np.isnan([none.mean, none.variance, none.min, none.max, none.deviation]).all()


def test_thinned_rows_are_evenly_spaced_and_bounded() -> None:
    thinned, sent = ThinnedRows(2, capacity=100), 0
    rng = np.random.default_rng(4)
    while sent < 12_345:
        count = int(rng.integers(1, 60))
        thinned.add(np.column_stack([np.arange(sent, sent + count), np.zeros(count)]))
        sent += count
        index = thinned.rows[:, 0]
        assert len(index) <= 100
        assert index[0] == 0.0
        assert (np.diff(index) == thinned.every).all()
        assert index[-1] > sent - 1 - thinned.every
    assert len(thinned.rows) >= 50


def test_a_portion_larger_than_the_capacity_is_thinned_too() -> None:
    thinned = ThinnedRows(1, capacity=10)
    thinned.add(np.arange(1000.0)[:, None])
    assert thinned.rows[:, 0].tolist() == list(np.arange(0.0, 1000.0, thinned.every))
    assert 5 <= len(thinned.rows) <= 10


def test_a_histogram_counts_each_number_once() -> None:
    histogram = Histogram(-1.0, 1.0, 8)
    histogram.add(np.array([-5.0, -1.0, -0.01, 0.0, 0.99, 1.0, 7.0, np.nan]))
    assert histogram.counts.tolist() == [2, 0, 0, 1, 1, 0, 0, 3]
