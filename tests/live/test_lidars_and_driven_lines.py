"""Lidar estimators on a robot whose lines are not one to a winch: on one drum, or pulled by a counterweight."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.live.prints.plan import PrintOptions
from cablewright.live.prints.print_job import print_job
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job
from cablewright.robot import Robot, load
from cases import some
from twins import TWIN


def _with(own: dict[str, Any], shift: float, winches: int = 4) -> Robot:
    """The powder printer with one line more, which is as the first but for *own* keys and is *shift*, m, along x."""
    table = load("merlet2023").model_dump(by_alias=True)
    lines = list(table["lines"][:winches])
    if winches == 3:
        lines[2] = lines[2] | {"exit_point": (0.0, 5.0, 4.03), "winch_exit": (0.0, 5.0, 0.0)}
    moved = {key: tuple(np.add(lines[0][key], [shift, 0.0, 0.0])) for key in ("exit_point", "winch_exit")}
    return Robot.model_validate(table | {"lines": [*lines, lines[0] | moved | {"name": "fifth"} | own]})


UP = {"exit_point": (0.0, 0.0, 4.03), "winch_exit": (2.0, 0.0, 4.03), "sheave": {"kind": "eyelet"}, "winch": {}}
ROBOTS = {
    "two lines on one drum": _with({"shared_winch": {"line": "south-west", "offset": 0.0, "winds": "along"}}, 2e-3),
    "four winches and a counterweight": _with(UP | {"counterweight": 10.0}, 0.0),
    "three winches and a counterweight": _with(UP | {"counterweight": 10.0}, 0.0, 3),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_lidars_find_it_and_its_covariance_is_honest(name: str) -> None:
    robot = ROBOTS[name]
    way = 0.4 * np.array(random_loop(robot, 28.0, 2)) - [0.0, 1.0]  # within the reach of three winches
    machine = SimulatedMachine(robot, TWIN, [*way[0], 1.2], seed=2)
    pilot, recording = Pilot(machine, way, DriveSettings(), 2), []
    for _ in range(1000):
        frame = machine.step(pilot.command())
        recording.append((frame, machine.truth))
    for estimator, most in (("paper", 8e-3), ("filter", 2.5e-3)):  # 4.9 and 1.6 mm with four lines alone
        one = OBSERVERS[estimator]
        settings = one.settings(robot, TWIN.owner, ())
        state, off, squared = one.start(settings), [], []
        for frame, truth in recording:
            found = one.step(settings, state, frame)
            if frame.time < 5.0:
                continue
            assert found.valid
            assert found.faults == ()
            away = found.position - truth.position
            off.append(float(np.linalg.norm(away)))
            if found.covariance is not None:
                squared.append(float(away @ np.linalg.solve(found.covariance[:3, :3], away)))
        assert max(off) < most, estimator
        assert np.abs(found.lengths - truth.lengths).max() < 6e-3  # by exit points as built
        assert not squared or np.mean(squared) < 7.8


@pytest.mark.parametrize("name", some(["three winches and a counterweight", "two lines on one drum"]))
def test_it_prints_by_the_filter(name: str, tmp_path: Path) -> None:
    ring = {"radius": 0.3, "layers": 1, "layer_height": "12 mm", "first_height": "1.0 m"}
    motion = {"print_speed": "10 cm/s", "travel_speed": "10 cm/s", "acceleration": "100 mm/s^2"}
    job = Job.model_validate({"name": "ring", "origin": [0.0, -1.0, 0.0], "helix": ring, "motion": motion})
    options = PrintOptions("filter", plant="quasi-static", period=0.2, seed=4)
    done = print_job(ROBOTS[name], job, tmp_path / "run", machine="merlet2023", options=options)
    assert done.finished
    assert done.record.whole.position_rms < 5e-3
