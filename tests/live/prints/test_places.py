"""What helps encoders alone: places that are measured between layers, and cables whose creep is described."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

from cablewright.estimation import encoders_only
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.saved_state import load as restore
from cablewright.foundation.saved_state import save
from cablewright.foundation.signals import Command, Encoders, PrintState, SensorFrame, Tensions
from cablewright.live.estimators import DeadReckoning, estimator, reckoning_of
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.loop import run as run_loop
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load
from cablewright.robot.cable import Creep
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import inverse

EXAMPLES = Path(__file__).parents[3] / "examples"
ROBOT, OWNER = load("house-printer"), load_twin("house-printer").owner
PLACE = np.array([1.0, -0.5, 1.5])


def frame(time: float, counts: np.ndarray) -> SensorFrame:
    return SensorFrame(time, (Encoders(time, counts),))


def reckoned() -> tuple[encoders_only.ReckoningSettings, encoders_only.ReckoningState, np.ndarray]:
    """Settings, and a state that has counted the way to another place; with the counts there."""
    settings = reckoning_of(ROBOT, OWNER)
    state, counts = encoders_only.start(settings, PLACE), np.zeros(4, dtype=np.int64)
    assert isinstance(OWNER, MachineSettings)
    encoders_only.step(settings, state, frame(0.0, counts))
    for k in range(1, 20):
        counts = np.array([k * 4000, -k * 3000, k * 2000, -k * 5000])
        encoders_only.step(settings, state, frame(float(k), counts))
    return settings, state, counts


def test_it_is_where_it_was_measured_and_counts_on_from_there() -> None:
    settings, state, counts = reckoned()
    before, lengths, untold = state.tracker.pose.copy(), state.lengths.copy(), deepcopy(state)
    told = before + np.array([0.03, -0.02, -0.05])
    known = encoders_only.placed(settings, state, told)
    there = encoders_only.step(settings, known, frame(20.0, counts))
    assert there.valid
    np.testing.assert_allclose(there.position, told, atol=5e-6)  # a count is 3 um
    assert np.abs(known.lengths / lengths - 1.0).max() < 0.01
    moved = encoders_only.step(settings, known, frame(21.0, counts + 1000))
    plain = encoders_only.step(settings, untold, frame(21.0, counts + 1000))
    np.testing.assert_allclose(moved.position - told, plain.position - before, atol=2e-4)


@pytest.mark.parametrize("source", ["load_cells", "motor_torques"])
def test_tensions_determine_the_lengths_that_one_place_leaves_open(source: str) -> None:
    """Of four wrong lengths, a place alone finds three numbers; with tensions it is right elsewhere too."""
    owner = OWNER.model_copy(update={source: TensionSensor(rate=1.0, deviation=1e-3, most=1e4)})
    settings, counts = reckoning_of(ROBOT, owner), np.zeros(4, dtype=np.int64)
    off = 3e-3 * np.array([1.0, -1.0, 1.0, -0.5])
    true = solve_forward(settings.model, inverse(ROBOT, PLACE).lengths + off).checked()
    shown = true.winch_tensions if source == "motor_torques" else true.tensions
    away = inverse(ROBOT, PLACE - np.array([3.0, -2.0, -0.8])).checked().lengths
    errors = []
    for told in (frame(0.0, counts), SensorFrame(0.0, (Encoders(0.0, counts), Tensions(source, 0.0, shown)))):
        state = encoders_only.start(settings, PLACE)
        encoders_only.step(settings, state, told)
        known = encoders_only.placed(settings, state, true.pose, by_tensions=True)
        np.testing.assert_allclose(known.tracker.pose, true.pose, atol=1e-6)
        errors.append(np.abs(known.start_lengths - true.lengths).max())
        found = solve_forward(settings.model, known.start_lengths + away - inverse(ROBOT, PLACE).lengths)
        there = solve_forward(settings.model, away + off)
        errors.append(np.linalg.norm(found.pose - there.pose))
    assert max(errors[2:]) < 1e-9
    assert errors[0] > 1e-3
    assert errors[1] > 5e-4


def test_a_place_that_fits_changes_nothing() -> None:
    settings, state, _ = reckoned()
    known = encoders_only.placed(settings, state, state.tracker.pose.copy())
    np.testing.assert_allclose(known.start_lengths, state.lengths, atol=1e-9)


def test_before_the_first_counts_no_place_can_be_given() -> None:
    settings = reckoning_of(ROBOT, OWNER)
    with pytest.raises(AnswerError, match="has read no encoder yet"):
        encoders_only.placed(settings, encoders_only.start(settings, PLACE), PLACE)


def test_uniform_creep_is_gone_where_it_is_measured() -> None:
    """All lines longer by the same share hang lower; one measured place finds about that share of each."""
    settings = reckoning_of(ROBOT, OWNER)
    state, share = encoders_only.start(settings, PLACE), 1e-3
    encoders_only.step(settings, state, frame(0.0, np.zeros(4, dtype=np.int64)))
    before = state.tracker.pose.copy()
    hangs = solve_forward(settings.model, state.lengths * (1.0 + share), guess=before).checked().pose
    known = encoders_only.placed(settings, state, hangs)
    np.testing.assert_allclose(known.start_lengths / state.lengths - 1.0, share, rtol=0.1)
    assert np.ptp(inverse(ROBOT, before).lengths) > 1.0


class Kept:
    """What a print did between its layers."""

    def __init__(self) -> None:
        self.pauses: list[int] = []
        self.state = PrintState.READY

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        if printer.supervisor.state is PrintState.PAUSED and self.state is not PrintState.PAUSED:
            self.pauses.append(step.progress.layer)
        self.state = printer.supervisor.state


def test_a_print_stops_after_each_layer_and_goes_on() -> None:
    options = PrintOptions(layers=3, plant="quasi-static", period=5.0, severity="rough", place_layers=1,
                           place_sigma=0.0)  # fmt: skip
    twin = twin_of(ROBOT, load_job(EXAMPLES / "house.toml"), None, options)
    machine, printer = begin_print(twin, plan_print(twin))
    attendant, kept = attendant_of(machine, printer, options), Kept()
    measure = attendant.measure
    apart: list[float] = []

    def measured(layer: int, along: int) -> None:
        measure(layer, along)
        printer.estimator.step(machine.step(printer.command))
        apart.append(float(np.linalg.norm(printer.last_pose[:3] - machine.truth.position)))

    attendant.measure = measured
    run_loop(printer, attendant, kept)
    assert printer.finished
    assert len(kept.pauses) == 2
    assert len(apart) == 2
    assert min(apart) > 1e-3  # the estimate before the measurement
    assert isinstance(printer.estimator, DeadReckoning)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"place_layers": -1}, "place layers = -1: must be 1 or more"),
        ({"place_sigma": 2.0}, "place sigma = 2 m: must be from 0 to 1 m"),
    ],
)
def test_numbers_that_cannot_be(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        PrintOptions(**options)


def test_other_estimators_take_no_place() -> None:
    job = load_job(EXAMPLES / "blind-machines.toml")
    with pytest.raises(InputError, match="place layers: is for point platforms in no plane, by encoders alone"):
        twin_of(load("merlet2023"), job, None, PrintOptions(place_layers=1))
    for options, why in (
        ({"place_tensions": True}, "place tensions: give place layers or place every"),
        ({"place_tensions": True, "place_layers": 1}, "machine 'merlet2023' has neither load_cells nor motor_torques"),
    ):
        with pytest.raises(InputError, match=why):
            twin_of(load("merlet2023"), job, None, PrintOptions(estimator="encoders", **options))
    robot, owner = load("merlet2023"), load_twin("merlet2023").owner
    assert not isinstance(estimator("filter", robot, owner, PLACE), DeadReckoning)


def crept(compliance: float) -> Robot:
    """The house printer with cables of this creep in an hour, 1/N, by all parts of the law."""
    law = Creep(retardations=(60.0, 1200.0), compliances=(0.2 * compliance, 0.2 * compliance),
                logarithmic=0.6 * compliance)  # fmt: skip
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in ROBOT.lines)
    return ROBOT.model_copy(update={"lines": tuple(lines)})


def test_creep_as_described_is_counted() -> None:
    """The machine creeps as its robot says, and encoders alone know: with undescribed creep they do not."""
    robot, twin = crept(3e-7), load_twin("house-printer")
    machine = SimulatedMachine(robot, twin, PLACE, seed=1, plant="quasi-static")
    settings = reckoning_of(robot, twin.owner)
    told = encoders_only.start(settings, PLACE)
    ignorant = reckoning_of(ROBOT, twin.owner)
    untold = encoders_only.start(ignorant, PLACE)
    known = np.zeros(3)
    while machine.time < 900.0:
        seen = machine.step(Command(machine.time, np.zeros(4)))
        known = encoders_only.step(settings, told, seen).position
        guessed = encoders_only.step(ignorant, untold, seen).position
    true = machine.truth.position
    assert PLACE[2] - true[2] > 0.005
    off = np.linalg.norm(known - true)
    assert off < 0.12 * np.linalg.norm(guessed - true)


def test_a_measured_place_has_what_crept_by_then() -> None:
    robot = crept(3e-7)
    settings = reckoning_of(robot, OWNER)
    state, counts = encoders_only.start(settings, PLACE), np.zeros(4, dtype=np.int64)
    for k in range(60):
        encoders_only.step(settings, state, frame(10.0 * k, counts))
    there = state.tracker.pose.copy()
    known = encoders_only.placed(settings, state, there)
    again = encoders_only.step(settings, known, frame(600.0, counts))
    np.testing.assert_allclose(again.position, there, atol=2e-4)
    for k in range(60):
        again = encoders_only.step(settings, known, frame(610.0 + 10.0 * k, counts))
    assert there[2] - again.position[2] > 5e-4  # it creeps on


def test_what_crept_is_saved_with_a_print() -> None:
    robot = crept(3e-7)
    began = estimator("encoders", robot, OWNER, PLACE)
    assert isinstance(began, DeadReckoning)
    for k in range(60):
        began.step(frame(10.0 * k, np.zeros(4, dtype=np.int64)))
    snapshot = save(began)
    place = began.step(frame(600.0, np.zeros(4, dtype=np.int64))).position
    resumed, fresh = (estimator("encoders", robot, OWNER, place) for _ in range(2))
    assert isinstance(resumed, DeadReckoning)
    restore(resumed, snapshot)
    drops = []
    for one in (began, resumed, fresh):
        for k in range(60):
            there = one.step(frame(610.0 + 10.0 * k, np.zeros(4, dtype=np.int64))).position
        drops.append(place[2] - there[2])
    assert drops[1] == pytest.approx(drops[0], rel=0.2)
    assert drops[2] > 2.0 * drops[0]  # counted again, as if rested
