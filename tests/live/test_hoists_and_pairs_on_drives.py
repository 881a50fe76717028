"""Hoists with a counterweight, and pairs of lines on one drum, on virtual CANopen drives: homed, printed, jogged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import driven
from cablewright.control.guide import TimedPath
from cablewright.foundation.signals import PrintState
from cablewright.live.drives import actions
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.attendant import Attendant
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.serve.station import resting_pose
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import Robot
from virtual_drives import Bench, bench

JOB = Job(
    name="small ring",
    origin=(0.0, 0.0, 0.0),
    helix=Helix(radius=0.05, layers=1, layer_height=0.001, first_height=0.7),
    motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2),
)
ROBOTS = pytest.mark.parametrize("robot", [driven.hoist(), driven.pairs()], ids=["hoist", "pairs"])


def made(robot: Robot, place: tuple[float, ...] = (0.05, 0.0, 0.7)) -> Bench:
    """A robot on virtual drives with its nozzle at a *place*."""
    origin = resting_pose(robot, np.array(place) - robot.platform.nozzle)
    return bench(robot, begin=tuple(origin), tension=10.0)


def pose_of(found: Bench) -> np.ndarray:
    """The true pose (n,)."""
    truth = found.rig.plant.truth
    return np.concatenate([truth.position, truth.rotation])[: found.robot.n]


def ring(machine: Machine, plant: SimulatedMachine, found: Bench) -> np.ndarray:
    """True poses (k, 6) of the steps that print."""
    robot, settings, poses = found.robot, found.twin.owner, []
    path = TimedPath.of(JOB, None, 0.0, robot.platform.own_nozzle)
    plan = planned(robot, settings, path, settings.period, "encoders", "model", None)
    printer = Printer(plan, machine, lambda pose, _radii: estimator("encoders", robot, settings, pose))

    class Kept:
        def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
            if step.progress.state is PrintState.PRINTING:
                poses.append(np.concatenate([plant.truth.position, plant.truth.rotation]))

    loop.run(printer, Attendant(lambda: None), Kept())
    assert printer.finished, printer.supervisor.reason
    return np.array(poses)


@ROBOTS
def test_a_print_on_drives_is_that_of_the_plant_itself_to_the_encoders_resolution(robot: Robot) -> None:
    on = made(robot)
    there = ring(on.machine, on.rig.plant, on)
    wired = on.twin.with_simulation(wire=Link())  # encoders at once, as on the bus
    plant = SimulatedMachine(robot, wired, pose_of(made(robot)), seed=0)
    here = ring(plant, plant, on)
    winch = on.twin.owner.winch
    resolution = driven.WINCH["drum_radius"] * 2.0 * np.pi / (winch.counts * winch.ratio)  # m of cable
    assert len(here) == len(there) > 20
    print(np.abs(here - there)[:, :3].max(), resolution)
    assert np.abs(here - there)[:, :3].max() < resolution
