"""A run that was cut off goes on in its folder: of the same machine, and as one that may be cut off again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from cablewright.apps.serve.uploads import Uploads
from cablewright.foundation.errors import InputError
from cablewright.live.prints.recorder import Timing
from cablewright.live.prints.run import CHECKPOINT
from cablewright.live.serve.control_process import RUN, RUNS, Control
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.operated_machines import SimulatedStation, resting_pose
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.robot import load

NAME = "20260101-000000-ring"


@pytest.fixture
def control(tmp_path: Path) -> Iterator[Control]:
    robot = load("house-printer")
    station = SimulatedStation(robot, built_machine(robot)[0], 0, resting_pose(robot))
    made = Control(station, ControlLink.new(), tmp_path, lambda: True)
    yield made
    made.close()
    made.link.close()


def test_a_run_goes_on_only_on_the_machine_that_it_was_begun_on(control: Control) -> None:
    job, sitting = Uploads(control.folder).new_job("ring"), control.station.sitting(None)
    with control._kept(sitting, NAME, job, Timing(0.01)):
        pass
    with control._kept(sitting, NAME, job, Timing(0.01)):
        pass
    owner = sitting.head.settings
    slower = owner.winch.model_copy(update={"max_speed": 0.5 * owner.winch.max_speed})
    other = replace(sitting, head=replace(sitting.head, settings=owner.model_copy(update={"winch": slower})))
    with pytest.raises(InputError, match="machine file has changed"), control._kept(other, NAME, job, Timing(0.01)):
        pass


def test_a_run_that_goes_on_after_a_stop_may_be_cut_off(control: Control) -> None:
    uploads = Uploads(control.folder)
    job, sitting, folder = uploads.new_job("ring"), control.station.sitting(None), control.folder / RUNS / NAME
    with control._kept(sitting, NAME, job, Timing(0.01)):
        (folder / CHECKPOINT).touch()
    control._end(sitting, NAME, Timing(0.01))
    assert [(each["cut_off"], each["can_resume"]) for each in uploads.runs({})] == [(False, True)]
    with control._kept(sitting, NAME, job, Timing(0.01)):
        assert not (folder / RUN).exists()
    assert [(each["cut_off"], each["can_resume"]) for each in uploads.runs({})] == [(True, True)]
