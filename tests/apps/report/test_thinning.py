"""Fewer segments that still show everything that is to be seen."""

import numpy as np
import pytest

from apps.report.synthetic import EXAMPLES
from cablewright.apps.report import thinning
from cablewright.apps.report.thinning import coarse_corners, worst_of_each_place
from cablewright.foundation import memory_mapped
from cablewright.printing.job import load_job


@pytest.fixture(scope="module")
def house():
    job = load_job(EXAMPLES / "house.toml")
    return job.samples(job.toolpath())


def test_worst_of_each_place_keeps_the_worst(house):
    known = np.flatnonzero(house.extruding)
    error = np.random.default_rng(1).random(len(house))
    pieces = worst_of_each_place(house, known, error, 3000)
    assert 300 < len(pieces) <= 3000
    assert pieces.end[-1] == known[np.argmax(error[known])]
    assert (np.diff(error[pieces.end]) >= 0).all()
    assert (pieces.begin == pieces.end - 1).all()
    assert house.extruding[pieces.end].all()


def test_uncut_pieces_cover_every_extruded_metre(house):
    known = np.flatnonzero(house.extruding)
    pieces = coarse_corners(house, known, len(house), 4)
    covered = np.linalg.norm(house.positions[pieces.end] - house.positions[pieces.begin], axis=1).sum()
    assert covered == pytest.approx(house.extruded_length, rel=1e-9)
    assert (pieces.end - pieces.begin <= 4).all()


@pytest.mark.parametrize("most", [18_000, 40_000])
def test_pieces_are_few_and_reach_from_bottom_to_top(house, most):
    known = np.flatnonzero(house.extruding)
    pieces = coarse_corners(house, known, most, 10)
    assert most / 4 < len(pieces) < 1.3 * most
    assert house.layer[pieces.end].min() == house.layer[known].min()
    assert house.layer[pieces.end].max() == house.layer[known].max()


def test_one_layer_of_many_corners(house):
    known = np.flatnonzero(house.extruding & (house.layer == 3))
    assert 0 < len(coarse_corners(house, known, 50, 10)) <= 100


def test_nothing(house):
    none = np.empty(0, dtype=np.intp)
    assert len(coarse_corners(house, none, 10, 10)) == 0
    assert len(worst_of_each_place(house, none, np.zeros(len(house)), 10)) == 0


@pytest.mark.parametrize("size", [97, 4096])
def test_pieces_are_the_same_in_smaller_blocks(house, monkeypatch, size):
    known = np.flatnonzero(house.extruding)[:60_000]
    error = np.round(np.random.default_rng(2).random(len(house)), 2)  # with equals
    wholes = worst_of_each_place(house, known, error, 3000), coarse_corners(house, known, 9000, 4)
    monkeypatch.setattr(memory_mapped, "BLOCK", size)
    monkeypatch.setattr(thinning, "BLOCK", size)
    parts = worst_of_each_place(house, known, error, 3000), coarse_corners(house, known, 9000, 4)
    for whole, part in zip(wholes, parts, strict=True):
        np.testing.assert_array_equal(whole.begin, part.begin)
        np.testing.assert_array_equal(whole.end, part.end)


def test_a_place_shows_the_first_of_equal_errors(house):
    known = np.flatnonzero(house.extruding)[:500]
    once = worst_of_each_place(house, known, np.zeros(len(house)), 10**6)
    twice = worst_of_each_place(house, np.concatenate([known, known]), np.zeros(len(house)), 10**6)
    np.testing.assert_array_equal(once.end, twice.end)
