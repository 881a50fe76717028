"""Compile the kernels that tests call, each once: `make test` runs this first.

Both workers of the tests would compile them at the same time. Kernels are compiled apart for plain robots and for those
that are general (`Packed.general`), and a process lowers once what several of them call: all of one kind are therefore
compiled in one process. Each kind is put to every use of the table of support, simulated, and printed.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import Final

import numpy as np
from tools.pages.line_prints import on_the_board, ring

import cablewright as cw
import out_of_plane
from cablewright.apps import compilation
from cablewright.foundation.errors import CablewrightError
from cablewright.foundation.signals import Command
from cablewright.kernels.certificates import krawczyk
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.kernels.plant import dynamics
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.files import machine_names
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import PLANTS, SimulatedMachine
from cablewright.models.support_table import Capability
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers import exhaustive
from models import support_examples as examples
from models.test_support_laws import goes_as_wanted

FOLDER = tempfile.TemporaryDirectory()
Work = list[Callable[[], object]]
PERIODS: Final = {"quasi-static": 0.5, "dynamic": 0.01}  # s
STEPS: Final = 100
SKIPPED: Final = (Capability.REPRAPFIRMWARE, Capability.TENSION_CHOICE, Capability.WORKSPACE)  # long, and nothing new
LONG_IF_SHARED: Final = (Capability.STRAIGHT_WORKSPACE,)  # half a minute


def uses(feature: str, body: bool) -> Work:
    """Every capability of the example of a feature, a step of its control, and what `cablewright warm` compiles."""
    robot = examples.example(feature, body)
    assert robot is not None

    def warmed(task: str) -> None:
        compilation._unsolved = lambda: examples.held(robot)[None]
        compilation.TASKS[task][0]()

    skipped = (*SKIPPED, *LONG_IF_SHARED) if feature == "shared-winch" else SKIPPED
    found = [lambda each=probe: each(robot) for key, probe in examples.PROBES.items() if key not in skipped]
    found.append(lambda: goes_as_wanted(robot))
    return found + [lambda each=task: warmed(each) for task in compilation.TASKS]


def machines(name: str, place: tuple[float, ...]) -> Work:
    """A step of each simulated machine of a robot, and a small print."""

    def stepped(plant: str) -> None:
        robot = cw.load(name)
        twin = load_twin(name) if name in machine_names() else built_machine(robot)[0]
        machine = SimulatedMachine(robot, twin, place, seed=1, plant=plant)
        machine.step(Command(0.0, np.zeros(robot.m)))

    return [lambda each=plant: stepped(each) for plant in PLANTS]


def print_begun(robot: Robot, job: Job, estimator: str, plant: str, machine: object = None) -> Callable[[], object]:
    """The first steps of a print."""

    def stepped() -> None:
        options = PrintOptions(estimator, plant=plant, period=PERIODS[plant], seed=0, severity="rough")
        made = twin_of(robot, job, machine, options)
        begun, printer = begin_print(made, plan_print(made))
        attendant = Attendant(lambda: None)
        for _ in range(STEPS):
            printer.step(attendant.orders(printer, begun.time))

    return stepped


def print_of(feature: str) -> Callable[[], object]:
    """As `print_begun`, of the example of a feature, a point."""
    robot = examples.example(feature, False)
    assert robot is not None
    return lambda: print_begun(robot, examples.job_of(robot), "encoders", "quasi-static", examples.twin(robot))()


def guided_pairs() -> None:
    """Lines that share drums, one over guides."""
    robot = examples.example("shared-winch", True)
    assert robot is not None
    guided = out_of_plane.guided(robot.lines[0], "guides", 0, np.random.default_rng(3))
    pairs = robot.model_copy(update={"lines": (guided, *robot.lines[1:])})
    cw.inverse(pairs, examples.pose_at(robot))


def alone(feature: str) -> Callable[[], object]:
    """Kernels that tests call by themselves, with the arrays of the example of a feature, a point."""

    def called() -> None:
        robot = examples.example(feature, False)
        assert robot is not None
        row = examples.held(robot)
        own = row.packed._replace(lines=row.packed.lines[0], platform=row.packed.platform[0])
        krawczyk.certify(own, row.lengths, row.pose, row.states, 1.0, unfold(own, certificate_pool(own)))
        body, motion = np.zeros(dynamics.BODY), np.zeros(dynamics.MOTION)
        body[dynamics.MASS], motion[:3] = robot.platform.mass, row.pose
        body[dynamics.INERTIA : dynamics.INERTIA + 9] = np.eye(3).ravel()
        work, swing = dynamics.moving_workspace(own)
        dynamics.midpoint_step(own, body, motion, row.lengths, row.lengths, 1e-3, row.states.copy(), work, swing)

    return called


def all_equilibria() -> None:
    """The exhaustive search."""
    model = cw.Model(cw.load("merlet2023"))
    found = cw.equilibria(model, cw.inverse(model.robot, [0.5, -1.0, 1.2]).checked().lengths)
    around = np.stack([found.solutions.pose[0] - 0.01, found.solutions.pose[0] + 0.01], axis=1).ravel()
    exhaustive.exhaust(found, exhaustive.begin(model, around))


def followed() -> None:
    """An equilibrium that is followed."""
    found = cw.inverse(cw.load("merlet2023"), [0.5, -1.0, 1.2]).checked()
    cw.Tracker(found.model, found.lengths, begin=found).restart(found.lengths)


def calibrated(robot: Robot | None) -> Callable[[], object]:
    """A calibration by simulated lengths."""
    assert robot is not None
    return lambda: cw.calibrate(robot, cw.simulate_calibration(robot, 14, 1e-4, seed=1).measured)


def plain() -> Work:
    """What plain robots need."""
    found = list(machines("merlet2023", (0.3, -1.0, 1.2)))
    for each in (("eyelet", False), ("body", True), ("shared-winch", True)):
        found += uses(*each)
    found.append(lambda: cw.inverse(cw.load("grab-four-lines"), [1.1, 0.1, -0.2, np.nan, np.nan, 0.0]))
    found += [
        print_begun(cw.load("merlet2023"), ring(0.1, 1.0, 0.1, 0.3), each, "quasi-static")
        for each in ("filter", "paper")
    ]
    found.append(print_begun(cw.load("cogiro"), ring(0.1, 0.6, 0.1, 0.4), "encoders", "dynamic"))
    return [*found, calibrated(cw.load("wang2021")), alone("eyelet"), all_equilibria, followed]


def general() -> Work:
    """What robots in a plane, or with lines that leave theirs, need."""
    found = list(machines("maslow4", (0.1, 0.8 * 0.258819 / 0.965926, 0.8)))
    for each in (("guides", False), ("tilted-swivel", False), ("plane", True), ("few-lines-in-plane", True)):
        found += uses(*each)
    board = print_begun(cw.load("maslow4"), on_the_board(Path(FOLDER.name)), "encoders", "dynamic")
    found += uses("counterweight", False)
    pulley = calibrated(examples.example("pulley", False))
    return [*found, board, print_of("tilted-swivel"), guided_pairs, alone("tilted-swivel"), pulley]


def done(kind: str) -> None:
    """Do the work of a kind of robots."""
    for work in {"plain": plain, "general": general}[kind]():
        with suppress(CablewrightError):
            work()


def main() -> None:
    """Do the work of both kinds, at the same time where there are two processors."""
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1), get_context("spawn")) as pool:
        for each in [pool.submit(done, kind) for kind in ("general", "plain")]:
            each.result()


if __name__ == "__main__":
    sys.exit(main())
