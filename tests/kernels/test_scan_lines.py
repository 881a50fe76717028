"""What a lidar's turn is worked on with, against NumPy; the lines and places themselves: tests/estimation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.kernels.fitting.scan_lines import explain, median
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
