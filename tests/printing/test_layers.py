"""One row per layer."""

import numpy as np
import pytest

from cablewright.printing.layers import layer_table
from cablewright.printing.path import sample
from cablewright.printing.timing import time_law


def table_of(read, text: str):
    samples = sample(read(text), 10, (0, 0, 1), 0.05, 0.3, 0.5)
    law = time_law(samples, 0.5)
    return samples, law, layer_table(samples, law)


TWO = "M83\nG1 Z1\n;LAYER:0\nG1 X100 E1\nG4 S3\nG1 X0\n;LAYER:1\nG1 Z2\nG1 X50 E1\n;LAYER:2\nG1 Z9\n"


def test_heights_lengths_and_ranges(read):
    samples, _, table = table_of(read, TWO)
    assert table.number.tolist() == [1, 2, 3]
    assert table.z == pytest.approx([1.01, 1.02, np.nan], nan_ok=True)
    assert table.extruded_length == pytest.approx([1, 0.5, 0])
    assert table.travel_length == pytest.approx([1, 0.01, 0.07])
    assert table.first.tolist()[1:] == table.stop.tolist()[:-1]
    assert table.stop[-1] == len(samples)
    for number, first, stop in zip(table.number, table.first, table.stop, strict=True):
        assert set(samples.layer[first:stop]) == {number}
    assert len(table) == 3


def test_durations_add_up(read):
    _, law, table = table_of(read, TWO)
    before = law.time[table.first[0] - 1]
    assert before > 0
    assert table.duration.sum() + before == pytest.approx(law.duration)
    assert table.duration[0] == pytest.approx(law.time[table.stop[0] - 1] - before)
    assert table.duration[0] > 3 + 1 / 0.3 + 1 / 0.5


def test_a_dwell_counts_where_it_is_waited(read):
    with_dwell, without = TWO.replace("G1 X0\n", "G1 X0\nG4 S20\n"), TWO.replace("G1 X0\n", "G1 X0\nG4 P1\n")
    longer = table_of(read, with_dwell)[2].duration - table_of(read, without)[2].duration
    assert longer == pytest.approx([19.999, 0, 0])


def test_a_second_part_comes_back_to_a_layer(read):
    part = ";LAYER:0\nG1 X0 Z1\nG1 X100 E1\n;LAYER:1\nG1 X0 Z2\nG1 X100 E1\n"
    _, _, table = table_of(read, "M83\n" + part + part)
    assert table.number.tolist() == [1, 2, 1, 2]
    assert table.extruded_length == pytest.approx([1] * 4)
