"""A printer for houses prints a job of strands: its extruder is set by the job, and what it feeds lies on the path."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.signals import PrintState
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import load_job
from cablewright.robot import load

JOB = load_job(Path(__file__).parents[3] / "examples" / "house.toml")


@pytest.fixture(scope="module")
def twin() -> MachineTwin:
    return twin_of(load("house-printer"), JOB, None, PrintOptions(layers=1))


def test_the_extruder_is_set_by_the_job(twin: MachineTwin) -> None:
    settings = twin.settings.owner
    assert settings.extrusion is not None
    assert settings.extrusion.bead == JOB.bead
    assert settings.drum.flow == pytest.approx(settings.extrusion.density * JOB.bead.section * JOB.motion.print_speed)
    assert twin.path.track.positions[:, 2].min() == pytest.approx(settings.drum.valve)
    plan = plan_print(twin)
    assert plan.powder == np.inf
    assert plan.height is None


def test_cells_of_the_floor_are_finer_than_the_bead() -> None:
    def cell(width: float) -> float:
        job = JOB.model_copy(update={"bead": JOB.bead.model_copy(update={"width": width})})
        return twin_of(load("house-printer"), job, None, PrintOptions(layers=1)).settings.simulation.room.cell

    assert cell(0.06) == pytest.approx(0.02)
    assert cell(0.03) == pytest.approx(0.01)
    assert cell(0.002) == pytest.approx(15.0 / 2000.0)  # as fine as memory allows
    assert cell(0.9) == pytest.approx(0.02)


def test_the_first_metres_lie_where_they_should(twin: MachineTwin) -> None:
    begin, choices = twin.path.track.at(0.0).position, twin.choices
    machine = SimulatedMachine(twin.robot, twin.settings, begin, seed=choices.seed, plant=choices.plant)
    printer = Printer(
        plan_print(twin),
        machine,
        lambda place, radii: estimator(twin.estimator, twin.robot, machine.settings, place, (), radii),
        now=0.0,
    )
    attendant, fed = Attendant(lambda: None), 0.0
    for _ in range(2400):
        step = printer.step(attendant.orders(printer, machine.time))
        fed += step.command.valve * twin.settings.owner.drum.flow * machine.period
    ground = machine.rig.ground
    assert step.progress.state is PrintState.PRINTING
    assert step.progress.distance > 3.4
    assert ground.mass + machine.rig.falling_mass == pytest.approx(fed, rel=1e-9)
    cells = np.argwhere(ground.heights > 0.5 * JOB.bead.height)
    lies = np.array(ground.field.low) + ground.field.cell * (cells + 0.5)
    way = twin.path.track.positions[:, :2]
    fine = np.concatenate([a + np.linspace(0.0, 1.0, 20)[:, None] * (b - a) for a, b in itertools.pairwise(way)])
    away = np.array([np.hypot(*(fine - place).T).min() for place in lies])
    assert len(lies) > 50
    assert away.max() < 0.5 * JOB.bead.width + 0.03
    laid = ground.heights[ground.heights > 0.0]
    assert np.median(laid) == pytest.approx(JOB.bead.section / JOB.bead.width, rel=0.2)
