"""Simulated load cells behave as their file states, and the guard of a print stops by them."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from cablewright.foundation.signals import Command, PrintState, Tensions
from cablewright.live.estimators import Estimator, estimator
from cablewright.live.prints import loop
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.sensors.tensions import TensionFlaws
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from twins import TWIN, machine

RING = Job(
    name="ring",
    origin=(0.3, -0.5, 0.0),
    helix=Helix(radius=0.2, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.03, travel_speed=0.03, acceleration=0.02),
)
CELLS = TensionSensor(rate=10.0, deviation=0.0, most=1000.0)


def with_cells(cells: TensionSensor = CELLS, faults: tuple[FaultPlan, ...] = (), **flaws: float) -> TwinSettings:
    owned = TWIN.with_owner(load_cells=cells)
    return owned.with_simulation(load_cells=TensionFlaws(**flaws), faults=faults)


def shown(settings: TwinSettings, seconds: float = 10.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """What the cells show and what is true, both (k, m), of a machine at rest."""
    rig = machine(settings, seed=seed, plant="dynamic", start=[0.3, -0.5, 1.2])
    told, true = [], []
    for _ in range(round(seconds / rig.period)):
        for reading in rig.step(Command(rig.time, np.zeros(4))).of(Tensions):
            assert reading.source == "load_cells"
            told.append(reading.tensions)
            true.append(rig.truth.tensions)
    return np.array(told), np.array(true)


def test_without_flaws_they_report_the_truth() -> None:
    told, true = shown(with_cells())
    assert len(told) in (99, 100)
    late = 1 if np.array_equal(told[1:], true[:-1]) else 0  # a link may take a step
    np.testing.assert_allclose(told[late:], true[: len(true) - late], rtol=1e-3)


def test_noise_zeros_cross_talk_and_range_are_those_of_the_file() -> None:
    told, true = shown(with_cells(cell(deviation=2.0)), 60.0)
    assert np.std(told - true, axis=0) == pytest.approx(np.full(4, 2.0), rel=0.15)
    zeros = [np.mean(np.subtract(*shown(with_cells(cell(bias=5.0)), 1.0, seed)), axis=0) for seed in range(12)]
    assert np.std(zeros) == pytest.approx(5.0, rel=0.3)
    told, true = shown(with_cells(cross_talk=0.1), 1.0)
    extra = 0.05 * (np.roll(true, 1, axis=1) + np.roll(true, -1, axis=1))
    np.testing.assert_allclose(told - true, extra, rtol=0.02)
    told, true = shown(with_cells(cell(most=20.0)), 1.0)
    assert told.max() == 20.0 < true.max()
    walked, _ = shown(with_cells(drift=60.0), 30.0)  # 1 N after a second, as the root of the time
    assert 1.0 < np.abs(walked[-1] - walked[0]).max() < 30.0


def cell(**changes: float) -> TensionSensor:
    return CELLS.model_copy(update=changes)


def test_a_dead_cell_is_one_line_and_a_stuck_one_repeats_itself() -> None:
    name = load("merlet2023").lines[1].name
    dead = FaultPlan(source="load_cells", line=name, begin=2.0)
    told, _ = shown(with_cells(cell(deviation=1.0), (dead,)), 5.0)
    assert np.isnan(told[-1]).tolist() == [False, True, False, False]
    assert np.isfinite(told[:15]).all()
    stuck = FaultPlan(source="load_cells", kind="stuck", begin=2.0)
    told, _ = shown(with_cells(cell(deviation=1.0), (stuck,)), 5.0)
    assert len(np.unique(told[25:], axis=0)) == 1
    with pytest.raises(ValidationError, match="all of them are silent together"):
        FaultPlan.model_validate({"source": "encoders", "line": name})


def test_they_are_taken_up_again_to_the_bit() -> None:
    settings = with_cells(cell(deviation=1.0, bias=3.0), drift=10.0)
    rig = machine(settings, seed=3, plant="dynamic", start=[0.3, -0.5, 1.2])
    for _ in range(100):
        rig.step(Command(rig.time, np.zeros(4)))
    again = SimulatedMachine.resumed(load("merlet2023"), settings, rig.snapshot(), seed=3, plant="dynamic")
    for _ in range(100):
        still = Command(rig.time, np.zeros(4))
        ours, theirs = rig.step(still).of(Tensions), again.step(still).of(Tensions)
        for one, other in zip(ours, theirs, strict=True):
            np.testing.assert_array_equal(one.tensions, other.tensions)


class Last:
    """A recorder of the last step alone."""

    step: Step

    def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
        self.step = step


def printed(twin: MachineTwin) -> tuple[Step, SimulatedMachine]:
    begin = twin.path.track.at(0.0).position
    rig = SimulatedMachine(twin.robot, twin.settings, begin, seed=0, plant=twin.choices.plant)

    def make(place: np.ndarray, radii: np.ndarray) -> Estimator:
        return estimator(twin.estimator, twin.robot, rig.settings, place, (), radii)

    kept = Last()
    loop.run(Printer(plan_print(twin), rig, make), Attendant(lambda: None), kept)
    return kept.step, rig


def made(settings: TwinSettings) -> MachineTwin:
    return twin_of(load("merlet2023"), RING, settings, PrintOptions(plant="quasi-static", estimator="encoders"))


def test_a_print_on_a_machine_with_load_cells_is_the_same_and_stops_by_them() -> None:
    """A cell that shows too much, and cells that fall silent, stop it; estimates by lengths see neither."""
    twin = made(with_cells(cell(rate=1.0)))
    finished, rig = printed(twin)
    bare, other = printed(made(TWIN))
    assert finished.progress.reason == bare.progress.reason == "finished"
    np.testing.assert_array_equal(rig.truth.position, other.truth.position)
    pulled, _ = printed(made(with_cells(cell(rate=1.0, bias=1e4, most=1e5))))
    assert pulled.progress.state is PrintState.FAULT
    assert "pulls" in pulled.progress.reason
    silent, _ = printed(made(with_cells(cell(rate=1.0), (FaultPlan(source="load_cells", begin=20.0),))))
    assert silent.progress.reason == "no reading of the load cells for over 2.5 s"


def test_the_plan_knows_when_cells_are_silent() -> None:
    plan = plan_print(made(with_cells(cell(rate=1.0))))
    assert plan.guard.timeouts == {"encoders": 2.5, "load_cells": 2.5}
    assert plan_print(made(TWIN)).guard.timeouts == {"encoders": 2.5}
