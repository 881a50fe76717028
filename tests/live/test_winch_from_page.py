"""One winch is turned from the page on virtual drives: while it is held, and by nothing else."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.signals import OrderKind, PrintState
from cablewright.live.serve.events import Events
from cablewright.live.serve.link import LEASE, ControlLink
from cablewright.live.serve.messages import OrderMessage
from cablewright.live.serve.operated_machines import DriveStation, Sitting
from cablewright.live.serve.page_orders import PageOperator
from cablewright.live.serve.winch import HELD, WINCH
from cases import some
from virtual_drives import Bench, bench

pytestmark = pytest.mark.usefixtures("unpaced")
LINE, SPEED = 1, 0.05  # m/s, pays out


class Desk:
    """A page that operates a sitting, in the machine's time."""

    def __init__(self, sitting: Sitting, folder: Path) -> None:
        self.sitting, self.link = sitting, ControlLink.new()
        self.orders, self.stops = self.link.connect()
        self.events = Events.at(folder / "orders.jsonl")
        self.operator = PageOperator(
            self.link, self.events, False, lambda _load: "", sitting.refill, lambda: False, winches=sitting.winches
        )
        self.count = 0

    def send(self, kind: OrderKind, channel: socket.socket | None = None, age: float = 0.0, **given: object) -> int:
        self.count += 1
        about = {"by": "Ann", "number": self.count, "at": time.monotonic() - age, "lease": 5}
        message = OrderMessage.model_validate(about | {"kind": kind, "arguments": given})
        (channel or self.orders).send(message.model_dump_json().encode())
        return self.count

    def hold(self, speed: float = SPEED, age: float = 0.0, line: int = LINE) -> None:
        self.send(OrderKind.TAKE_UP, age=age, **{WINCH: (line, speed), HELD: (1.0,)})

    def step(self, steps: int = 1) -> None:
        printer = self.sitting.printer
        for _ in range(steps):
            self.link.told_lease.write(LEASE.pack(5, time.monotonic()))
            step = printer.step(self.operator.orders(printer, printer.time))
            self.operator.answered(printer, step.orders, step.frame.time)

    def refusal(self, number: int) -> str:
        return next(why for known, _, why in self.events.answers if known == number)

    @property
    def state(self) -> PrintState:
        return self.sitting.printer.supervisor.state

    def close(self) -> None:
        self.sitting.printer.machine.stop()
        self.sitting.printer.machine.close()
        for each in (self.orders, self.stops, self.link, self.events):
            each.close()


@pytest.fixture
def found() -> Bench:
    return bench()


@pytest.fixture
def desk(found: Bench, tmp_path: Path) -> Iterator[Desk]:
    pose = np.array(found.rig.plant.truth.position)
    sitting = DriveStation(found.robot, found.twin.owner, tmp_path / "machine", lambda: found.port, pose).sitting(None)
    made = Desk(sitting, tmp_path)
    sitting.printer.machine.open()
    made.step(30)
    for kind in (OrderKind.RESET, OrderKind.ENABLE):
        made.send(kind)
        made.step(80)
    assert made.state is PrintState.IDLE
    yield made
    made.close()


def test_one_winch_turns_while_it_is_held_and_no_other_does(found: Bench, desk: Desk) -> None:
    before = found.rig.plant.truth.lengths.copy()
    begun = desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, SPEED)})
    desk.step(3)
    assert desk.refusal(begun) == ""
    assert desk.state is PrintState.TENSIONING
    for _ in range(12):
        desk.hold()
        desk.step(5)
    turning = found.rig.plant.truth.lengths - before
    assert 0.01 < turning[LINE] < 0.05
    desk.hold(speed=0.0)  # let go
    desk.step(120)
    assert desk.state is PrintState.IDLE
    paid = found.rig.plant.truth.lengths - before
    assert paid[LINE] - turning[LINE] < 0.01
    assert np.abs(np.delete(paid, LINE)).max() < 1e-3


def test_old_foreign_and_late_holds_turn_nothing(found: Bench, desk: Desk) -> None:
    desk.hold()  # nothing was begun
    desk.step(20)
    assert desk.state is PrintState.IDLE
    desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, SPEED)})
    desk.step(3)
    before = found.rig.plant.truth.lengths.copy()
    for _ in range(8):
        desk.hold(age=0.3)  # as from a control that hung
        desk.hold(line=0)  # another winch
        desk.step(5)
    desk.step(60)
    assert np.abs(found.rig.plant.truth.lengths - before).max() < 1e-3
    assert desk.state is PrintState.IDLE


@pytest.mark.parametrize(
    ("given", "why"),
    some([((9.0, 0.01), "number of a winch"), ((1.0, 9.0), "is allowed by hand"), ((0.5, 0.01), "number of a winch"),
          ((1.0,), "number of a winch"), ((1.0, 0.0), "is allowed by hand")], 2),
)  # fmt: skip
def test_what_is_no_winch_or_too_fast_is_rejected(desk: Desk, given: tuple[float, ...], why: str) -> None:
    number = desk.send(OrderKind.TAKE_UP, **{WINCH: given})
    desk.step(3)
    assert why in desk.refusal(number)
    assert desk.state is PrintState.IDLE


def test_a_stop_ends_it_and_slack_is_taken_up_after_it(found: Bench, desk: Desk) -> None:
    desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, SPEED)})
    desk.step(3)
    for _ in range(4):
        desk.hold()
        desk.step(5)
    desk.send(OrderKind.STOP, desk.stops)
    desk.step(60)
    assert desk.state is PrintState.IDLE
    before = found.rig.plant.truth.lengths.copy()
    number = desk.send(OrderKind.TAKE_UP)  # no line is slack, so that this ends immediately
    for _ in range(4):
        desk.hold()
        desk.step(5)
    assert desk.refusal(number) == ""
    assert desk.state is PrintState.IDLE
    assert np.abs(found.rig.plant.truth.lengths - before).max() < 1e-3


def test_a_hold_of_another_speed_lets_go(found: Bench, desk: Desk) -> None:
    """Whoever changes from out to in quickly, before the page shows the state, holds what was not begun."""
    desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, SPEED)})
    desk.step(3)
    before = found.rig.plant.truth.lengths.copy()
    rejected = desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, -SPEED)})
    for _ in range(8):
        desk.hold(speed=-SPEED)
        desk.step(5)
    desk.step(60)
    assert "tensioning" in desk.refusal(rejected)
    assert np.abs(found.rig.plant.truth.lengths - before).max() < 1e-3
    assert desk.state is PrintState.IDLE


def test_a_winch_that_is_chosen_as_the_winches_are_enabled_is_the_one_that_begins(found: Bench, desk: Desk) -> None:
    """Both orders of one step: the machine is not idle yet when the second one is looked at."""
    desk.send(OrderKind.RELEASE)
    desk.step(80)
    assert desk.state is PrintState.OFF
    before = found.rig.plant.truth.lengths.copy()
    desk.send(OrderKind.ENABLE)
    begun = desk.send(OrderKind.TAKE_UP, **{WINCH: (LINE, SPEED)})
    desk.step(1)
    assert desk.refusal(begun) == ""
    assert desk.state is PrintState.TENSIONING
    assert desk.sitting.winches is not None
    assert desk.sitting.winches._jog is not None
    desk.step(120)
    assert desk.state is PrintState.IDLE
    assert np.abs(found.rig.plant.truth.lengths - before).max() < 1e-3
