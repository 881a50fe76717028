"""Closed-loop prints of robots with fewer winches than lines: orders, counts and limits are of winches."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from tools.pages.line_prints import printed, ring

import shared_winch_robots
from cablewright.control import guard
from cablewright.control.guard import GuardSettings, GuardState
from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Snapshot, save
from cablewright.foundation.saved_state import load as restore
from cablewright.foundation.signals import Command, Drives, DriveState, Encoders, SensorFrame
from cablewright.live.estimator_settings import started_settings
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cases import some


def small(height: float) -> Job:
    """One small layer."""
    job = ring(0.08, height, 0.1)
    return job.model_copy(update={"helix": job.helix.model_copy(update={"layers": 1})})  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "robot", some([shared_winch_robots.hoist(), shared_winch_robots.pairs()]), ids=["hoist", "pairs"]
)
def test_an_ideal_machine_prints_on_its_path_with_tensions_within_limits(robot: Robot) -> None:
    found = printed(robot, small(0.5), PrintOptions("encoders", layers=1, seed=0, severity="ideal"))
    assert found.end == "finished"
    assert found.errors.max() < 2e-3
    limits = np.array([line.tension_limits for line in robot.lines])
    assert (found.tensions >= limits[:, 0]).all()
    assert (found.tensions <= limits[:, 1]).all()


def test_a_print_with_a_counterweight_continues_from_its_snapshot() -> None:
    robot = shared_winch_robots.hoist()
    twin = twin_of(robot, small(0.5), None, PrintOptions("encoders", layers=1, seed=0))
    plan = plan_print(twin)

    owner = twin.settings.owner

    def begun(saved: Mapping[str, Snapshot] | None = None, now: float = 0.0) -> tuple[SimulatedMachine, Printer]:
        machine = SimulatedMachine(robot, twin.settings, twin.path.start_pose, seed=0)
        if saved is not None:
            restore(machine, saved["machine"])
        known = Printer(plan, machine, lambda pose, _: estimator("encoders", robot, owner, pose), now=now, saved=saved)
        return machine, known

    machine, first = begun()
    for _ in range(100):
        first.step()
    saved = {"print": save(first), "estimator": save(first.learning), "machine": save(machine)}
    other, again = begun(saved, first.time)
    assert again.radii.tolist() == first.radii.tolist() == [0.04, 0.04, 0.04, 0.0]
    for _ in range(50):
        for each in (machine, other):
            each.step(Command(each.time, np.full(3, 0.2)))
    np.testing.assert_array_equal(other.truth.position, machine.truth.position)
    np.testing.assert_array_equal(other.truth.lengths, machine.truth.lengths)


def frame(counts: list[int]) -> SensorFrame:
    return SensorFrame(1.0, (Encoders(1.0, np.array(counts)),))


def test_the_guard_counts_winches_and_names_their_lines() -> None:
    settings = GuardSettings(np.full(6, 400.0), hosts=shared_winch_robots.pairs().hosts)
    assert guard.judge(settings, GuardState(), frame([0, 0, 0])) is None
    wrong = guard.judge(settings, GuardState(), frame([0] * 6))
    assert wrong is not None
    assert wrong.reason == "the encoders do not report 3 numbers, one for each winch"
    states = (DriveState.ENABLED, DriveState.FAULT, DriveState.ENABLED)
    none = np.zeros(3)
    drives = Drives(1.0, states, none, none, none, none, ("", "overheated", ""))
    fault = guard.judge(settings, GuardState(), SensorFrame(1.0, (drives,)))
    assert fault is not None
    assert fault.reason == "the drive of line 3 reports a fault: overheated"


def test_estimators_of_lidars_name_the_one_of_encoders_for_a_body() -> None:
    started_settings(shared_winch_robots.hoist(), load_twin("merlet2023").owner)
    why = "estimation by lidars: robot 'pairs' has a rigid platform; not supported. Use the estimator encoders"
    with pytest.raises(InputError, match=why):
        started_settings(shared_winch_robots.pairs(), load_twin("merlet2023").owner)
