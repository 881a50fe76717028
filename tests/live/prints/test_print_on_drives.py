"""The print loop on virtual CANopen drives, in virtual time, beside the same print on the plant itself."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.signals import PrintState
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from virtual_drives import RING, RING_BEGIN, bench, virtual_twin


@dataclass
class Kept:
    """Steps that printed, and the platform's true place at each."""

    plant: SimulatedMachine
    steps: list[Step] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=list)

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        if step.progress.state is PrintState.PRINTING:
            self.steps.append(step)
            self.places.append(self.plant.truth.position)


def ring(machine: Machine, plant: SimulatedMachine) -> Kept:
    robot, settings = load("merlet2023"), virtual_twin().owner
    path = Helix(radius=0.2, layers=1, layer_height=0.001, first_height=1.0)
    small = RING.model_copy(update={"helix": path, "origin": (0.5, -0.5, 0.0)})  # it begins where the large one does
    plan = planned(robot, settings, TimedPath.of(small, None, 0.0), settings.period, "encoders", "model", None)
    printer = Printer(plan, machine, lambda place, radii: estimator("encoders", robot, settings, place))
    kept = Kept(plant)
    loop.run(printer, Attendant(lambda: None), kept)
    assert printer.finished, printer.supervisor.reason
    return kept


@pytest.mark.slow  # in live/test_bodies_on_drives.py
def test_a_ring_on_drives_is_that_of_the_plant_itself() -> None:
    on = bench()
    there = ring(on.machine, on.rig.plant)
    wired = on.twin.with_simulation(wire=Link())  # encoders without delay, as on the bus
    plant = SimulatedMachine(on.robot, wired, RING_BEGIN["merlet2023"], seed=0)
    here = ring(plant, plant)
    at = np.linspace(0.1, 1.2, 200)  # m along the path
    apart = np.abs(places(here, at) - places(there, at)).max()
    assert apart < 2e-4


def places(kept: Kept, at: np.ndarray) -> np.ndarray:
    """True places at path lengths."""
    gone = np.array([step.progress.distance for step in kept.steps])
    return np.column_stack([np.interp(at, gone, axis) for axis in np.array(kept.places).T])
