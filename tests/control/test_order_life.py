"""Orders live shortly, readings count by their own times, and a motion by hand is judged by its own target."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tools.random_world import Followed, Shaken, plan

from cablewright.control import orders, supervisor
from cablewright.control.orders import CALMING, OrderState
from cablewright.control.supervisor import SupervisorSettings, SupervisorState
from cablewright.control.winch_jog import WinchJog, WinchJogSettings
from cablewright.foundation.reading_times import ReadingTimes, Timeliness
from cablewright.foundation.signals import (
    ORDER_LIFE,
    Barrier,
    Estimate,
    Order,
    OrderKind,
    PrintState,
    Reading,
    SensorFrame,
    Tensions,
    frozen,
)
from cablewright.live.prints.loop import Printer

TIMEOUT = 0.5  # s
LIMITS = SupervisorSettings((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), 0.2, barrier_timeout=TIMEOUT)
DT = 0.05


class Floor:
    """The supervisor of a print that is paused by somebody in the light barrier, or was."""

    def __init__(self, state: PrintState = PrintState.PAUSED) -> None:
        self.state, self.now = SupervisorState(state=state, reason="told"), 10.0
        self.see(Barrier(10.0, broken=False))

    def see(self, *readings: Reading, order: OrderKind | None = None, valid: bool = True) -> str:
        """One step; returns why the order was rejected."""
        zeros, lines = frozen(np.zeros(3)), frozen(np.zeros(4))
        self.now += DT
        estimate = Estimate(self.now, zeros, zeros, zeros, lines, lines, np.zeros(4, np.bool_), lines, valid=valid)
        given = [] if order is None else [Order(order, "anna", self.now)]
        frame = SensorFrame(self.now, readings)
        return "".join(e.refusal for e in supervisor.step(LIMITS, self.state, frame, estimate, orders=given).orders)

    def watch(self, seconds: float, *, broken: bool, valid: bool = True) -> None:
        for _ in range(round(seconds / DT)):
            self.see(Barrier(self.now + DT, broken), valid=valid)


def examined(order: Order, now: float, state: OrderState | None = None, **more: float) -> str:
    kinds = (PrintState.TENSIONING, PrintState.HOMING)
    (found,) = orders.examine(plan().manual, state or OrderState(), (order,), now, known=True, procedures=kinds, **more)
    return found.refusal


ARGUMENTS = {
    OrderKind.JOG: {"velocity": (0.1, 0.0, 0.0)},
    OrderKind.GO_TO: {"position": (0.0, 0.0, 1.0)},
    OrderKind.OVERRIDE: {"share": (1.0,)},
}


@pytest.mark.parametrize("age", [1.01, 12.0, 3600.0])
@pytest.mark.parametrize("kind", OrderKind)
def test_an_old_order_is_rejected_unless_it_stops(kind: OrderKind, age: float) -> None:
    refusal = examined(Order(kind, "anna", 5000.0 - age, ARGUMENTS.get(kind, {})), 5000.0)
    assert refusal == "" if kind in CALMING else "ago" in refusal


@pytest.mark.parametrize("kind", sorted(set(OrderKind) - {OrderKind.JOG}))
def test_a_young_order_is_obeyed_and_a_long_step_makes_none_old(kind: OrderKind) -> None:
    arguments = ARGUMENTS.get(kind, {})
    assert examined(Order(kind, "anna", 99.5, arguments), 100.0) == ""
    assert examined(Order(kind, "anna", 95.0, arguments), 100.0, step=5.0) == ""


def test_a_jog_of_the_future_lasts_no_longer_than_one_of_now() -> None:
    state = OrderState()
    assert examined(Order(OrderKind.JOG, "anna", 1e9, ARGUMENTS[OrderKind.JOG]), 100.0, state) == ""
    assert examined(Order(OrderKind.JOG, "anna", 100.1, ARGUMENTS[OrderKind.JOG]), 100.1, state) == ""


def test_a_jog_that_was_overtaken_is_rejected() -> None:
    state, still = OrderState(), {"velocity": (0.0, 0.0, 0.0)}
    assert examined(Order(OrderKind.JOG, "anna", 100.0, still), 100.0, state) == ""
    late = Order(OrderKind.JOG, "anna", 99.95, ARGUMENTS[OrderKind.JOG])
    assert "newer order" in examined(late, 100.01, state)


WAITS = {
    PrintState.PAUSED: OrderKind.RESUME,
    PrintState.STOPPED: OrderKind.RESUME,
    PrintState.REFILLING: OrderKind.REFILLED,
}


@pytest.mark.parametrize("state", WAITS)
def test_a_pause_withdraws_what_waits(state: PrintState) -> None:
    floor = Floor(state)
    floor.watch(0.2, broken=True)
    assert floor.see(order=WAITS[state]) == ""
    assert floor.see(order=OrderKind.PAUSE) == ""
    floor.watch(60.0, broken=False)
    assert floor.state.state is state


@pytest.mark.parametrize("state", WAITS)
@pytest.mark.parametrize("blocked", [0.5, 1.5, 60.0])
def test_what_waits_lives_as_long_as_an_order_and_says_why_it_ended(state: PrintState, blocked: float) -> None:
    floor = Floor(state)
    floor.watch(0.2, broken=True)
    assert floor.see(order=WAITS[state]) == ""
    floor.watch(blocked, broken=True)
    floor.watch(5.0, broken=False)
    assert floor.state.state is (PrintState.READY if blocked < ORDER_LIFE else state)
    assert blocked < ORDER_LIFE or "somebody is in the light barrier" in floor.state.reason
    assert not floor.state.resume_ordered


def test_a_pause_keeps_a_print_paused_whose_position_is_found_again() -> None:
    floor = Floor(PrintState.PRINTING)
    floor.see(Barrier(floor.now, broken=False), valid=False)
    assert floor.state.state is PrintState.PAUSED
    assert floor.see(order=OrderKind.PAUSE) == ""
    floor.watch(60.0, broken=False)
    assert floor.state.state is PrintState.PAUSED


def test_who_comes_while_the_position_is_lost_has_to_be_gone_and_somebody_to_order_it() -> None:
    floor = Floor(PrintState.PRINTING)
    floor.watch(1.0, broken=False, valid=False)
    floor.watch(10.0, broken=True)
    floor.watch(60.0, broken=False)
    assert (floor.state.state, floor.state.reason) == (PrintState.PAUSED, "somebody is in the light barrier")


@pytest.mark.parametrize("lag", [0.01, 0.2, 5.0])
def test_a_clear_reading_that_was_overtaken_beats_no_broken_one(lag: float) -> None:
    floor = Floor(PrintState.PRINTING)
    for _ in range(40):
        now = floor.now + DT
        floor.see(Barrier(now, broken=True), Barrier(now - lag, broken=False))
    assert floor.state.state is PrintState.PAUSED
    assert floor.see(order=OrderKind.RESUME) == ""
    floor.watch(0.2, broken=True)
    assert floor.state.state is PrintState.PAUSED


@pytest.mark.parametrize("time", [9.99, 10.02, 1e9, math.inf, math.nan])
def test_one_reading_that_is_repeated_shows_nothing_after_its_timeout(time: float) -> None:
    floor = Floor(PrintState.PRINTING)
    for _ in range(round((TIMEOUT + 0.2) / DT)):
        floor.see(Barrier(time, broken=False))
    assert (floor.state.state, floor.state.reason) == (PrintState.PAUSED, "no reading of the light barrier")


def test_readings_that_are_all_late_by_more_than_the_timeout_show_nothing() -> None:
    floor = Floor(PrintState.PRINTING)
    for _ in range(40):
        floor.see(Barrier(floor.now - 2.0, broken=False))
    assert floor.state.state is PrintState.PAUSED


def test_somebody_in_the_barrier_is_believed_whatever_the_time_says() -> None:
    floor = Floor(PrintState.PRINTING)
    floor.see(Barrier(1e9, broken=True))
    assert floor.state.state is PrintState.PAUSED
    floor.see(Barrier(floor.now - 0.2, broken=False), order=OrderKind.RESUME)
    assert floor.state.state is PrintState.PAUSED


def test_the_rule_of_times() -> None:
    times = ReadingTimes()
    rows = [
        (1.0, 1.0, "NEW"), (1.0, 1.1, "OLD"), (0.9, 1.2, "OLD"), (5.0, 1.3, "AHEAD"), (5.0, 1.4, "OLD"),
        (1.4, 1.4, "NEW"), (math.nan, 1.5, "AHEAD"), (7.0, 2.0, "AHEAD"),
        (5.0, 6.0, "OLD"), (4.9, 6.0, "AHEAD"), (4.9, 6.0, "OLD"), (6.0, 6.0, "NEW"), (6.5, 6.5, "NEW"),
        (7.0, 7.1, "OLD"), (7.1, 7.1, "NEW"),
    ]  # fmt: skip
    assert [times.judge("a", time, now).name for time, now, _ in rows] == [name for *_, name in rows]
    assert times.judge("b", 0.5, 6.0) is Timeliness.NEW
    assert (times.last("a"), times.last("c", 3.0)) == (7.1, 3.0)


def test_one_winch_by_hand_needs_tensions_of_now() -> None:
    jog = WinchJog(WinchJogSettings(0, 2, -0.05, 100.0, 0.05))
    jog.begin(0.0)
    ends = []
    for k in range(100):
        jog.lease()
        now = 0.01 * (k + 1)
        reading = Tensions("load_cells", min(now, 0.2), frozen([10.0, 10.0]))  # repeated from 0.2 s on
        ends.append(jog.step(SensorFrame(now, (reading,)), None, 0.01).failure)  # type: ignore[arg-type]
    assert "no tension of the line" in ends[-1]
    assert ends[60] == ""


CORNERS = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]


def operated() -> tuple[Printer, Shaken]:
    """A loop that is enabled, on a machine on which nothing goes wrong."""
    machine = Shaken(np.random.default_rng(0), calm=True)
    printer = Printer(plan(), machine, lambda _place, _radii: Followed(machine))
    printer.step()
    for kind in (OrderKind.RESET, OrderKind.ENABLE):
        printer.step((Order(kind, "anna", printer.time),))
    return printer, machine


def test_by_hand_it_goes_to_all_corners_with_pauses_between() -> None:
    """Each motion begins far from where the last one began, by a jog that is held, let go, and held again."""
    printer, machine = operated()
    settings = plan().manual
    low, high = np.array(settings.min_position), np.array(settings.max_position)
    for corner in CORNERS:
        goal = low + 0.3 + (high - low - 0.6) * np.array(corner)
        step = printer.step((Order(OrderKind.GO_TO, "anna", printer.time, {"position": tuple(goal.tolist())}),))
        assert [order.refusal for order in step.orders] == [""]
        for _ in range(2000):
            step = printer.step()
            assert step.progress.state in (PrintState.MANUAL, PrintState.IDLE), step.progress.reason
            if step.progress.state is PrintState.IDLE:
                break
        assert step.progress.reason == ""
        assert np.linalg.norm(machine.pose - goal) < 0.05
        for _ in range(2):
            before = machine.pose.copy()
            way = tuple((0.1 * np.sign(0.5 - np.array(corner))).tolist())
            for _ in range(20):
                printer.step((Order(OrderKind.JOG, "anna", printer.time, {"velocity": way}),))
            for _ in range(40):
                step = printer.step()
            assert step.progress.state is PrintState.IDLE, step.progress.reason
            assert np.linalg.norm(machine.pose - before) > 0.1


def test_a_print_begins_from_wherever_it_was_moved_by_hand() -> None:
    printer, machine = operated()
    goal = {"position": tuple((machine.pose + np.array([0.5, 0.4, 0.3])).tolist())}
    printer.step((Order(OrderKind.GO_TO, "anna", printer.time, goal),))
    while printer.step().progress.state is PrintState.MANUAL:
        pass
    printer.step((Order(OrderKind.START, "anna", printer.time),))
    states = [printer.step().progress for _ in range(300)]
    assert {each.state for each in states} >= {PrintState.READY, PrintState.PRINTING}
    assert PrintState.STOPPED not in {each.state for each in states}


@pytest.mark.parametrize("state", WAITS)
def test_what_waits_has_ended_if_the_step_in_which_the_way_gets_free_comes_late(state: PrintState) -> None:
    floor = Floor(state)
    floor.watch(0.2, broken=True)
    assert floor.see(order=WAITS[state]) == ""
    floor.watch(0.5, broken=True)
    floor.now += 0.6  # the control hangs, and the barrier is clear again
    floor.watch(DT, broken=False)
    assert floor.state.state is state
    assert not floor.state.resume_ordered
    assert "order it again" in floor.state.reason
