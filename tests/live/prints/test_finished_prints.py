"""A print that was killed after its end says so when it is resumed; a record of a run is that of its log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tools.random_world import Followed, Shaken, plan

from cablewright.control.supervisor import NOT_RESET
from cablewright.foundation.choices import EstimatorName
from cablewright.foundation.saved_state import Snapshot
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.record import finish
from cablewright.live.prints.recorder import checkpoint_of
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load


@pytest.mark.parametrize("finished", [True, False])
def test_a_print_that_had_its_end_is_resumed_as_finished(finished: bool) -> None:
    def printer(saved: dict[str, Snapshot] | None = None) -> Printer:
        machine = Shaken(np.random.default_rng(0), calm=True)
        return Printer(plan(), machine, lambda _place, _radii: Followed(machine), saved=saved)

    first = printer()
    first.supervisor.finished = finished
    again = printer(checkpoint_of(first))
    assert again.finished is finished
    assert (again.supervisor.state, again.supervisor.reason) == (
        PrintState.FAULT,
        "finished" if finished else NOT_RESET,
    )


def ring(radius: float) -> Job:
    helix = Helix(radius=radius, layers=1, layer_height=1e-3, first_height=1.0)
    return Job(name="ring", helix=helix, motion=Motion(print_speed=0.05, travel_speed=0.05, acceleration=0.05))


@pytest.mark.parametrize(
    ("robot", "estimator"),
    [("house-printer", "encoders"), pytest.param("merlet2023", "filter", marks=pytest.mark.slow)],
)
def test_the_record_of_a_run_is_that_of_its_log(tmp_path: Path, robot: str, estimator: EstimatorName) -> None:
    """To the bit, with all rows: the sums of a print while it runs, and those of its log afterwards."""
    options = PrintOptions(estimator)
    made = print_job(robot, ring(0.05), tmp_path / "run", options=options)
    assert made.finished
    assert isinstance(made.run.machine, SimulatedMachine)
    path = twin_of(load(robot), ring(0.05), None, options).path
    structure = made.run.machine.rig.ground.field
    read, _ = finish(made.run.folder, path.track, path.print_speed, structure, attitude=path.attitude)
    assert made.record is not read
    assert made.record.to_dict() == read.to_dict()
    assert made.record.rows.tobytes() == read.rows.tobytes()
    assert made.record.steps > 500


def test_a_thinned_log_has_the_record_of_its_own_steps(tmp_path: Path) -> None:
    made = print_job("house-printer", ring(0.02), tmp_path / "run", options=PrintOptions("encoders", log_every=5))
    assert made.run.record is None
    assert made.record.steps < 0.25 * len(made.run.timing.wall)
