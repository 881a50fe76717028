"""The house of the examples, a real slicer's file: its known properties."""

import time
from pathlib import Path

import numpy as np
import pytest

from cablewright.printing.job import Bead, Motion, Sampling, load_job
from cablewright.printing.layers import layer_table

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def house():
    job = load_job(EXAMPLES / "house.toml")
    toolpath = job.toolpath()
    samples = job.samples(toolpath)
    return job, toolpath, samples, job.time_law(samples)


def test_the_job(house):
    job = house[0]
    assert (job.scale, job.origin) == (20, (0, 0, 0))
    assert job.bead == Bead(width=0.06, height=0.02)
    assert job.motion == Motion(print_speed=0.3, travel_speed=0.5, acceleration=0.5, corner_deviation=0.005)
    assert job.sampling == Sampling(step=0.05)


def test_moves_and_layers(house):
    toolpath = house[1]
    assert toolpath.layer_count == 140
    assert np.count_nonzero(toolpath.extruding) == 35_014
    assert toolpath.unknown == {"M107": 18, "M106": 16, "M104": 1, "M140": 1}
    assert set(toolpath.layer.tolist()) == set(range(141))


def test_lengths_at_full_scale(house):
    samples = house[2]
    assert samples.extruded_length / 1e3 == pytest.approx(16.71, abs=0.005)
    assert samples.travel_length / 1e3 == pytest.approx(1.09, abs=0.005)
    assert 350_000 < len(samples) < 400_000


def test_it_stands_in_the_middle_of_the_frame(house):
    samples = house[2]
    laid = samples.positions[samples.extruding]
    width = 0.06
    assert laid.min(axis=0) == pytest.approx([-4 + width / 2, -3 + width / 2, 0.02], abs=1e-6)
    assert laid.max(axis=0) == pytest.approx([4 - width / 2, 3 - width / 2, 2.8], abs=1e-6)


def test_time(house):
    _, _, samples, law = house
    assert law.speed.max() <= 0.3 + 1e-12
    assert law.duration > (np.diff(samples.distance) / samples.speed_limit[1:]).sum()
    assert law.duration / 3600 == pytest.approx(53.6, abs=0.1)


def test_layers(house):
    table = layer_table(house[2], house[3])
    assert table.number.tolist() == list(range(1, 141))
    assert table.z == pytest.approx(0.02 * np.arange(1, 141))
    assert table.extruded_length.sum() == pytest.approx(house[2].extruded_length)
    assert table.duration.min() > 600


def test_it_is_read_quickly(house):
    job = house[0]
    begin = time.perf_counter()
    job.time_law(job.samples(job.toolpath()))
    assert time.perf_counter() - begin < 2  # 0.1 s on an idle machine
