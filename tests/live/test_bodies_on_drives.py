"""A rigid platform on virtual CANopen and EtherCAT drives: homed, printed, moved by hand, beside the plant itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.drives import actions
from cablewright.live.drives.printing import print_on_drives
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.live.rest_pose import rest_pose
from cablewright.live.serve.operated_machines import DriveStation
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.ethercat.ethercat_drives import EthercatDrives
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import angle_between
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from ring_of_drives import missing, ring_of_drives, twin
from terminal_user import WORDS, Typist
from virtual_drives import RING_BEGIN, Bench, bench, true_poses

ROBOT = "ipanema"
JOB = Job(
    name="small ring",
    origin=(0.06, 0.05, 0.0),
    helix=Helix(radius=0.04, layers=1, layer_height=0.001, first_height=0.8),
    motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2),
)


def made(**changes: object) -> Bench:
    return bench(ROBOT, **({"tension": 60.0} | changes))  # type: ignore[arg-type]


def pose_of(found: Bench) -> np.ndarray:
    """The true pose (6,)."""
    truth = found.rig.plant.truth
    return np.concatenate([truth.position, truth.rotation])


def homed(folder: Path, error: tuple[float, ...] = (0.0,) * 6) -> Bench:
    found = made()
    answer = actions.home(found.robot, found.twin.owner, folder / "machine", pose_of(found) + error, lambda: found.port)
    assert answer.status == "done", answer.reason
    return found


def stepped(printer: Printer, steps: int, kind: OrderKind | None = None, **arguments: tuple[float, ...]) -> Step:
    """Give an order, and go on for some steps."""
    orders = () if kind is None else (Order(kind, "anna", printer.time, arguments),)
    found = printer.step(orders)
    assert all(order.refusal == "" for order in found.orders)
    for _ in range(steps):
        found = printer.step()
    return found


@pytest.mark.parametrize("name", [ROBOT, pytest.param("cogiro", marks=pytest.mark.slow)])
def test_a_print_on_drives_is_that_of_the_plant_itself_to_the_encoders_resolution(name: str) -> None:
    on = bench(name, begin=RING_BEGIN[name], tension=60.0)
    there = true_poses(JOB, on.machine, on.rig.plant, on)
    wired = on.twin.with_simulation(wire=Link())  # encoders without delay, as on the bus
    plant = SimulatedMachine(on.robot, wired, RING_BEGIN[name], seed=0)
    here = true_poses(JOB, plant, plant, on)
    winch, radius = on.twin.owner.winch, on.robot.lines[0].winch.drum_radius
    assert radius is not None
    resolution = radius * 2.0 * np.pi / (winch.counts * winch.ratio)  # m of cable, 7.7 um
    assert len(here) == len(there)
    assert np.abs(here - there)[:, :3].max() < resolution


@pytest.mark.skipif(bool(missing()), reason=missing())
def test_a_print_on_an_ethercat_ring_of_eight_goes_where_it_goes_on_the_plant_itself() -> None:
    settings = twin(ROBOT)
    robot, begin = load(ROBOT), RING_BEGIN[ROBOT]
    path = TimedPath.of(JOB, None, 0.0, robot.platform.nozzle)
    plan = planned(robot, settings.owner, path, settings.owner.period, "encoders", "model", None)

    def poses(machine: Machine, pose: Callable[[], np.ndarray], each: int) -> np.ndarray:
        printer = Printer(plan, machine, lambda there, _radii: estimator("encoders", robot, settings.owner, there))
        found = []

        class Kept:
            count = 0

            def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
                self.count += 1
                if step.progress.state is PrintState.PRINTING and self.count % each == 0:
                    found.append(pose())

        loop.run(printer, Attendant(lambda: None), Kept())
        assert printer.finished, printer.supervisor.reason
        return np.array(found)

    plant = SimulatedMachine(robot, settings.with_simulation(wire=Link()), begin, seed=0)
    here = poses(plant, lambda: np.concatenate([plant.truth.position, plant.truth.rotation]), 1)
    with ring_of_drives(ROBOT) as drives:

        def shown() -> np.ndarray:
            told = drives.do("tell")
            return np.array([*told["position"], *told["rotation"]])

        machine = DriveMachine(EthercatDrives(robot, settings.owner), settings.owner)
        there = poses(machine, shown, 10)
        assert all(drives.do("tell")["brakes"])
    apart = np.array([np.abs(here - each).max(axis=1).min() for each in there])  # from the path, at any time
    assert len(there) > 10
    assert apart.max() < 2e-3  # m and rad: 20 ms of a computer that is shared, at 0.1 m/s


def test_a_homed_body_prints_by_typed_orders_and_moves_by_hand_at_the_rotation_it_had(tmp_path: Path) -> None:
    found = homed(tmp_path)
    typist = Typist({state: list(words) for state, words in WORDS.items()})
    answer = print_on_drives(
        found.robot, JOB, tmp_path / "run", found.twin.owner, tmp_path / "machine", typist,
        inputs={}, say=typist.said.append, port=lambda: found.port,
    )  # fmt: skip
    assert answer.finished, typist.said
    assert answer.estimator == "filter"
    told = answer.to_dict()
    assert abs(told["estimated_max_path_error"]) < 2e-3  # of the nozzle
    assert told["tension_error_rms"] < 6.0  # N, by the drives' torques, of 50 N to 1 kN
    wanted = np.array([0.1, 0.05, 0.9])  # of the origin, with the nozzle where the ring ends
    assert np.linalg.norm(pose_of(found)[:3] - wanted) < 2e-3
    assert np.abs(pose_of(found)[3:]).max() < 3e-3
    before, times = pose_of(found), [0]

    def held() -> bool:
        times[0] += 1
        return times[0] < 100

    jogged = actions.jog_platform(
        found.robot, found.twin.owner, tmp_path / "machine", (0.05, 0.0, 0.0), held, lambda: times[0] > 250,
        lambda: found.port,
    )  # fmt: skip
    assert jogged.status == "done", jogged.reason
    moved = pose_of(found) - before
    assert moved[0] > 0.02
    assert np.abs(moved[1:3]).max() < 2e-3
    assert np.abs(moved[3:]).max() < 3e-3


@pytest.mark.slow
def test_a_line_that_was_moved_by_hand_is_named_by_the_other_seven(tmp_path: Path) -> None:
    found = homed(tmp_path)
    found.rig.turn_by_hand("3", 0.02)
    answer = actions.home(found.robot, found.twin.owner, tmp_path / "machine", None, lambda: found.port)
    assert "the lengths do not fit together" in answer.reason
    assert "it is line 3 by -20 mm" in answer.reason


@pytest.mark.parametrize(
    "wrong", [pytest.param((0.5, 0.0, 0.0, 0.0, 0.0, 0.0), marks=pytest.mark.slow), (0.0, 0.0, 0.0, 0.35, 0.0, 0.0)]
)
def test_a_pose_that_was_typed_wrong_is_not_believed(wrong: tuple[float, ...], tmp_path: Path) -> None:
    found = made()
    answer = actions.home(
        found.robot, found.twin.owner, tmp_path / "machine", pose_of(found) + wrong, lambda: found.port
    )
    assert "the tensions do not fit the place" in answer.reason
    assert "and turn by" in answer.reason
    assert not (tmp_path / "machine.lengths.json").exists()


def test_a_homing_by_saved_lengths_finds_the_pose(tmp_path: Path) -> None:
    found = homed(tmp_path)
    answer = actions.home(found.robot, found.twin.owner, tmp_path / "machine", None, lambda: found.port)
    assert answer.status == "done", answer.reason
    assert answer.position is not None
    assert answer.rotation is not None
    assert np.linalg.norm(np.array(answer.position) - pose_of(found)[:3]) < 1e-3
    assert angle_between(np.array(answer.rotation), pose_of(found)[3:]) < 2e-3
    assert answer.misfit < 1e-3


@pytest.mark.slow  # as the test above, with another robot
def test_a_retracting_platform_is_homed_at_its_own_length(tmp_path: Path) -> None:
    robot = load("jung2020")
    pose = rest_pose(robot).equilibrium.pose
    found = bench(robot, begin=tuple(pose), tension=60.0)
    for place in (pose, None):
        answer = actions.home(robot, found.twin.owner, tmp_path / "machine", place, lambda: found.port)
        assert answer.status == "done", answer.reason
        assert "not measured: the length of the platform, 2 m by the robot file" in answer.notes
    assert np.linalg.norm(np.array(answer.position) - pose_of(found)[:3]) < 1e-3


@pytest.mark.usefixtures("unpaced")
def test_a_sitting_on_drives_homes_at_a_pose_and_moves_the_nozzle_to_the_goal(tmp_path: Path) -> None:
    found = made()
    begin = pose_of(found)
    station = DriveStation(found.robot, found.twin.owner, tmp_path / "machine", lambda: found.port, begin)
    sitting = station.sitting(None)
    assert sitting.procedures == ("tensioning", "homing")
    printer, goal = sitting.printer, (0.13, 0.08, 0.82)
    printer.machine.open()
    try:
        stepped(printer, 30)
        stepped(printer, 80, OrderKind.RESET)
        off = stepped(printer, 80, OrderKind.ENABLE)
        assert not off.estimate.valid  # nothing is known before homing
        sitting.home_at(begin)
        assert stepped(printer, 260, OrderKind.HOME).estimate.valid
        there = stepped(printer, 300, OrderKind.GO_TO, position=goal)
        assert there.progress.state is PrintState.IDLE
    finally:
        printer.machine.stop()
        printer.machine.close()
    nozzle = printer.plan.path.printing_point(pose_of(found)[:3], pose_of(found)[3:])
    assert np.linalg.norm(nozzle - goal) < 4e-3
    assert np.abs(pose_of(found)[3:] - begin[3:]).max() < 3e-3
