"""A redundant point platform holds the tensions that the control chooses by what its load cells measure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cablewright.live.prints.plan import PrintOptions
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.whole_errors import WholeErrors
from cablewright.machine.log.log import read_log
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import whole_machine
from cablewright.printing.job import Job
from cablewright.robot import load

RING = Job.model_validate({
    "name": "ring",
    "origin": [0.4, -0.3, 0.0],
    "helix": {"radius": 1.0, "layers": 1, "layer_height": "12 mm", "first_height": "2 m"},
    "motion": {"print_speed": "10 cm/s", "travel_speed": "10 cm/s", "acceleration": "50 mm/s^2"},
})  # fmt: skip
CELLS = TensionSensor(rate=10.0, deviation=3.0, bias=3.0, gain_deviation=0.005, most=1e4)


def errors(folder: Path, cells: TensionSensor | None) -> WholeErrors:
    machine = whole_machine("house-printer").with_owner(load_cells=cells)
    options = PrintOptions(plant="quasi-static", period=0.5, seed=3)
    return print_job(load("house-printer"), RING, folder, machine=machine, options=options).record.whole


def test_load_cells_hold_the_tensions_better_than_lengths_and_move_nothing(tmp_path: Path) -> None:
    by_cells, by_lengths = errors(tmp_path / "cells", CELLS), errors(tmp_path / "lengths", None)
    assert by_cells.tension_error_rms < 0.7 * by_lengths.tension_error_rms
    assert by_cells.tension_error_rms < CELLS.bias + 0.005 * 1000.0
    assert by_cells.tension_error_rms <= by_cells.tension_error_max
    assert abs(by_cells.position_rms - by_lengths.position_rms) < 1e-4  # the null space of the lengths


def test_the_chosen_tensions_are_in_the_log_while_it_prints(tmp_path: Path) -> None:
    found = errors(tmp_path, CELLS)
    off = []
    with read_log(tmp_path) as log:
        for entry in log.entries():
            assert entry.progress is not None
            assert entry.truth is not None
            prints = entry.progress.state.value == "printing"
            assert (entry.progress.tensions is not None) == prints
            if entry.progress.tensions is not None:
                off.append(entry.truth.tensions - entry.progress.tensions)
    assert np.isclose(np.sqrt(np.mean(np.square(off))), found.tension_error_rms, rtol=1e-6)
    assert np.isclose(np.abs(off).max(), found.tension_error_max, rtol=1e-6)
