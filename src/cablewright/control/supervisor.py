"""Supervision of a machine and its print: states, limits of the estimate, and orders.

The transitions are in `transitions`; stops by measured limits are in `guard`. A controlled stop slows down along the
path and then holds the winches, so that no line loses its tension. An emergency stop, the guard and every hard limit
end in `PrintState.FAULT`, from which only a reset leads, once its cause is gone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

from cablewright.control.guard import StopCause
from cablewright.control.path_follower import GuideMode, Target
from cablewright.control.stop import StopKind
from cablewright.control.transitions import TRANSITIONS, Event, Happening
from cablewright.foundation.errors import InputError, require_positive
from cablewright.foundation.reading_times import ReadingTimes, Timeliness
from cablewright.foundation.signals import (
    ORDER_LIFE,
    RETRACTION,
    Barrier,
    Condition,
    Estimate,
    Notice,
    Order,
    OrderKind,
    PrintState,
    SensorFrame,
)

NOT_RESET: Final = "not reset since it was started"
FINISHED: Final = "finished"
_POSITION_LOST: Final = "the position is not known"
_BARRIER: Final = "barrier"
_LATE: Final = "nothing is in the way now, but over"
_TURNING: Final = "the winches have not come to rest"


@dataclass(frozen=True, eq=False)
class SupervisorSettings:
    """Limits by the estimate. Lengths in m, times in s.

    ``min_position``, ``max_position``: (3,) of the platform. ``max_speed``: m/s, of the platform. ``max_excess``: m, of
    any line. ``max_error``: m, from the target. ``barrier_timeout``: s without a reading of the light barrier; None: no
    barrier. ``settling_time``: s for which the position must be valid before the platform moves.
    ``position_timeout``: s without a valid position before a fault. ``refill_mass``: kg of powder at which to refill.
    ``stall_timeout``: s for which a motor may fail to pull its load. ``tensioning_timeout``: s after which a path
    begins although the lines do not have the chosen tensions.
    """

    min_position: tuple[float, float, float]
    max_position: tuple[float, float, float]
    max_speed: float
    max_excess: float = 0.3
    max_error: float = 0.15
    barrier_timeout: float | None = None
    settling_time: float = 3.0
    position_timeout: float = 60.0
    refill_mass: float = 0.2
    stall_timeout: float = 2.0
    tensioning_timeout: float = 30.0

    def __post_init__(self) -> None:
        """Raise `InputError` for limits that are not positive and finite, and for an empty range of positions."""
        timeouts = ("settling_time", "position_timeout", "stall_timeout", "tensioning_timeout")
        require_positive(**{name: getattr(self, name) for name in ("max_speed", "max_excess", "max_error", *timeouts)})
        if not all(low < high for low, high in zip(self.min_position, self.max_position, strict=True)):
            raise InputError(
                f"limits of the position: {self.min_position} to {self.max_position} m: each minimum "
                f"must be below its maximum"
            )


@dataclass(eq=False)
class SupervisorState:
    """State of the supervisor, changed in place by `step`. It begins with a fault: nothing moves before a reset."""

    SAVED = ("barrier_stops", "refills", "finished")

    state: PrintState = PrintState.FAULT
    reason: str = NOT_RESET
    state_start: float = -math.inf  # s
    first_frame_time: float = math.inf  # s
    finished: bool = False
    valid_since: float = math.nan  # s: start of the valid position; NaN: not valid
    last_valid_time: float = -math.inf  # s: of the last valid position
    barrier_times: ReadingTimes = field(default_factory=ReadingTimes)
    barrier_broken: bool = False
    stalled_since: float = math.nan
    resume_ordered: bool = False  # waits until the winches stand and the barrier is clear, for at most `ORDER_LIFE`
    resume_time: float = math.inf  # s, of that order ...
    resume_taken: float = math.inf  # ... and when it was taken
    reset_before: bool = False  # a reset was ordered in the last step: it is held
    barrier_stops: int = 0
    refills: int = 0

    def after_load(self) -> None:
        """Record that a print was finished before."""
        if self.finished:
            self.reason = FINISHED

    @property
    def is_new(self) -> bool:
        """Whether the machine has never been reset."""
        return self.state is PrintState.FAULT and self.reason == NOT_RESET


class Verdict(NamedTuple):
    """Permissions of the supervisor for the next step: to move, to print, to stop."""

    state: PrintState
    reason: str
    guide_mode: GuideMode
    hold_winches: bool  # overriding the controller
    valve_allowed: bool  # whether the valve may be open
    orders: tuple[Order, ...]  # those given, with why one was rejected
    stop: StopKind | None  # how the winches are to stop now


class _Inputs(NamedTuple):
    now: float
    estimate: Estimate
    target: Target | None
    powder: float
    conditions: frozenset[Condition]
    cause: StopCause | None
    standing: bool
    stopped: bool


def step(
    settings: SupervisorSettings,
    state: SupervisorState,
    frame: SensorFrame,
    estimate: Estimate,
    *,
    cause: StopCause | None = None,
    standing: bool = True,
    stopped: bool = True,
    target: Target | None = None,
    powder: float = math.inf,
    orders: Iterable[Order] = (),
) -> Verdict:
    """Judge one step of control: return whether the machine may move, print or must stop; *state* changes in place.

    *cause*: why the guard demands a stop, if it does. *standing*: whether the winches are commanded to stand;
    *stopped*: whether they have been for as long as a stop takes. *target*: target of the last step. *powder*:
    estimated powder in the drum, kg. *orders* that are already rejected change nothing.
    """
    now, before = frame.time, state.state
    _update_readings(state, frame, estimate)
    conditions = _NOTHING
    if frame.notices:
        seen = (notice.condition for notice in frame.notices if notice != _BEAM_END)  # a retraction may be at its end
        conditions = frozenset(seen)
    inputs = _Inputs(now, estimate, target, powder, conditions, cause, standing, stopped)
    given = tuple(orders)
    answered = tuple(
        [
            order if order.refusal else replace(order, refusal=_apply_order(settings, state, order, inputs))
            for order in given
        ]
    )
    state.reset_before = OrderKind.RESET in [order.kind for order in given]
    if state.state is not before:
        inputs = inputs._replace(target=None)  # a target is judged in the state for which it was made
    danger = cause or _hard_limit(settings, state, inputs)
    if danger is not None:
        if state.state is not PrintState.FAULT:
            _happen(state, Happening.DANGER, now, danger.reason)
    elif state.state in _RUNNING:
        _check_running(settings, state, inputs)
    elif state.state in _HANDLED:
        _check_handled(settings, state, inputs)
    elif state.reason == _POSITION_LOST and (why := _person(settings, state, now)):
        _happen(state, Happening.PERSON, now, why)  # from now on it takes an order
    _advance(settings, state, inputs)
    at_rest = target is None or (target.path_speed == 0.0 and not any(target.velocity.tolist()))
    mode = _MODES.get(state.state, GuideMode.HOLD)
    if state.state is PrintState.READY and not _is_settled(settings, state, now):
        mode = GuideMode.HOLD
    elif _is_calm(settings, state, inputs):
        mode = GuideMode.PAUSE
    off = state.state in (PrintState.FAULT, PrintState.OFF)
    stays = mode in (GuideMode.HOLD, GuideMode.PAUSE)
    hold = off or (stays and at_rest and state.state not in _HANDLED)
    valve = state.state not in _SHUT
    kind = danger.kind if danger is not None else StopKind.RAMP if state.state is PrintState.FAULT else None
    return Verdict(state.state, state.reason, mode, hold, valve, answered, kind)


_NOTHING: Final = frozenset[Condition]()
_BEAM_END: Final = Notice(Condition.DRUM_END, RETRACTION)
_KEEPING: Final = (PrintState.REFILLING, PrintState.STOPPED)  # keep their reason where a pause is ordered
_RUNNING: Final = (PrintState.READY, PrintState.PRINTING)
_HANDLED: Final = (PrintState.TENSIONING, PrintState.HOMING, PrintState.MANUAL)
_SHUT: Final = (PrintState.FAULT, PrintState.READY, PrintState.OFF, *_HANDLED)
_LIMITED: Final = (*_RUNNING, PrintState.PAUSED, PrintState.REFILLING, PrintState.STOPPED)
_MODES = {PrintState.PRINTING: GuideMode.FOLLOW, PrintState.READY: GuideMode.APPROACH}


def _update_readings(state: SupervisorState, frame: SensorFrame, estimate: Estimate) -> None:
    state.first_frame_time = min(state.first_frame_time, frame.time)
    for reading in frame.readings:
        if not isinstance(reading, Barrier):
            continue
        timeliness = state.barrier_times.judge(_BARRIER, reading.time, frame.time)
        if timeliness is Timeliness.NEW:
            state.barrier_broken = reading.broken
        elif timeliness is Timeliness.AHEAD and reading.broken:  # as of now; a clear one shows nothing
            state.barrier_broken = True
            state.barrier_times.judge(_BARRIER, frame.time, frame.time)
    if estimate.valid:
        state.last_valid_time = frame.time
        if math.isnan(state.valid_since):
            state.valid_since = frame.time
    else:
        state.valid_since = math.nan
    stalled = bool(frame.notices) and any(notice.condition is Condition.STALLED for notice in frame.notices)
    if not stalled:
        state.stalled_since = math.nan
    elif math.isnan(state.stalled_since):
        state.stalled_since = frame.time


def _apply_order(settings: SupervisorSettings, state: SupervisorState, order: Order, inputs: _Inputs) -> str:
    """Apply an order. Returns why it is rejected; an empty text: it is obeyed."""
    current, kind, now = state.state, order.kind, inputs.now
    if kind is OrderKind.OVERRIDE:
        return ""  # changes no state
    if kind is OrderKind.RESET and current is PrintState.FAULT and (why := _no_reset(state, order, inputs)):
        return f"reset: {why}"
    waits = kind is OrderKind.RESUME and current in (PrintState.PAUSED, PrintState.STOPPED)
    if waits or (kind is OrderKind.REFILLED and current is PrintState.REFILLING):
        state.resume_ordered, state.resume_time, state.resume_taken = True, order.time, now
        return ""
    if (current, kind) not in TRANSITIONS:
        return f"{kind}: has no effect while the state is {current}"
    if kind in _FROM_REST and current is not PrintState.MANUAL and not inputs.standing:
        return f"{kind}: {_TURNING}"
    if kind in MOVING and (why := _person(settings, state, now)):
        return f"{kind}: {why}"
    if kind is OrderKind.START:
        state.finished = False
    reason = state.reason if kind is OrderKind.PAUSE and current in _KEEPING else _REASONS.get(kind, "")
    _happen(state, kind, now, reason)
    return ""


MOVING: Final = (
    OrderKind.START,
    OrderKind.JOG,
    OrderKind.GO_TO,
    OrderKind.PARK,
    OrderKind.TAKE_UP,
    OrderKind.HOME,
)
"""Orders after which the machine may move immediately."""

_FROM_REST: Final = (*MOVING, OrderKind.RELEASE, OrderKind.RESET)
_REASONS: Final = {
    OrderKind.EMERGENCY: "emergency stop",
    OrderKind.RESET: "reset",
    OrderKind.PAUSE: "paused by order",
    OrderKind.STOP: "stopped by order",
}


def _no_reset(state: SupervisorState, order: Order, inputs: _Inputs) -> str:
    """Why a fault cannot be reset now: its cause, or another one, stands; the stop is not at its end; or no edge."""
    if inputs.cause is not None:
        return inputs.cause.reason
    if not inputs.stopped:
        return "the stop is not at its end"
    if state.reset_before:
        return "it is held"
    late = inputs.now > state.state_start and order.time >= state.state_start
    return "" if late else "it was ordered before the stop"


def _hard_limit(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> StopCause | None:
    """Return the reason to stop the machine by the estimate, in states in which it could move; or None."""
    if state.state not in _LIMITED:
        return None
    now, estimate = inputs.now, inputs.estimate
    if not estimate.valid:
        waited = now - max(state.last_valid_time, state.state_start)
        if state.state is not PrintState.REFILLING and waited > settings.position_timeout:
            return _stop(f"the position has not been known for over {settings.position_timeout:g} s")
        return None
    x = estimate.position.tolist()
    for axis, low, at, high in zip("xyz", settings.min_position, x, settings.max_position, strict=True):
        if not low <= at <= high:
            return _stop(f"{axis} = {at:.3f} m is outside {low:g} to {high:g} m")
    speed = math.hypot(*estimate.velocity.tolist())
    if speed > settings.max_speed:
        return _stop(f"the platform moves at {speed:.3f} m/s; at most {settings.max_speed:g} is allowed")
    return None


def _stop(reason: str) -> StopCause:
    return StopCause(reason)


def _person(settings: SupervisorSettings, state: SupervisorState, now: float) -> str:
    """Whether the light barrier forbids motion: the reason, or an empty text."""
    if settings.barrier_timeout is None:
        return ""
    if state.barrier_broken:
        return "somebody is in the light barrier"
    age = now - state.barrier_times.last(_BARRIER, state.first_frame_time)
    return "no reading of the light barrier" if age > settings.barrier_timeout else ""


def _check_running(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> None:
    """Leave a state in which the machine moves if there is a reason to stop."""
    now = inputs.now
    if reason := _person(settings, state, now):
        state.barrier_stops += 1
        _happen(state, Happening.PERSON, now, reason)
        return
    if not inputs.estimate.valid and state.state is PrintState.PRINTING:
        _happen(state, Happening.POSITION_LOST, now, _POSITION_LOST)
        return
    if inputs.powder <= settings.refill_mass or Condition.POWDER_OUT in inputs.conditions:
        state.refills += 1
        reason = "no powder is left" if Condition.POWDER_OUT in inputs.conditions else "little powder is left"
        _happen(state, Happening.POWDER_LOW, now, reason)
        return
    if reason := _soft_limit(settings, state, inputs):
        _happen(state, Happening.SOFT_LIMIT, now, reason)


def _check_handled(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> None:
    """Leave a procedure, or a motion by hand, if there is a reason to stop."""
    now = inputs.now
    if reason := _person(settings, state, now):
        _happen(state, Happening.PERSON, now, reason)
    elif reason := _winch_limit(settings, state, inputs):
        _happen(state, Happening.SOFT_LIMIT, now, reason)
    elif state.state is PrintState.MANUAL and not inputs.estimate.valid:
        _happen(state, Happening.POSITION_LOST, now, _POSITION_LOST)
    elif state.state is PrintState.MANUAL and (reason := _target_limit(settings, inputs)):
        _happen(state, Happening.SOFT_LIMIT, now, reason)


def _target_limit(settings: SupervisorSettings, inputs: _Inputs) -> str:
    """Whether the platform is too far from its target, or that is unknown: the reason, or an empty text."""
    if inputs.target is None:
        return ""
    distance = math.dist(inputs.target.position.tolist(), inputs.estimate.position.tolist())
    if distance <= settings.max_error:
        return ""
    return f"the platform is {distance:.3f} m from its target; at most {settings.max_error:g} is allowed"


def _soft_limit(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> str:
    """Return the reason for a controlled stop, or an empty text."""
    if reason := _winch_limit(settings, state, inputs):
        return reason
    if inputs.target is not None and inputs.estimate.valid:
        if reason := _target_limit(settings, inputs):
            return reason
        excess = max([each for each in inputs.estimate.excess.tolist() if each == each], default=-math.inf)  # not NaN
        if excess > settings.max_excess:
            return f"a line is {excess:.3f} m too long; at most {settings.max_excess:g} is allowed"
    return ""


def _winch_limit(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> str:
    """Return what keeps a winch from moving on, or an empty text."""
    if inputs.now - state.stalled_since > settings.stall_timeout:
        return f"a motor cannot pull its load for over {settings.stall_timeout:g} s"
    return "a winch drum is empty or full" if Condition.DRUM_END in inputs.conditions else ""


def _is_settled(settings: SupervisorSettings, state: SupervisorState, now: float) -> bool:
    return now - state.valid_since >= settings.settling_time


def _is_calm(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> bool:
    """Whether a pause that was ordered, or a refill, may take the time to come to rest without a swing."""
    planned = state.state is PrintState.PAUSED and state.reason == _REASONS[OrderKind.PAUSE]
    if not planned and state.state is not PrintState.REFILLING:
        return False
    return not (_person(settings, state, inputs.now) or _soft_limit(settings, state, inputs))


def _advance(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> None:
    """Leave a state whose condition is met."""
    now, target = inputs.now, inputs.target
    if state.state is PrintState.READY and target is not None and target.arrived and _is_settled(settings, state, now):
        _happen(state, Happening.ARRIVED, now, "")
    elif state.state is PrintState.PRINTING and target is not None and target.finished:
        state.finished = True
        _happen(state, Happening.PATH_END, now, FINISHED)
    found = state.state is PrintState.PAUSED and state.reason == _POSITION_LOST and _is_settled(settings, state, now)
    obstacle = _person(settings, state, now) or ("" if inputs.standing else _TURNING)
    too_old = state.resume_ordered and now > state.resume_taken and now - state.resume_time > ORDER_LIFE
    if found or (state.resume_ordered and not obstacle and not too_old):
        _happen(state, Happening.MAY_RESUME, now, "")
    elif too_old:
        state.resume_ordered = False
        state.reason = f"{obstacle or _LATE} {ORDER_LIFE:g} s after it was ordered to go on: order it again"


def fail(state: SupervisorState, now: float, reason: str) -> None:
    """Record a danger that the control itself has found: the state becomes a fault."""
    _happen(state, Happening.DANGER, now, reason)


def explain(state: SupervisorState, was: str, reason: str) -> None:
    """Replace the reason *was* of a fault by a more exact one."""
    if state.state is PrintState.FAULT and state.reason == was:
        state.reason = reason


def end_procedure(state: SupervisorState, now: float, failure: str = "") -> None:
    """Record that a procedure, or a motion by hand, is done, or why it failed."""
    _happen(state, Happening.FAILED if failure else Happening.DONE, now, failure)


def _happen(state: SupervisorState, event: Event, now: float, reason: str) -> None:
    """Enter the state that follows an event, if the table has one."""
    then = TRANSITIONS.get((state.state, event))
    if then is not None:
        state.state, state.reason, state.state_start, state.resume_ordered = then, reason, now, False
