"""The path on the machine: scaled, placed, sampled."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import Room
from cablewright.printing import path as path_module
from cablewright.printing.path import sample

SQUARE = "M83\n;LAYER:0\nG1 X100 F60\nG1 Y100 E1\nG1 X0 E1\nG1 Y0 F120 E1\n"


def test_scaled_and_placed(read):
    samples = sample(read(SQUARE), scale=20, origin=(1, 2, 3), step=10)
    assert samples.positions == pytest.approx(np.array([[1, 2, 3], [3, 2, 3], [3, 4, 3], [1, 4, 3], [1, 2, 3]]))
    assert samples.distance == pytest.approx([0, 2, 4, 6, 8])
    assert samples.extruding.tolist() == [False, False, True, True, True]
    assert samples.move.tolist() == [0, 0, 1, 2, 3]
    assert samples.line.tolist() == [3, 3, 4, 5, 6]
    assert samples.layer.tolist() == [1] * 5
    assert samples.speed_limit == pytest.approx([0.02, 0.02, 0.02, 0.02, 0.04])
    assert (samples.extruded_length, samples.travel_length) == pytest.approx((6, 2))
    assert len(samples) == 5


def test_nothing_is_laid_at_the_start(read):
    assert sample(read("G1 X100 E1"), step=1).extruding.tolist() == [False, True]


def test_limits_of_printing_and_travelling(read):
    text = "M83\nG1 X1 E1\nG1 X2\nG1 X3 E1 F6000\nG1 X4\nG1 X5 E1 F6\nG1 X6\n"
    samples = sample(read(text), scale=20, print_speed=0.3, travel_speed=0.5)
    assert samples.speed_limit[1:] == pytest.approx([0.3, 0.5, 0.3, 0.5, 0.002, 0.002])


@given(
    st.lists(st.tuples(*[st.integers(-50, 50)] * 3), min_size=1, max_size=12),
    st.floats(0.1, 50),
    st.floats(0.003, 2),
)
def test_laws_of_sampling(read, ends, scale, step):
    text = "M83\nG1 X0.5 E1\n" + "".join(f"G1 X{x} Y{y} Z{z} E1\n" for x, y, z in ends)
    toolpath = read(text)
    origin = (3.0, -4.0, 5.0)
    samples = sample(toolpath, scale, origin, step)
    leg = np.diff(samples.positions, axis=0)
    length = np.linalg.norm(leg, axis=1)
    assert (length > 0).all()
    assert length.max() <= step * (1 + 1e-6)
    assert np.diff(samples.distance) == pytest.approx(length)
    assert samples.distance[-1] == pytest.approx(toolpath.length.sum() * scale)
    last = np.flatnonzero(np.diff(samples.move, append=-1))
    moved = toolpath.length > 0
    assert (samples.positions[last] == (toolpath.end * scale + origin)[moved]).all()
    assert samples.move[last].tolist() == np.flatnonzero(moved).tolist()
    assert np.bincount(samples.move[1:]).max() <= np.ceil(toolpath.length.max() * scale / step) + 1


def test_an_exact_multiple_makes_no_extra_sample(read):
    assert len(sample(read("G1 X100 E1"), scale=3, step=0.1)) == 4


def test_dwell_stays_at_the_sample_reached(read):
    samples = sample(read("G4 S1\nG1 X100 E1\nG4 S2\nG1 E0\nG4 S3\nG1 X200 E4\nG4 S5\n"), step=0.05)
    assert samples.dwell.tolist() == [1, 0, 5, 0, 5]


def test_arrays_cannot_be_written(read):
    with pytest.raises(ValueError, match="read-only"):
        sample(read(SQUARE)).positions[0] = 1


def test_moves_that_rounding_swallows_give_no_sample(read):
    text = "M83\nG1 X100 E1\nG1 X100.00000000000001 E1\nG4 S1\nG1 X100 Y0.0000000000001 E1\nG1 X200 E1\n"
    samples = sample(read(text), scale=20, origin=(1000, 0, 0), step=10)
    assert samples.move.tolist() == [0, 0, 4]
    assert samples.dwell.tolist() == [0, 1, 0]


def test_nothing_left_or_too_far(read):
    with pytest.raises(InputError, match="no move longer than 1e-09 m"):
        sample(read("G1 X0.00001 E1"), scale=1e-4)
    with pytest.raises(InputError, match="leaves the 1000000 m"):
        sample(read("G1 X1000000 E1"), scale=1e4)


def test_too_fine_a_step(read, monkeypatch):
    with pytest.raises(InputError, match="step = 1e-12 m: more than 5000000 samples"):
        sample(read(SQUARE), step=1e-12)
    with pytest.raises(InputError, match="step"):
        sample(read(SQUARE), step=1e-320)
    monkeypatch.setattr(path_module, "MAX_SAMPLES", 5)
    with pytest.raises(InputError, match="step"):
        sample(read(SQUARE), step=0.05)


def test_room_in_files_has_more_samples_which_are_the_same(read, monkeypatch, tmp_path):
    within = sample(read(SQUARE), step=1e-5)
    monkeypatch.setattr(path_module, "MAX_SAMPLES", 5)
    in_files = sample(read(SQUARE), step=1e-5, room=Room(tmp_path))
    for field in dataclasses.fields(within):
        np.testing.assert_array_equal(getattr(within, field.name), getattr(in_files, field.name))
    monkeypatch.setattr(path_module, "MAX_IN_FILES", 5)
    with pytest.raises(InputError, match="more than 5 samples"):
        sample(read(SQUARE), step=1e-5, room=Room(tmp_path))
