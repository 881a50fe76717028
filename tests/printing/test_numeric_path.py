"""Paths that a job gives in numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing.job import load_job
from cablewright.printing.layers import layer_table
from cablewright.printing.numeric_path import Helix, RandomCurve

CURVE = (
    'schema = 1\nname = "c"\n[curve]\nseed = 1\nlength = "28 m"\narea = [3.6, 8.0]\nlayers = 3\nlayer_height = "2 mm"\n'
)
HELIX = 'schema = 1\nname = "h"\norigin = [1.0, 2.0, 0.5]\n[helix]\nradius = 0.5\nlayers = 4\nlayer_height = 0.1\n'


def written(folder: Path, text: str) -> Path:
    file = folder / "job.toml"
    file.write_text(text)
    return file


def test_a_curve_goes_round_once_a_layer(tmp_path: Path) -> None:
    job = load_job(written(tmp_path, CURVE))
    toolpath = job.toolpath()
    assert toolpath.layer_count == 3
    np.testing.assert_array_equal(toolpath.start[1:], toolpath.end[:-1])
    assert toolpath.extruding.all()
    assert toolpath.length.sum() == pytest.approx(3 * 28.0, rel=1e-4)
    rises = np.diff(np.append(toolpath.start[:, 2], toolpath.end[-1, 2]))
    assert rises.min() >= 0.0
    assert toolpath.end[:, 2].max() == pytest.approx(0.004)
    assert np.count_nonzero(rises > 1e-12) == 2 * 5  # pieces of 2 cm over which 2 mm are risen, 1 in 50
    moving = job.time_law(job.samples(toolpath)).speed
    assert (moving[1:-1] > 0.0).all()  # no stop between rounds
    samples = job.samples(toolpath)
    table = layer_table(samples, job.time_law(samples))
    np.testing.assert_allclose(table.extruded_length, 28.0, rtol=1e-4)
    np.testing.assert_allclose(table.z, [0.0, 0.002, 0.004], atol=1e-12)
    assert job.source == "random curve 0 of seed 1"
    assert job.move_name == "piece"


def test_a_helix_rises_evenly_about_the_origin(tmp_path: Path) -> None:
    job = load_job(written(tmp_path, HELIX))
    samples = job.samples(job.toolpath())
    from_axis = np.hypot(samples.positions[:, 0] - 1.0, samples.positions[:, 1] - 2.0)
    assert from_axis.max() == pytest.approx(0.5, rel=1e-9)
    assert from_axis.min() > 0.4995  # chords
    assert samples.positions[0, 2] == pytest.approx(0.5)
    assert samples.positions[-1, 2] == pytest.approx(0.9)
    assert samples.distance[-1] == pytest.approx(4 * np.hypot(np.pi, 0.1), rel=1e-3)
    assert np.unique(samples.layer).tolist() == [1, 2, 3, 4]
    assert samples.extruding[1:].all()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('schema = 1\nname = "n"\n', "no path given: give one of gcode, "),
        (CURVE + HELIX.split("\n", 3)[3], "curve and helix given: give one of gcode"),
        (CURVE.replace("layers = 3", "layers = 0"), "curve.layers = 0"),
        (CURVE.replace("layers = 3", "layers = 2.5"), "curve.layers = 2.5"),
        (CURVE.replace('"28 m"', '"-28 m"'), "curve.length"),
        (CURVE.replace("seed = 1", "seed = -1"), "curve.seed = -1"),
        (CURVE.replace("seed", "sead"), "sead"),
        (HELIX.replace("layer_height = 0.1", "layer_height = 0"), "helix.layer_height = 0: must be greater than 0"),
        (HELIX.replace("radius = 0.5", 'radius = "0.5 kg"'), "helix.radius"),
    ],
)
def test_one_line_says_what_is_wrong(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        load_job(written(tmp_path, text))
    assert words in str(caught.value)
    assert "job.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_path_of_too_many_pieces_is_rejected_before_it_is_made() -> None:
    path = Helix(radius=1000.0, layers=100_000, layer_height=0.1)
    with pytest.raises(InputError, match="fewer layers"):
        path.toolpath()
    with pytest.raises(InputError, match="fewer layers"):
        RandomCurve(seed=0, length=28.0, area=(3.6, 8.0), layers=100_000, layer_height=0.0).toolpath()


def test_the_example_is_the_papers_campaign_in_length() -> None:
    job = load_job(Path(__file__).parents[2] / "examples" / "blind-machines.toml")
    toolpath = job.toolpath()
    assert toolpath.layer_count == 142
    assert toolpath.length.sum() == pytest.approx(142 * 28.0, rel=1e-3)
