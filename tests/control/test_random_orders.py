"""The promises of the loop under random orders and faults: `tools/random_orders.py` runs more of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from tools.random_orders import run_sequence
from tools.random_world import Followed, Shaken, desk, plan

from cablewright.control import guard, manual, orders, supervisor
from cablewright.control.transitions import TRANSITIONS
from cablewright.foundation.reading_times import ReadingTimes, Timeliness
from cablewright.foundation.signals import OrderKind, PrintState, WinchMode
from cablewright.live.prints import loop
from cablewright.live.prints.loop import Printer
from cablewright.live.serve.page_orders import PageOperator

BODIES = range(60)


@pytest.mark.parametrize("lives", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_no_promise_is_broken_and_every_state_is_seen(lives: int) -> None:
    seen = set().union(*map(run_sequence, range(lives)))
    assert seen == set(PrintState)


def test_no_promise_is_broken_with_a_rigid_platform() -> None:
    seen = set().union(*(run_sequence(seed, body=True) for seed in BODIES))
    assert seen == set(PrintState)


def test_what_waits_ends_by_the_servers_clock_where_the_machines_stands_still() -> None:
    random = np.random.default_rng(0)
    machine = Shaken(random, calm=True)
    machine.simulated, machine.wrong = True, {"person": np.inf}
    printer = Printer(plan(), machine, lambda _place, _radii: Followed(machine))
    printer.supervisor.state = PrintState.PAUSED
    waits: list[bool] = []
    with desk(random, machine) as (people, operator):
        people.lease = 1
        for hangs in (0.0, 0.6, 0.5, 0.0):  # s; none is long enough to be a fault
            people._tell(machine.wall)
            if not waits:
                people._send(OrderKind.RESUME, machine.wall)
            machine.hang_due = hangs
            step = printer.step(operator.orders(printer, printer.time))
            operator.answered(printer, step.orders, step.frame.time)
            waits.append(printer.supervisor.resume_ordered)
    assert waits == [True, True, True, False]
    assert printer.supervisor.state is PrintState.PAUSED


def without(order: OrderKind, *states: PrintState) -> dict[Any, PrintState]:
    """The table without the effect of an order in some states."""
    return {key: then for key, then in TRANSITIONS.items() if key not in {(state, order) for state in states}}


_BEGIN = manual.begin


def begin_elsewhere(settings: Any, state: Any, order: Any, now: float, place: Any) -> None:
    """Begin a motion by hand, but not where the platform is."""
    _BEGIN(settings, state, order, now, place)
    state.position += 0.2


def always_new(times: ReadingTimes, source: str, time: float, _now: float) -> Timeliness:
    """Take every reading for a new one."""
    times.times[source] = time
    return Timeliness.NEW


BREAKS = {
    "the fault stays": (supervisor, "_no_reset", lambda *_: ""),
    "over its limit": (guard, "_measured_tensions", lambda *_: ([], True)),
    "brakes open": (loop, "advance", lambda _settings, stop, _dt: (stop.speeds, WinchMode.VELOCITY)),
    "on winches that were not held": (loop, "advance", lambda *_: (np.zeros(4), WinchMode.OFF)),
    "beside a person": (supervisor, "_person", lambda *_: ""),
    "begins beside a person": (ReadingTimes, "judge", always_new),
    "without repetition": (manual, "LEASE", 1e9),
    "by an order that lives no more": (orders, "ORDER_LIFE", 1e9),
    "goes on: pause": (supervisor, "TRANSITIONS", without(OrderKind.PAUSE, PrintState.PAUSED, PrintState.STOPPED)),
    "after its lease": (PageOperator, "_withdrawal", lambda *_: []),
    "after the control hung": (guard, "_CONDITIONS", {}),
    "not its own": (manual, "begin", begin_elsewhere),
    "reset with a cause": (guard, "_inputs", lambda *_: []),
    "left the fault": (supervisor, "TRANSITIONS", TRANSITIONS | {(PrintState.FAULT, OrderKind.START): PrintState.IDLE}),
}


FIRST = {"without repetition": 413, "by an order that lives no more": 99, "after its lease": 119, "goes on: pause": 35}
"""Lives that break a promise, of the rare ones: a search begins there, and goes on to others if those no longer do."""


def broken_promises(first: int, lives: int) -> Iterator[str]:
    """The first broken promise of each life that breaks one."""
    for seed in range(first, first + lives):
        try:
            run_sequence(seed)
        except AssertionError as error:
            yield str(error)


@pytest.mark.parametrize("says", BREAKS)
def test_whoever_breaks_one_is_found(says: str, monkeypatch) -> None:
    module, name, broken = BREAKS[says]
    monkeypatch.setattr(module, name, broken)
    assert any(re.search(says, each) for each in broken_promises(FIRST.get(says, 0), 2000))
