"""A redundant point platform holds the tensions that the control chooses by its load cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.accuracy.tension_spread import tension_spread
from cablewright.foundation.signals import Encoders, PrintState, SensorFrame, Tensions
from cablewright.live.estimators import Measuring, estimator
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.tracking_errors import WholeErrors
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.log.log import read_log
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import whole_machine
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cases import some

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


@pytest.mark.parametrize("seed", some([0, 7]))
def test_tensions_that_nothing_measures_stay_within_their_limits_as_cables_creep(seed: int, tmp_path: Path) -> None:
    robot = load("hangprinter-v4")
    ring = RING.model_copy(
        update={"origin": (0.0, 0.0, 0.0), "helix": Helix(radius=0.2, layers=1, layer_height=2e-3, first_height=0.3)}
    )
    options = PrintOptions(plant="quasi-static", period=1.0, seed=seed, severity="typical")
    twin = twin_of(robot, ring, None, options)
    narrow = plan_print(twin).velocity.model.robot.lines[0].tension_limits
    assert 5.0 < narrow[0] < narrow[1] < 30.0  # N, of 1 to 35 N
    assert any("nothing measures tensions" in note for note in plan_print(twin).notes)
    done = print_job(robot, ring, tmp_path / "run", options=options)
    assert done.finished  # also in steps so long that lines turn in them
    with read_log(tmp_path / "run") as log:
        entries = [each for each in log.entries() if each.progress is not None and each.truth is not None]
    pulls = np.array([each.truth.tensions for each in entries if each.progress.state is PrintState.PRINTING])
    assert pulls.min() > 1.0
    assert pulls.max() < 35.0


def test_the_spread_of_tensions_is_that_of_solved_machines() -> None:
    model = Model(load("hangprinter-v4"))
    held = solve_inverse(model, np.array([[0.1, 0.0, 0.4], [0.3, 0.1, 0.6]]), preferred=np.full((1, 4), 12.0)).checked()
    found = tension_spread(held, 1e-5, 0.0, 1e-9, 1e-6)
    changed = np.zeros((4, 4))
    for i in range(4):
        longer = held.lengths[1] + 1e-5 * np.eye(4)[i]
        changed[i] = solve_forward(model, longer, guess=held.pose[1]).checked().tensions - held.tensions[1]
    assert found.deviation[1] == pytest.approx(np.sqrt((changed**2).sum(axis=0)), rel=0.02)
    crept = solve_forward(model, held.lengths[1] * (1.0 + 1e-6), guess=held.pose[1]).checked().tensions
    assert found.fall[1] == pytest.approx(held.tensions[1] - crept, rel=0.02)
    points = tension_spread(held, 1e-12, 0.0, 1e-3, 1e-6).deviation
    assert points[0] == pytest.approx(np.zeros(4), abs=1e-6)  # where it was homed
    assert (points[1] > 0.1).all()


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_reading_of_another_number_of_lines_raises_nothing_and_changes_nothing(name: str) -> None:
    robot, owner = load(name), whole_machine(name).with_owner(load_cells=CELLS).owner
    found = estimator("encoders", robot, owner, np.array(rest_pose(robot).equilibrium.pose))
    pulls, counts = np.full(robot.m, 50.0), np.zeros(robot.winches, np.int64)
    first = found.step(SensorFrame(1.0, (Encoders(1.0, counts), Tensions("load_cells", 1.0, pulls))))
    wrong = Encoders(1.1, counts[:3] + 900), Tensions("load_cells", 1.1, pulls[:3])
    then = found.step(SensorFrame(1.1, wrong))
    np.testing.assert_allclose(then.position, first.position, atol=1e-9)
    assert any("a reading of 3 winches" in fault.sentence for fault in then.faults)
    assert found.tensions is not None
    assert len(found.tensions) == robot.m


def test_tensions_by_the_lengths_are_known_beside_those_that_cells_read() -> None:
    robot, owner = load("cogiro"), whole_machine("cogiro").with_owner(load_cells=CELLS).owner
    found = estimator("encoders", robot, owner, np.array(rest_pose(robot).equilibrium.pose))
    assert isinstance(found, Measuring)
    before = found.measured
    assert before is None
    assert found.tensions is not None
    pulls = found.tensions.copy()
    stuck = np.where(np.arange(robot.m) == 2, np.nan, 50.0)
    readings = Encoders(1.0, np.zeros(robot.winches, np.int64)), Tensions("load_cells", 1.0, stuck)
    found.step(SensorFrame(1.0, readings))
    np.testing.assert_allclose(found.tensions, pulls, rtol=1e-6)
    assert found.measured is not None
    np.testing.assert_allclose(found.measured, np.where(np.isnan(stuck), pulls, stuck), rtol=1e-6)
