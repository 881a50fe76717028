"""Closed-loop prints of robots with fewer winches than lines: orders, counts and limits are of winches."""

from __future__ import annotations

import numpy as np
import pytest
from tools.pages.line_prints import printed, ring

import driven
from cablewright.control import guard
from cablewright.control.guard import GuardSettings, GuardState
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Drives, DriveState, Encoders, SensorFrame
from cablewright.live.estimator_settings import started_settings
from cablewright.live.prints.plan import PrintOptions
from cablewright.machine.simulated.settings import load_twin
from cablewright.printing.job import Job
from cablewright.robot import Robot


def small(height: float) -> Job:
    """One small layer."""
    job = ring(0.08, height, 0.1)
    return job.model_copy(update={"helix": job.helix.model_copy(update={"layers": 1})})  # type: ignore[union-attr]


@pytest.mark.parametrize("robot", [driven.hoist(), driven.pairs()], ids=["hoist", "pairs"])
def test_an_ideal_machine_prints_on_its_path_with_tensions_within_limits(robot: Robot) -> None:
    found = printed(robot, small(0.5), PrintOptions("encoders", layers=1, seed=0, severity="ideal"))
    assert found.end == "finished"
    assert found.errors.max() < 2e-3
    limits = np.array([line.tension_limits for line in robot.lines])
    assert (found.tensions >= limits[:, 0]).all()
    assert (found.tensions <= limits[:, 1]).all()


def frame(counts: list[int]) -> SensorFrame:
    return SensorFrame(1.0, (Encoders(1.0, np.array(counts)),))


def test_the_guard_counts_winches_and_names_their_lines() -> None:
    settings = GuardSettings(np.full(6, 400.0), hosts=driven.pairs().hosts)
    assert guard.judge(settings, GuardState(), frame([0, 0, 0])) is None
    wrong = guard.judge(settings, GuardState(), frame([0] * 6))
    assert wrong is not None
    assert wrong.reason == "the encoders do not tell 3 numbers, one for each winch"
    states = (DriveState.ENABLED, DriveState.FAULT, DriveState.ENABLED)
    none = np.zeros(3)
    drives = Drives(1.0, states, none, none, none, none, ("", "overheated", ""))
    fault = guard.judge(settings, GuardState(), SensorFrame(1.0, (drives,)))
    assert fault is not None
    assert fault.reason == "the drive of line 3 reports a fault: overheated"


def test_estimators_of_lidars_name_the_one_of_encoders() -> None:
    why = "estimation by lidars: line 'up' has a counterweight; not supported. Use the estimator encoders"
    with pytest.raises(InputError, match=why):
        started_settings(driven.hoist(), load_twin("merlet2023").owner)
