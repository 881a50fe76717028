"""The loop prints on a machine that is no simulation to it: on a thread, late, lossy, and without truth."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace
from pathlib import Path
from queue import Queue

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import read_snapshots
from cablewright.foundation.signals import (
    Command,
    Condition,
    Order,
    OrderKind,
    PrintState,
    Scan,
    SensorFrame,
    WinchMode,
)
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.recorder import FolderRecorder, Timing
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.interface import Abilities, check_command
from cablewright.machine.log.log import LogHead, read_log, write_log
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.path_offset import nearest
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

RADII = {"dynamic": 0.06, "quasi-static": 0.4}  # m: steps of the latter are twenty times as long
ON = (Order(OrderKind.RESET), Order(OrderKind.ENABLE))
START = Order(OrderKind.START)


def twin(plant: str) -> MachineTwin:
    ring = Job(
        name="ring",
        origin=(0.7 - RADII[plant], -0.5, 0.0),
        helix=Helix(radius=RADII[plant], layers=1, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.03, travel_speed=0.03, acceleration=0.02),
    )
    return twin_of(load("merlet2023"), ring, None, PrintOptions(plant=plant))  # type: ignore[arg-type]


class OwnMachine:
    """A plant on a thread of its own: it goes on with its last command until the next one.

    Of a hundred steps five are late, by one or two periods; of a hundred readings two are lost.
    """

    def __init__(self, plant: SimulatedMachine, seed: int = 1) -> None:
        """Not yet open. It is driven by queues, not by a clock, so that a busy computer changes nothing."""
        self.plant, self.random = plant, np.random.default_rng(seed)
        self.asked: Queue[tuple[Command, int] | None] = Queue()
        self.answered: Queue[SensorFrame] = Queue()
        self.worker = threading.Thread(target=self.work, daemon=True)
        self.calls: list[str] = []
        self.last_time = -np.inf

    @property
    def period(self) -> float:
        return self.plant.period

    @property
    def abilities(self) -> Abilities:
        modes = frozenset({WinchMode.OFF, WinchMode.HOLD, WinchMode.VELOCITY})
        return Abilities(self.plant.robot.m, self.plant.abilities.sensors, modes, brakes=True)

    def open(self) -> None:
        self.calls.append("open")
        self.worker.start()

    def work(self) -> None:
        while (asked := self.asked.get()) is not None:
            command, steps = asked
            frames = [self.plant.step(replace(command, time=command.time + k * 1e-9)) for k in range(steps)]
            readings = tuple(r for frame in frames for r in frame.readings if self.random.random() > 0.02)
            notices = tuple(notice for frame in frames for notice in frame.notices)
            self.answered.put(SensorFrame(frames[-1].time, readings, notices))

    def step(self, command: Command) -> SensorFrame:
        check_command(self.abilities, command, self.last_time)
        self.last_time = command.time
        late = int(self.random.integers(1, 3)) if self.random.random() < 0.05 else 0
        self.asked.put((command, 1 + late))
        return self.answered.get(timeout=60.0)

    def stop(self) -> None:
        self.calls.append("stop")

    def close(self) -> None:
        self.calls.append("close")
        self.asked.put(None)
        self.worker.join(timeout=60.0)


def made(chosen: MachineTwin) -> SimulatedMachine:
    begin = chosen.path.track.at(0.0).position
    return SimulatedMachine(chosen.robot, chosen.settings, begin, seed=chosen.choices.seed, plant=chosen.choices.plant)


def printer_of(chosen: MachineTwin, machine: OwnMachine) -> Printer:
    settings = machine.plant.settings
    return Printer(
        plan_print(chosen),
        machine,
        lambda place, radii: estimator(chosen.estimator, chosen.robot, settings, place, (), radii),
    )


@dataclass
class Kept:
    """A recorder that keeps all."""

    steps: list[Step] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    ends: list[bool] = field(default_factory=list)

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        self.steps.append(step)
        assert isinstance(printer.machine, OwnMachine)
        if step.progress.state is PrintState.PRINTING:
            track = printer.plan.path.track
            self.off.append(nearest(track, printer.machine.plant.truth.position, step.progress.distance).offset)
        self.ends.append(last)


@pytest.mark.parametrize("plant", ["quasi-static", pytest.param("dynamic", marks=pytest.mark.slow)])
def test_a_ring_is_printed_on_it(plant: str) -> None:
    chosen = twin(plant)
    machine = OwnMachine(made(chosen))
    printer, kept = printer_of(chosen, machine), Kept()
    steps = loop.run(printer, Attendant(lambda: None), kept)
    assert printer.finished
    assert kept.ends == [False] * (steps - 1) + [True]
    assert machine.calls == ["open", "stop", "close"]
    assert np.abs(kept.off).max() < 0.03
    late = [step for step in kept.steps if any(n.condition is Condition.OVERRUN for n in step.frame.notices)]
    assert 0.02 * steps < len(late) < 0.1 * steps


def test_its_log_has_no_truth_and_its_checkpoint_only_the_print(tmp_path: Path) -> None:
    chosen = twin("quasi-static")
    machine = OwnMachine(made(chosen))
    printer = printer_of(chosen, machine)
    head = LogHead(chosen.robot, machine.plant.settings, machine.period, kind="real")
    with (
        write_log(tmp_path / "log.mcap", head) as log,
        SnapshotWriter(tmp_path / "checkpoint.bin", lambda _: b"") as writer,
    ):
        loop.run(printer, Attendant(lambda: None), FolderRecorder(log, writer, Timing(machine.period)))
    assert read_snapshots(tmp_path / "checkpoint.bin").keys() == {"print"}
    with read_log(tmp_path / "log.mcap") as found:
        entries = list(found.entries())
    assert all(entry.truth is None for entry in entries)
    assert [order.kind for order in entries[0].orders] == [OrderKind.RESET, OrderKind.ENABLE, OrderKind.START]
    assert {order.by for order in entries[0].orders} == {"attendant"}


class Scripted:
    """An operator who gives orders at steps."""

    def __init__(self, steps: dict[int, tuple[Order, ...]], last: int) -> None:
        self.steps, self.last, self.number = steps, last, 0

    def orders(self, _printer: Printer, now: float) -> tuple[Order, ...]:
        self.number += 1
        return tuple(replace(order, time=max(order.time, now)) for order in self.steps.get(self.number, ()))

    def is_over(self, _printer: Printer) -> bool:
        return self.number >= self.last


def run(orders: dict[int, tuple[Order, ...]], last: int, kind: type[OwnMachine] = OwnMachine) -> list[Step]:
    """All steps of a dynamic machine under these orders."""
    chosen, kept = twin("dynamic"), Kept()
    loop.run(printer_of(chosen, kind(made(chosen))), Scripted(orders, last), kept)
    return kept.steps


def test_a_jog_moves_it_only_while_it_is_ordered_and_a_stop_is_a_ramp() -> None:
    jog = Order(OrderKind.JOG, "anna", arguments={"velocity": (0.0, 0.05, 0.0)})
    orders = {1: ON} | dict.fromkeys(range(600, 700, 5), (jog,)) | {700: (Order(OrderKind.STOP, "ben"),)}
    steps = run(orders, 800)
    states = [step.progress.state for step in steps]
    moving = [k for k, step in enumerate(steps) if step.command.winch_speeds.any()]
    assert states[599] is PrintState.MANUAL
    assert 599 <= moving[0] <= 602
    assert states[699] is PrintState.IDLE
    assert 700 <= moving[-1] <= 752  # the ramp takes half a second
    speeds = np.array([np.abs(step.command.winch_speeds).max() for step in steps])
    assert (np.diff(speeds[700:]) <= 1e-12).all()


def test_a_gap_in_the_jog_stops_it() -> None:
    jog = Order(OrderKind.JOG, arguments={"velocity": (0.0, 0.05, 0.0)})
    steps = run({1: ON, 600: (jog,)}, 1000)
    moved = steps[-1].estimate.position - steps[598].estimate.position
    assert steps[-1].progress.state is PrintState.IDLE
    assert abs(moved[1]) < 0.02


def test_the_speed_is_overridden_and_never_beyond_the_plan() -> None:
    half = Order(OrderKind.OVERRIDE, arguments={"share": (0.5,)})
    more = Order(OrderKind.OVERRIDE, arguments={"share": (1.5,)})
    steps = run({1: (*ON, START, half), 2: (more,)}, 1500)
    assert steps[1].orders[0].refusal == "override: share = (1.5,): one number from 0 to 1 is expected"
    printing = [(s.frame.time, s.progress.distance) for s in steps if s.progress.state is PrintState.PRINTING]
    (began, there), (ended, here) = printing[-300], printing[-1]
    assert (here - there) / (ended - began) == pytest.approx(0.015, rel=0.02)


class Jumping(OwnMachine):
    """One whose clock jumps back by five seconds, and stays there."""

    def step(self, command: Command) -> SensorFrame:
        frame = super().step(command)
        if frame.time <= 8.0:
            return frame
        early = [
            replace(each, **{key: getattr(each, key) - 5.0})
            for each in frame.readings
            for key in (("begin",) if isinstance(each, Scan) else ("time",))
        ]
        return replace(frame, time=frame.time - 5.0, readings=tuple(early))


def test_a_clock_that_jumps_back_is_a_fault_that_can_be_reset() -> None:
    """Frames and readings go on by the loop's own clock, in which the estimator finds the position again."""
    orders = {1: (*ON, START), 900: (Order(OrderKind.RESET, time=100.0), Order(OrderKind.ENABLE), START)}
    steps = run(orders, 1500, Jumping)
    first = next(k for k, step in enumerate(steps) if step.progress.state is PrintState.FAULT)
    assert 700 < first < 800
    assert "clock jumped back" in steps[first].progress.reason
    assert [step.progress.state for step in steps[first:899]] == [PrintState.FAULT] * (899 - first)
    times = [step.frame.time for step in steps]
    assert (np.diff(times) > 0.0).all()
    assert not steps[first + 60].command.winch_speeds.any()
    assert steps[898].command.modes == (WinchMode.OFF,) * 4
    assert steps[-1].progress.state is PrintState.PRINTING
    assert steps[-1].estimate.valid


def test_what_a_machine_lacks_is_said_before_it_moves() -> None:
    chosen = twin("quasi-static")
    machine = OwnMachine(made(chosen))
    able = machine.abilities
    for changes, says in (
        ({"winches": 8}, "has 8 winches, the robot 4 lines"),
        ({"sensors": frozenset({"barrier"})}, "needs the sensor 'encoders', which the machine lacks; it has barrier"),
        ({"modes": frozenset({WinchMode.TENSION})}, "needs the winch mode 'velocity'"),
    ):
        lacking = type("Lacking", (OwnMachine,), {"abilities": replace(able, **changes)})(machine.plant)
        with pytest.raises(InputError, match=says):
            printer_of(chosen, lacking)
        assert not lacking.calls


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"winch_speeds": np.zeros(3)}, "4 finite numbers are expected"),
        ({"winch_speeds": np.full(4, np.nan)}, "4 finite numbers are expected"),
        ({"modes": (WinchMode.HOLD,) * 3}, "command.modes: 4 are expected; got 3"),
        ({"modes": (WinchMode.TENSION,) * 4}, "'tension' of winch 1: the machine has hold, off, velocity"),
        ({"modes": (WinchMode.OFF,) * 4, "winch_speeds": np.ones(4)}, "1 rad/s of winch 1, which is 'off'"),
        ({"outputs": {"fan": 1.0}}, "'fan': the machine has no such output"),
        ({"time": -1.0}, "the clock jumped back"),
    ],
)
def test_a_command_that_a_machine_cannot_take_is_rejected(changes: dict[str, object], says: str) -> None:
    able = made(twin("quasi-static")).abilities
    usual = Command(1.0, np.zeros(4))
    check_command(able, usual, 0.0)
    with pytest.raises(InputError, match=says):
        check_command(able, replace(usual, **changes), 0.0)
