"""Bands against NumPy's own, and stretches and heights of jobs of several shapes."""

import numpy as np
import pytest

from apps.report.synthetic import changed, make_check, ring_robot, small_job
from cablewright.apps.report.check_summary import Digest, band
from cablewright.studies.checks.path_statics import extreme, median


def test_band_is_that_of_the_known_numbers():
    rng = np.random.default_rng(3)
    values = rng.normal(size=(60, 3))
    values[rng.random((60, 3)) < 0.3] = np.nan
    values[10:20, 1] = np.nan
    starts = np.array([0, 10, 20, 51])
    found = band(values, starts)
    for i, (first, stop) in enumerate(zip(starts, [10, 20, 51, 60], strict=True)):
        for j in range(3):
            known = values[first:stop, j][~np.isnan(values[first:stop, j])]
            if len(known) == 0:
                assert np.isnan([part[i, j] for part in found]).all()
                continue
            assert found.low[i, j] == known.min()
            assert found.high[i, j] == known.max()
            assert found.middle[i, j] == np.quantile(known, 0.5, method="lower")


def test_median_of_nothing_known_is_nan():
    assert np.isnan(median(np.full(4, np.nan)))
    assert median(np.array([3.0, np.nan, 1.0])) == 1.0


def test_extreme():
    values = np.array([[np.nan, 2.0], [5.0, -1.0]])
    assert extreme(np.fmax, values) == 5.0
    assert extreme(np.fmin, values) == -1.0
    assert np.isnan(extreme(np.fmax, values * np.nan))


def layered(tmp_path, count: int, points: int = 3):
    text = "G21\nG90\nM83\nG1 F900\n" + "".join(
        f";LAYER:{i} Z:{i + 1}\nG1 Z{i + 1} X0 Y0\n" + "".join(f"G1 X{10 * (j + 1)} E1\n" for j in range(points))
        for i in range(count)
    )
    return Digest(*make_check(ring_robot(3), small_job(tmp_path, text)))


@pytest.mark.parametrize(("count", "by_layer"), [(3, False), (30, True), (700, False)])
def test_stretches_cover_the_print(tmp_path, count, by_layer):
    digest = layered(tmp_path, count)
    starts = digest.stretches
    assert starts[0] == 0
    assert (np.diff(starts) > 0).all()
    assert len(starts) <= 301
    assert digest.by_layer == by_layer
    if by_layer:
        assert set(digest.layers.first) <= set(starts)


def test_heights_are_the_layers(tmp_path):
    digest = layered(tmp_path, 30)
    heights = digest.heights
    np.testing.assert_allclose(heights.z, np.arange(1, 31) * 1e-3)
    z = digest.check.samples.positions[:, 2]
    np.testing.assert_allclose(heights.band(z).low, heights.z)
    np.testing.assert_allclose(heights.band(z).high, heights.z)
    assert sorted(heights.order) == list(digest.extruding)


def test_many_heights_are_sliced(tmp_path):
    heights = layered(tmp_path, 1000).heights
    assert 100 < len(heights.z) <= 402
    assert (np.diff(heights.starts) > 0).all()


def test_worst_is_where_material_is_laid(small):
    check, layers = small
    off = check.statics.uncompensated.copy()
    travel = int(np.flatnonzero(~check.samples.extruding)[-1])
    off[travel] += 5.0
    digest = Digest(changed(check, {"uncompensated": off}), layers)
    assert digest.worst != travel
    assert check.samples.extruding[digest.worst]


def test_nearest_lines_are_those_with_least_room(small):
    check, layers = small
    tensions = np.full_like(check.statics.tensions, 2000.0)
    tensions[7, 2], tensions[9, 0] = 21.0, 4990.0
    digest = Digest(changed(check, {"lowest_tension": tensions, "highest_tension": tensions}), layers)
    assert digest.nearest_lines(2) == [0, 2]
    assert digest.nearest_lines(1) == [2]
    assert digest.nearest_lines(9) == [0, 1, 2, 3]
