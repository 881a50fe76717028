"""Hoists with a counterweight, and pairs of lines on one drum, on virtual CANopen drives: homed, printed, jogged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import shared_winch_robots
from cablewright.foundation.signals import OrderKind, PrintState
from cablewright.live.drives import actions
from cablewright.live.serve.operated_machines import resting_pose
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import Robot
from cases import some
from live.test_planes_and_few_winches_on_drives import given, homed, rest, until
from virtual_drives import Bench, bench, true_poses

JOB = Job(
    name="small ring",
    origin=(0.0, 0.0, 0.0),
    helix=Helix(radius=0.05, layers=1, layer_height=0.001, first_height=0.7),
    motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2),
)
ROBOTS = pytest.mark.parametrize(
    "robot", some([shared_winch_robots.hoist(), shared_winch_robots.pairs()]), ids=["hoist", "pairs"]
)


def made(robot: Robot, place: tuple[float, ...] = (0.05, 0.0, 0.7), **changes: float) -> Bench:
    """A robot on virtual drives with its nozzle at a *place*."""
    origin = resting_pose(robot, np.array(place) - robot.platform.nozzle)
    return bench(robot, begin=tuple(origin), tension=10.0, **changes)


def pose_of(found: Bench) -> np.ndarray:
    """The true pose (n,)."""
    truth = found.rig.plant.truth
    return np.concatenate([truth.position, truth.rotation])[: found.robot.n]


@pytest.mark.slow  # in test_bodies_on_drives.py
@ROBOTS
def test_a_print_on_drives_is_that_of_the_plant_itself_to_the_encoders_resolution(robot: Robot) -> None:
    on = made(robot)
    there = true_poses(JOB, on.machine, on.rig.plant, on)
    wired = on.twin.with_simulation(wire=Link())  # encoders without delay, as on the bus
    plant = SimulatedMachine(robot, wired, pose_of(made(robot)), seed=0)
    here = true_poses(JOB, plant, plant, on)
    winch = on.twin.owner.winch
    resolution = shared_winch_robots.WINCH["drum_radius"] * 2.0 * np.pi / (winch.counts * winch.ratio)  # m of cable
    assert len(here) == len(there) > 20
    assert np.abs(here - there)[:, :3].max() < resolution


@ROBOTS
def test_it_is_homed_at_a_measured_place_and_sent_to_another(robot: Robot, tmp_path: Path) -> None:
    found, goal = made(robot, tension_error=0.02), (0.1, 0.05, 0.8)
    begin = pose_of(found)
    far = "the platform cannot hang at -0.55" if robot.n == 3 else "the tensions do not fit the place"
    for off, says in ((-0.3, "the tensions do not fit the place"), (-0.6, far)):
        wrong = begin + np.pad([off, 0.0, 0.0], (0, robot.n - 3))
        answer = actions.home(robot, found.twin.owner, tmp_path / "machine", wrong, lambda: found.port)
        assert says in answer.reason
    printer = homed(found, tmp_path, begin)
    assert np.linalg.norm(printer.last_pose[:3] - begin[:3]) < 1e-3
    assert given(printer, OrderKind.GO_TO, position=goal) == ""
    until(printer, PrintState.IDLE)
    rest(printer)
    assert printer.supervisor.reason == ""  # as estimated it is there to 0.1 mm, whatever the tilt that torques show
    pose = pose_of(found)
    there = printer.plan.path.printing_point(pose[:3], np.pad(pose[3:], (0, 6 - robot.n)))
    assert np.linalg.norm(there - goal) < 3e-3


@pytest.mark.slow  # as `test_homing.test_a_line_that_was_moved_by_hand_without_power_is_found`
def test_a_drum_that_was_turned_by_hand_is_named_beside_a_counterweight(tmp_path: Path) -> None:
    robot = shared_winch_robots.crane()
    found = made(robot)
    for turned in (0.0, 0.02):
        found.rig.turn_by_hand("d", turned)
        place = pose_of(found) if turned == 0.0 else None
        answer = actions.home(robot, found.twin.owner, tmp_path / "machine", place, lambda: found.port)
        assert (answer.reason == "") == (turned == 0.0), answer.reason
    assert "it is d by -20 mm or" in answer.reason


def test_one_drum_is_turned_by_hand_for_both_its_lines_and_slack_of_both_is_taken_up(tmp_path: Path) -> None:
    robot = shared_winch_robots.pairs()
    found, times = made(robot), [0]
    before = found.rig.plant.truth.lengths

    def held() -> bool:
        times[0] += 1
        return times[0] < 60

    answer = actions.jog_winch(
        robot, found.twin.owner, tmp_path / "machine", "b1", 0.05, held, lambda: False, lambda: found.port
    )
    assert answer.status == "done", answer.reason
    assert [each.line for each in answer.drives] == ["a1", "b1", "c1"]
    paid = found.rig.plant.truth.lengths - before
    assert 0.01 < paid[2] < 0.05
    assert paid[3] == pytest.approx(paid[2], abs=2e-4)
    assert np.abs(np.delete(paid, [2, 3])).max() < 2e-4
    taken = actions.tension(robot, found.twin.owner, tmp_path / "machine", lambda: found.port)
    assert taken.status == "done", taken.reason
    truth, arms = found.rig.plant.truth, shared_winch_robots.WINCH["drum_radius"]
    sums = truth.tensions.reshape(3, 2).sum(axis=1) * truth.radii[::2]
    shown = np.array([each.tension for each in taken.drives])  # of one cable, at the smallest radius
    np.testing.assert_allclose(2.0 * arms * shown, sums, rtol=0.05, atol=0.05)
