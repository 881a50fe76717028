"""A rigid platform on virtual CANopen drives: homed, printed and moved by hand, beside the plant itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.control.guide import TimedPath
from cablewright.foundation.signals import PrintState
from cablewright.live.drives import actions
from cablewright.live.drives.printing import print_on_drives
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.attendant import Attendant
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import angle_between
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from typing_person import WORDS, Typist
from virtual_drives import RING_BEGIN, Bench, bench

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


def ring(machine: Machine, plant: SimulatedMachine, found: Bench) -> np.ndarray:
    """True poses (k, 6) of the steps that print."""
    robot, settings, poses = found.robot, found.twin.owner, []
    path = TimedPath.of(JOB, None, 0.0, robot.platform.nozzle)
    plan = planned(robot, settings, path, settings.period, "encoders", "model", None)
    printer = Printer(plan, machine, lambda pose, _radii: estimator("encoders", robot, settings, pose))

    class Kept:
        def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
            if step.progress.state is PrintState.PRINTING:
                poses.append(np.concatenate([plant.truth.position, plant.truth.rotation]))

    loop.run(printer, Attendant(lambda: None), Kept())
    assert printer.finished, printer.supervisor.reason
    return np.array(poses)


def test_a_print_on_drives_is_that_of_the_plant_itself_to_the_encoders_resolution() -> None:
    on = made(begin=RING_BEGIN[ROBOT])
    there = ring(on.machine, on.rig.plant, on)
    wired = on.twin.with_simulation(wire=Link())  # encoders at once, as on the bus
    plant = SimulatedMachine(on.robot, wired, RING_BEGIN[ROBOT], seed=0)
    here = ring(plant, plant, on)
    winch, radius = on.twin.owner.winch, on.robot.lines[0].winch.drum_radius
    assert radius is not None
    resolution = radius * 2.0 * np.pi / (winch.counts * winch.ratio)  # m of cable, 7.7 um
    assert len(here) == len(there)
    assert np.abs(here - there)[:, :3].max() < resolution


def test_a_homed_body_prints_by_typed_orders_and_moves_by_hand_at_the_rotation_it_had(tmp_path: Path) -> None:
    found = homed(tmp_path)
    typist = Typist({state: list(words) for state, words in WORDS.items()})
    answer = print_on_drives(
        found.robot, JOB, tmp_path / "run", found.twin.owner, tmp_path / "machine", typist,
        inputs={}, say=typist.said.append, port=lambda: found.port,
    )  # fmt: skip
    assert answer.finished, typist.said
    assert answer.estimator == "filter"
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


@pytest.mark.parametrize("wrong", [(0.5, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.35, 0.0, 0.0)])
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
