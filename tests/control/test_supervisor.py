"""Each state ends as it should, each limit stops the machine, and nothing goes on by itself beside a person."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.control import supervisor
from cablewright.control.guard import StopCause
from cablewright.control.path_follower import GuideMode, Target
from cablewright.control.stop import StopKind
from cablewright.control.supervisor import SupervisorSettings, SupervisorState, Verdict
from cablewright.control.transitions import TRANSITIONS, Happening
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    Barrier,
    Condition,
    Estimate,
    Notice,
    Order,
    OrderKind,
    PrintState,
    Reading,
    SensorFrame,
    frozen,
)

LIMITS = SupervisorSettings((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), 0.2, barrier_timeout=0.5)
OVER = StopCause("line 2 pulls 1200 N; at most 1000 is allowed", StopKind.HOLD)
SWITCHED_ON = (OrderKind.RESET, OrderKind.ENABLE)
PLACE = np.array([0.1, 0.2, 1.0])
DT = 0.1


def believed(now: float, **changes: Any) -> Estimate:
    zeros, lines = frozen(np.zeros(3)), frozen(np.zeros(4))
    made = Estimate(now, frozen(PLACE), zeros, zeros, lines, lines, np.zeros(4, dtype=np.bool_), lines)
    return replace(made, **changes)


def aimed(
    position: np.ndarray = PLACE, path_speed: float = 0.03, *, arrived: bool = True, finished: bool = False
) -> Target:
    return Target(position, np.array([path_speed, 0.0, 0.0]), 1.0, 0, path_speed, True, arrived, finished)


class Floor:
    """A machine about which everything is well unless a step says otherwise."""

    def __init__(self, settings: SupervisorSettings = LIMITS) -> None:
        self.settings, self.state, self.now, self.broken = settings, SupervisorState(), 0.0, False
        self.pace = 0.03

    def go(self, steps: int = 1, *orders: OrderKind, dark: bool = False, **changes: Any) -> Verdict:
        for _ in range(steps):
            self.now += DT
            readings: list[Reading] = [] if dark else [Barrier(self.now, self.broken)]
            notices = tuple(Notice(each) for each in changes.get("conditions", ()))
            estimate = believed(self.now, **changes.get("estimate", {}))
            given = {key: changes[key] for key in ("cause", "powder", "standing", "stopped") if key in changes}
            given["target"] = changes.get("target", aimed(path_speed=self.pace))
            frame = SensorFrame(self.now, tuple(readings), notices)
            told = [Order(each, "anna", self.now) for each in orders]
            verdict = supervisor.step(self.settings, self.state, frame, estimate, orders=told, **given)
            orders = ()
        return verdict


@pytest.fixture
def floor() -> Floor:
    """One that prints."""
    made = Floor()
    made.go(1, *SWITCHED_ON, OrderKind.START)
    assert made.go(40).state is PrintState.PRINTING
    return made


def test_it_begins_with_a_fault_and_moves_only_once_the_position_is_known() -> None:
    made = Floor()
    new = made.go(50)
    assert (new.state, new.guide_mode, new.hold_winches) == (PrintState.FAULT, GuideMode.HOLD, True)
    assert "not reset" in new.reason
    assert made.go(1, OrderKind.START).orders[0].refusal == "start: has no effect while the state is fault"
    assert made.go(1, *SWITCHED_ON).state is PrintState.IDLE
    lost = {"estimate": {"valid": False}}
    waiting = made.go(20, OrderKind.START, **lost)
    assert (waiting.state, waiting.guide_mode) == (PrintState.READY, GuideMode.HOLD)
    assert made.go(20, target=aimed(arrived=False)).guide_mode is GuideMode.HOLD
    assert made.go(20, target=aimed(arrived=False)).guide_mode is GuideMode.APPROACH
    assert made.go().state is PrintState.PRINTING


def test_a_pause_by_order_is_without_a_swing_and_any_other_stop_immediate(floor: Floor) -> None:
    assert floor.go(1, OrderKind.PAUSE).guide_mode is GuideMode.PAUSE
    floor.broken = True
    assert floor.go().guide_mode is GuideMode.HOLD  # somebody comes while it slows down
    floor.broken = False
    assert floor.go().guide_mode is GuideMode.PAUSE
    far = aimed(PLACE + np.array([0.0, 0.2, 0.0]))
    assert floor.go(target=far).guide_mode is GuideMode.HOLD
    assert floor.go(1, OrderKind.STOP).guide_mode is GuideMode.HOLD
    assert floor.go(target=aimed(path_speed=0.0)).hold_winches


def test_a_pause_holds_the_winches_at_its_end_and_a_refill_is_one(floor: Floor) -> None:
    assert floor.go(1, powder=0.1).state is PrintState.REFILLING
    slowing, standing = (
        floor.go(powder=0.1),
        floor.go(powder=0.1, target=aimed(path_speed=0.0)._replace(velocity=np.zeros(3))),
    )
    assert (slowing.guide_mode, slowing.hold_winches) == (GuideMode.PAUSE, False)
    assert standing.hold_winches


def test_a_broken_barrier_pauses_until_it_is_clear_and_somebody_orders_it(floor: Floor) -> None:
    floor.broken = True
    paused = floor.go()
    assert (paused.state, paused.guide_mode, paused.hold_winches) == (PrintState.PAUSED, GuideMode.HOLD, False)
    floor.pace = 0.0
    assert floor.go(target=aimed(path_speed=0.0)).hold_winches
    assert floor.go(1, OrderKind.RESUME).state is PrintState.PAUSED
    assert floor.go(5).state is PrintState.PAUSED
    floor.broken = False
    assert floor.go().state is PrintState.READY  # the order was given
    assert floor.state.barrier_stops == 1
    assert floor.go(2).state is PrintState.PRINTING


def test_a_clear_barrier_alone_moves_nothing(floor: Floor) -> None:
    floor.broken = True
    floor.go()
    floor.broken = False
    assert floor.go(1000).state is PrintState.PAUSED


def test_a_barrier_that_is_not_heard_pauses(floor: Floor) -> None:
    verdict = floor.go(8, dark=True)
    assert verdict.state is PrintState.PAUSED
    assert "no reading of the light barrier" in verdict.reason


@pytest.mark.parametrize(("powder", "conditions"), [(0.1, ()), (5.0, (Condition.POWDER_OUT,))])
def test_a_drum_that_is_empty_is_refilled(floor: Floor, powder: float, conditions: tuple[Condition, ...]) -> None:
    assert floor.go(powder=powder, conditions=conditions).state is PrintState.REFILLING
    floor.broken = True  # who refills it is in the way
    assert floor.go(100, powder=powder).state is PrintState.REFILLING
    assert floor.go(1, OrderKind.REFILLED).state is PrintState.REFILLING
    floor.broken = False
    assert floor.go().state is PrintState.READY
    assert floor.state.refills == 1


def test_a_position_that_is_lost_and_found_needs_no_order(floor: Floor) -> None:
    lost = floor.go(20, estimate={"valid": False})
    assert (lost.state, lost.reason) == (PrintState.PAUSED, "the position is not known")
    assert floor.go(20).state is PrintState.PAUSED
    assert floor.go(20).state in (PrintState.READY, PrintState.PRINTING)


def test_a_position_that_stays_lost_is_a_fault(floor: Floor) -> None:
    verdict = floor.go(700, estimate={"valid": False})
    assert verdict.state is PrintState.FAULT
    assert verdict.hold_winches


HARD = {
    "outside": {"estimate": {"position": frozen([1.5, 0.0, 1.0])}},
    "moves at": {"estimate": {"velocity": frozen([0.0, 0.3, 0.0])}},
    "pulls": {"cause": OVER},
}


@pytest.mark.parametrize("says", HARD)
def test_a_hard_limit_stops_immediately_and_stays(floor: Floor, says: str) -> None:
    verdict = floor.go(**HARD[says])
    assert verdict.state is PrintState.FAULT
    assert verdict.hold_winches
    assert not verdict.valve_allowed
    assert says in verdict.reason
    assert verdict.stop is (StopKind.HOLD if says == "pulls" else StopKind.RAMP)
    assert floor.go(50, OrderKind.RESUME).state is PrintState.FAULT
    assert floor.go(1, OrderKind.RESET).state is PrintState.OFF
    assert floor.go(1, OrderKind.ENABLE).state is PrintState.IDLE


def test_a_fault_is_reset_only_without_its_cause_and_after_the_stop(floor: Floor) -> None:
    """The guard's cause stands, the winches still turn, and an order that comes with the stop itself is too early."""
    assert floor.go(1, OrderKind.EMERGENCY, OrderKind.RESET).state is PrintState.FAULT
    for changes, why in (({"cause": OVER}, "pulls 1200 N"), ({"stopped": False}, "not at its end")):
        floor.go()
        refused = floor.go(1, OrderKind.RESET, **changes)
        assert refused.state is PrintState.FAULT
        assert why in refused.orders[0].refusal
    held = floor.go(1, OrderKind.RESET)
    assert held.orders[0].refusal == "reset: it is held"
    floor.go()
    assert floor.go(1, OrderKind.RESET).state is PrintState.OFF


def test_a_reset_from_before_the_stop_is_none(floor: Floor) -> None:
    floor.go(1, cause=OVER)
    frame = SensorFrame(floor.now + DT, (Barrier(floor.now + DT, broken=False),))
    told = [Order(OrderKind.RESET, "anna", floor.now - DT)]
    refused = supervisor.step(floor.settings, floor.state, frame, believed(floor.now + DT), orders=told)
    assert refused.orders[0].refusal == "reset: it was ordered before the stop"


@pytest.mark.parametrize("order", [OrderKind.START, OrderKind.JOG, OrderKind.TAKE_UP, OrderKind.HOME])
def test_nothing_begins_to_move_beside_a_person_or_before_it_stands(order: OrderKind) -> None:
    made = Floor()
    made.go(1, *SWITCHED_ON)
    assert "rest" in made.go(1, order, standing=False).orders[0].refusal
    made.go(20, dark=True)
    assert made.go(1, order, dark=True).orders[0].refusal == f"{order}: no reading of the light barrier"
    made.broken = True
    assert made.go(1, order).orders[0].refusal == f"{order}: somebody is in the light barrier"


@pytest.mark.parametrize("state", PrintState)
def test_the_guard_is_heard_in_every_state(state: PrintState) -> None:
    made = Floor()
    made.state.state, made.state.reason = state, "told"
    verdict = made.go(1, cause=OVER, estimate={"valid": False})
    assert (verdict.state, verdict.hold_winches) == (PrintState.FAULT, True)
    assert verdict.reason == ("told" if state is PrintState.FAULT else OVER.reason)


@pytest.mark.parametrize("order", OrderKind)
@pytest.mark.parametrize("state", PrintState)
def test_each_order_in_each_state_leads_where_the_table_says(state: PrintState, order: OrderKind) -> None:
    made = Floor()
    made.state.state = state
    quiet = aimed(arrived=False)  # nothing else happens
    verdict = made.go(1, order, target=quiet)
    then = TRANSITIONS.get((state, order), state)
    if (state, order) in WAITING:
        assert (verdict.state, verdict.orders[0].refusal) == (PrintState.READY, "")  # the barrier is clear
        return
    assert verdict.state is then
    known = (state, order) in TRANSITIONS or order is OrderKind.OVERRIDE
    assert verdict.orders[0].refusal == ("" if known else f"{order}: has no effect while the state is {state}")


WAITING = (
    (PrintState.PAUSED, OrderKind.RESUME),
    (PrintState.STOPPED, OrderKind.RESUME),
    (PrintState.REFILLING, OrderKind.REFILLED),
)

HAPPENS: dict[Happening, dict[str, Any]] = {
    Happening.DANGER: {"cause": OVER},
    Happening.SOFT_LIMIT: {"conditions": (Condition.DRUM_END,)},
    Happening.PERSON: {"broken": True},
    Happening.POSITION_LOST: {"estimate": {"valid": False}},
    Happening.POWDER_LOW: {"powder": 0.1},
    Happening.ARRIVED: {"target": aimed()},
    Happening.PATH_END: {"target": aimed(arrived=False, finished=True)},
    Happening.MAY_RESUME: {"resume": True},
    Happening.DONE: {"done": ""},
    Happening.FAILED: {"done": "line 2 does not come"},
}


@pytest.mark.parametrize("happening", Happening)
@pytest.mark.parametrize("state", PrintState)
def test_each_happening_in_each_state_leads_where_the_table_says(state: PrintState, happening: Happening) -> None:
    made = Floor()
    made.go(40)  # the position has settled
    made.state.state, made.state.reason = state, ""
    given = {"target": aimed(arrived=False)} | HAPPENS[happening]
    made.broken = given.pop("broken", False)
    made.state.resume_ordered = given.pop("resume", False)
    if "done" in given:
        supervisor.end_procedure(made.state, made.now, given["done"])
        then = made.state.state
    else:
        then = made.go(1, **given).state
    assert then is TRANSITIONS.get((state, happening), state)


def test_the_page_of_states_is_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/states.md` writes the page."""
    root = Path(__file__).parents[2]
    tool = runpy.run_path(str(root / "tools" / "pages" / "states.py"))
    assert (root / "docs" / "states.md").read_text("utf-8") == tool["page"]()


SOFT = {
    "from its target": {"target": aimed(PLACE + np.array([0.2, 0.0, 0.0]))},
    "too long": {"estimate": {"excess": frozen([0.0, 0.5, np.nan, 0.0])}},
    "a winch drum is empty or full": {"conditions": (Condition.DRUM_END,)},
}


@pytest.mark.parametrize("says", SOFT)
def test_a_soft_limit_is_a_controlled_stop(floor: Floor, says: str) -> None:
    verdict = floor.go(**SOFT[says])
    assert verdict.state is PrintState.STOPPED
    assert verdict.guide_mode is GuideMode.HOLD
    assert not verdict.hold_winches
    assert says in verdict.reason
    assert floor.go(100).state is PrintState.STOPPED
    assert floor.go(1, OrderKind.RESUME).state is PrintState.READY


def test_a_motor_may_stall_for_a_moment(floor: Floor) -> None:
    assert floor.go(15, conditions=(Condition.STALLED,)).state is PrintState.PRINTING
    assert floor.go().state is PrintState.PRINTING
    assert floor.go(25, conditions=(Condition.STALLED,)).state is PrintState.STOPPED


@pytest.mark.parametrize("state", [s for s in PrintState if s is not PrintState.FAULT])
def test_an_emergency_stop_works_in_every_state(state: PrintState) -> None:
    made = Floor()
    made.state.state = state
    verdict = made.go(1, OrderKind.EMERGENCY)
    assert (verdict.state, verdict.hold_winches, verdict.reason) == (PrintState.FAULT, True, "emergency stop")
    assert verdict.stop is StopKind.RAMP  # all winches come to rest together


def test_orders_that_do_not_fit_do_nothing(floor: Floor) -> None:
    for order in (OrderKind.START, OrderKind.RESUME, OrderKind.REFILLED, OrderKind.RESET):
        assert floor.go(1, order).state is PrintState.PRINTING
    assert floor.go(1, OrderKind.PAUSE).reason == "paused by order"
    assert floor.go(1, OrderKind.STOP).reason == "stopped by order"


def test_the_end_of_the_path_is_the_end(floor: Floor) -> None:
    verdict = floor.go(target=aimed(finished=True))
    assert (verdict.state, verdict.reason) == (PrintState.IDLE, "finished")
    assert floor.state.finished


def test_limits_that_limit_nothing_are_rejected() -> None:
    with pytest.raises(InputError, match="max_speed = 0"):
        replace(LIMITS, max_speed=0.0)
    with pytest.raises(InputError, match="below its maximum"):
        replace(LIMITS, max_position=(-1.0, 1.0, 1.0))
