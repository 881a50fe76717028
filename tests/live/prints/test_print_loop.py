"""A print under control: it keeps to its path, stops for people, is refilled, and goes on where it was."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import AnswerError, InputError, UnknownName
from cablewright.foundation.saved_state import Snapshot
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.recorder import checkpoint_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.live.replay import replay as replayed
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import LogWriter
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.effect_sizes import WinchBrakes
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

ROBOT = load("merlet2023")
RING = Job(
    name="ring",
    origin=(0.3, -0.5, 0.0),
    helix=Helix(radius=0.4, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.03, travel_speed=0.03, acceleration=0.02),
)


def twin(**choices: object) -> MachineTwin:
    return twin_of(ROBOT, RING, None, PrintOptions(**choices))  # type: ignore[arg-type]


class Print:
    """One that can be taken further step by step."""

    def __init__(
        self, made: MachineTwin, kept: dict[str, Snapshot] | None = None, machine: SimulatedMachine | None = None
    ) -> None:
        begin = made.path.track.at(0.0).position
        self.machine = machine or SimulatedMachine(
            made.robot, made.settings, begin, seed=made.choices.seed, plant=made.choices.plant
        )
        settings = self.machine.settings
        self.printer = Printer(
            plan_print(made),
            self.machine,
            lambda place, radii: estimator(made.estimator, made.robot, settings, place, (), radii),
            now=self.machine.time,
            saved=kept,
        )
        self.attendant = Attendant(lambda: self.machine.refill(self.printer.plan.powder), refill_time=10.0)

    def steps(self, most: int) -> Iterator[Step]:
        for _ in range(most):
            yield self.printer.step(self.attendant.orders(self.printer, self.machine.time))
            if self.printer.finished:
                return

    def beside(self, step: Step) -> float:
        """True distance from the path, m."""
        return self.printer.plan.path.offset(self.machine.truth.position, step.progress.distance)


@pytest.mark.parametrize("law", ["model", pytest.param("paper", marks=pytest.mark.slow)])
def test_it_prints_along_its_path_at_its_speed(law: str) -> None:
    """Within the 2 cm that the paper expects, and most of the time far within."""
    made = Print(twin(law=law))
    off, speeds = [], []
    for step in made.steps(1800):
        if step.progress.state is PrintState.PRINTING and step.progress.distance > 0.1:
            off.append(made.beside(step))
            speeds.append(np.linalg.norm(made.machine.truth.velocity))
    assert np.abs(off).max() < 0.015
    assert np.mean(speeds) == pytest.approx(0.03, rel=6e-3)
    assert made.printer.supervisor.state is PrintState.PRINTING


@pytest.mark.parametrize("estimator", ["filter", "paper"])
def test_it_comes_to_its_end_and_nothing_is_lost(estimator: str) -> None:
    made, opened = Print(twin(estimator=estimator, plant="quasi-static")), 0.0
    for step in made.steps(400):
        opened += step.command.valve * made.machine.period
    assert made.printer.finished
    ground, drum = made.machine.rig.ground, made.machine.settings.drum
    assert made.machine.truth.powder + ground.mass + made.machine.rig.falling_mass == pytest.approx(
        drum.powder, rel=1e-9
    )
    assert opened * 0.03 == pytest.approx(made.printer.plan.path.track.length, rel=1e-3)  # full flow at full speed


def test_encoders_alone_carry_their_errors_along() -> None:
    """They cannot see how cable lies on the drums, so their errors are larger than with lidars, and unknown to them."""
    made = Print(twin(estimator="encoders", plant="quasi-static", seed=3))
    off, seen = [], []
    for step in made.steps(400):
        if step.progress.state is PrintState.PRINTING:
            off.append(made.beside(step))
            seen.append(step.progress.error)
    assert made.printer.finished
    assert 5e-3 < np.abs(off).max() < 0.1
    assert np.abs(seen).max() < 2e-3


def test_somebody_in_the_light_barrier_stops_it_and_it_goes_on_there() -> None:
    made = twin(plant="quasi-static", seed=1)
    inside = made.settings.simulation.barrier.model_copy(update={"intrusions": ((30.0, 50.0),)})
    made = replace(made, settings=made.settings.with_simulation(barrier=inside))
    running = Print(made)
    places, states = [], []
    for step in running.steps(400):
        places.append(running.machine.truth.position)
        states.append(
            (running.machine.time, step.progress.state, step.command.winch_speeds.any(), step.progress.distance)
        )
    assert running.printer.finished
    assert running.printer.supervisor.barrier_stops == 1
    stood = [each for each in states if 35.0 <= each[0] <= 52.0]
    assert all(state is PrintState.PAUSED and not moved for _, state, moved, _ in stood)
    away = [d for t, _, _, d in states if 30.0 <= t <= 36.0]
    assert away[-1] - away[0] < 0.1  # a controlled stop
    after = next(d for t, state, _, d in states if t > 52.0 and state is PrintState.PRINTING)
    assert after == pytest.approx(stood[-1][3], abs=1e-9)


def test_an_empty_drum_is_refilled_where_it_stands() -> None:
    made = twin(plant="quasi-static")
    little = made.settings.owner.drum.model_copy(update={"powder": 1.0})
    running = Print(replace(made, settings=made.settings.with_owner(drum=little)))
    refilled = [step.progress.state for step in running.steps(600)].count(PrintState.REFILLING)
    assert running.printer.finished
    assert running.printer.supervisor.refills == 1
    assert refilled >= 10
    assert running.machine.truth.powder > 0.2


def test_its_filter_and_a_replay_of_its_log_receive_the_mass_of_powder(tmp_path: Path) -> None:
    """Valve and refills are in the log: the estimates of a replay are those of the print."""
    made = twin(plant="quasi-static", estimator="filter", severity="rough", seed=1)
    little = made.settings.owner.drum.model_copy(update={"powder": 1.0})
    running = Print(replace(made, settings=made.settings.with_owner(drum=little)))
    machine, path = running.machine, tmp_path / "print.mcap"
    head = LogHead(made.robot, machine.settings, machine.period, simulation=machine.simulation, plant="quasi-static")
    found = []
    with path.open("wb") as file, LogWriter(file, head) as log:
        for step in running.steps(600):
            log.write(step.frame, step.command, machine.truth, step.estimate, step.progress, step.orders)
            if step.estimate.valid:
                found.append(np.linalg.norm(step.estimate.position - machine.truth.position))
    assert running.printer.supervisor.refills == 1
    again = replayed(path, "filter")
    off = np.concatenate([again.position(moving=moving) for moving in (False, True)])
    assert again.valid == len(found)
    assert np.sort(off) == pytest.approx(np.sort(found[-len(off) :]), abs=1e-12)


def test_a_print_taken_up_from_its_notes_goes_on_at_its_place() -> None:
    made = twin(plant="quasi-static")
    first = Print(made)
    for step in first.steps(40):
        distance = step.progress.distance
    notes = checkpoint_of(first.printer)
    snapshot = first.machine.snapshot()
    machine = SimulatedMachine.resumed(ROBOT, made.settings, snapshot, seed=0, plant="quasi-static")
    second = Print(made, notes, machine)
    assert second.printer.load.poured == first.printer.load.poured > 0.0
    printing = [step.progress.distance for step in second.steps(400) if step.progress.state is PrintState.PRINTING]
    assert 0.0 <= printing[0] - distance <= 0.031  # the step that was decided on
    assert second.printer.finished


def test_a_platform_that_was_moved_meanwhile_comes_back_before_it_prints() -> None:
    made = twin(plant="quasi-static")
    first = Print(made)
    for _ in first.steps(40):
        pass
    notes = checkpoint_of(first.printer)
    away = made.path.track.at(0.0).position + np.array([0.0, -0.4, 0.2])
    second = Print(made, notes, SimulatedMachine(ROBOT, made.settings, away, seed=4, plant="quasi-static"))
    steps = [(step.progress.state, second.beside(step), step.command.valve) for step in second.steps(400)]
    assert second.printer.finished
    assert max(abs(off) for state, off, _ in steps if state is PrintState.PRINTING) < 0.02
    assert all(valve == 0.0 for state, off, valve in steps if abs(off) > 0.02)


def test_a_job_that_cannot_be_printed_is_rejected_at_the_start() -> None:
    far = RING.model_copy(update={"origin": (2.3, -0.5, 0.0)})
    with pytest.raises(AnswerError, match=r"leaves the frame of 'merlet2023' at 2\.7"):
        plan_print(twin_of(ROBOT, far, None, PrintOptions()))
    high = RING.model_copy(update={"origin": (0.3, -0.5, 2.95)})
    with pytest.raises(AnswerError, match="leaves the workspace of 'merlet2023'"):
        plan_print(twin_of(ROBOT, high, None, PrintOptions()))
    with pytest.raises(InputError, match="robot = 'other', but the robot is 'merlet2023'"):
        twin_of(ROBOT, RING.model_copy(update={"robot": "other"}), None, PrintOptions())
    with pytest.raises(InputError, match=r"has no winch\.drum_radius"):
        twin_of(load("wang2021"), RING, None, PrintOptions())
    with pytest.raises(InputError, match="does not measure it; give height = job"):
        plan_print(twin(estimator="encoders", height="structure"))
    with pytest.raises(UnknownName, match="estimator"):
        Print(twin(estimator="crystal ball"))


def test_brakes_that_give_are_a_cause_that_a_person_has_to_reset_twice() -> None:
    """As on real drives: the reset that is rejected takes note of where the winches are, and encoders know it."""
    weak = twin(estimator="encoders", plant="quasi-static", seed=3)
    law = WinchBrakes(torque=10.0)  # N m; a line pulls up to 20
    made = Print(replace(weak, settings=weak.settings.with_simulation(brakes=law)))
    for _ in made.steps(50):
        pass
    printer, machine = made.printer, made.machine
    assert printer.supervisor.state is PrintState.PRINTING

    def ordered(*kinds: OrderKind) -> Step:
        return printer.step(tuple(Order(kind, "person", machine.time) for kind in kinds))

    before, known = machine.truth.lengths, ordered(OrderKind.EMERGENCY).estimate.lengths
    for _ in range(60):
        step = printer.step()
    assert step.progress.state is PrintState.FAULT
    assert step.progress.reason == "emergency stop"
    slipped = machine.truth.lengths - before
    assert slipped.max() > 0.03
    assert step.estimate.lengths - known == pytest.approx(slipped, rel=0.1, abs=3e-3)  # as regular coils would say
    refusal = ordered(OrderKind.RESET).orders[0].refusal
    assert refusal.startswith("reset: a brake is not as it was commanded: ")
    assert refusal.endswith("which its brake should hold: secure the load")
    printer.step()  # a reset is an edge
    assert ordered(OrderKind.RESET).orders[0].refusal == ""
    assert ordered(OrderKind.ENABLE).orders[0].refusal == ""
    printer.step()
    held = machine.truth.lengths
    for _ in range(20):
        printer.step()
    assert machine.truth.lengths == pytest.approx(held, abs=1e-4)  # by motors
