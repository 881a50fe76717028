"""Compile the kernels that most tests call, each in one process: `make test` runs this first.

Both workers of the tests would compile them at the same time. Kernels are compiled apart for plain robots and for those
that are general (`Packed.general`): what `cablewright warm` compiles, and what simulated machines call, is compiled for
one robot of each kind.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from cablewright.apps import compilation
from cablewright.foundation.signals import Command
from cablewright.machine.files import machine_names
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import PLANTS, SimulatedMachine
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse

PLACES = {"merlet2023": (0.3, -1.0, 1.2), "maslow4": (0.1, 0.8 * 0.258819 / 0.965926, 0.8)}  # the latter is general


def unsolved(name: str) -> Equilibrium:
    """Arrays of a robot as kernels take them; all entries are NaN, so that kernels end immediately."""
    model = Model(load(name))
    numbers = np.full(1, np.nan), np.zeros(1, np.int64)
    pose, lengths, states = np.zeros((1, model.n)), np.ones((1, model.m)), np.full((1, model.m, 6), np.nan)
    return Equilibrium(model, model.rows(), pose, lengths, states, numbers[1], numbers[0], numbers[1])


def compiled(name: str, task: str) -> None:
    """Compile what a task of `cablewright warm` calls, for a robot."""
    made = unsolved(name)
    compilation._unsolved = lambda: made
    compilation.TASKS[task][0]()


def stepped(name: str, plant: str) -> None:
    """Compile what a simulated machine calls."""
    robot = load(name)
    twin = load_twin(name) if name in machine_names() else built_machine(robot)[0]
    machine = SimulatedMachine(robot, twin, PLACES[name], seed=1, plant=plant)
    machine.step(Command(0.0, np.zeros(robot.m)))


def hung() -> None:
    """Compile what a body with fewer lines than degrees of freedom needs."""
    solve_inverse(Model(load("grab-four-lines")), [1.1, 0.0, -0.3, np.nan, np.nan, 0.0])


def main() -> None:
    """Do the longest tasks first."""
    tasks = [(stepped, name, plant) for plant in PLANTS for name in PLACES]
    names = sorted(compilation.TASKS, key=lambda each: -compilation.TASKS[each][1])
    tasks += [(hung,), *((compiled, name, task) for task in names for name in PLACES)]
    with ProcessPoolExecutor(min(4, os.cpu_count() or 1), get_context("spawn")) as pool:
        for done in [pool.submit(*each) for each in tasks]:
            done.result()


if __name__ == "__main__":
    sys.exit(main())
