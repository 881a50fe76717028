"""State machine of a print: its states, their transitions, and the limits that stop the machine.

    idle -start-> ready -at the path-> printing -end of path-> idle
    printing -barrier, pause, no position-> paused -resume, barrier clear-> ready
    printing -powder low or out-> refilling -refilled, barrier clear-> ready
    any -a soft limit, stop-> stopped -resume-> ready          any -a hard limit, emergency stop-> fault -reset-> idle

A controlled stop slows down along the path and then holds the winches, so that all lines keep their tension. An
emergency stop and every hard limit hold the winches at once. No state in which a person may be near the machine ends by
itself: resuming needs an order. Only a stop for a lost position ends when the position is valid again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.control.guide import GuideMode, Target
from cablewright.errors import InputError, require_positive
from cablewright.signals import Barrier, Condition, Encoders, Estimate, PrintState, SensorFrame


class Order(Enum):
    """Orders of the operator."""

    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    STOP = "stop"
    REFILLED = "refilled"
    EMERGENCY = "emergency stop"
    RESET = "reset"


@dataclass(frozen=True, eq=False)
class SupervisorSettings:
    """Limits. Lengths in m, times in s.

    ``min_position``, ``max_position``: (3,) of the platform. ``max_speed``: m/s, of the platform. ``max_tensions``:
    (m,) N, at the sheaves, from the estimated lengths. ``max_excess``: m, of any line. ``max_error``: m, from the
    target. ``barrier_timeout``: s without a reading of the light barrier; None: no barrier. ``encoder_timeout``: s
    without counts. ``settling_time``: s for which the position must be valid before the platform moves.
    ``position_timeout``: s without a valid position before a fault. ``refill_mass``: kg of powder at which to refill.
    ``stall_timeout``: s for which a motor may fail to pull its load.
    """

    min_position: tuple[float, float, float]
    max_position: tuple[float, float, float]
    max_speed: float
    max_tensions: Array
    max_excess: float = 0.3
    max_error: float = 0.15
    barrier_timeout: float | None = None
    encoder_timeout: float = 0.5
    settling_time: float = 3.0
    position_timeout: float = 60.0
    refill_mass: float = 0.2
    stall_timeout: float = 2.0

    def __post_init__(self) -> None:
        """Raise `InputError` for limits that are not positive and finite, and for an empty range of positions."""
        timeouts = ("encoder_timeout", "settling_time", "position_timeout", "stall_timeout")
        require_positive(**{name: getattr(self, name) for name in ("max_speed", "max_excess", "max_error", *timeouts)})
        if not all(low < high for low, high in zip(self.min_position, self.max_position, strict=True)):
            raise InputError(f"limits of the position: {self.min_position} to {self.max_position} m is empty")


@dataclass(eq=False)
class SupervisorState:
    """Changed in place by `step`."""

    state: PrintState = PrintState.IDLE
    reason: str = ""
    state_start: float = 0.0  # s
    first_frame_time: float = math.inf  # s
    finished: bool = False
    valid_since: float = math.nan  # s: start of the valid position; NaN: not valid
    last_valid_time: float = -math.inf  # s: of the last valid position
    last_encoder_time: float = -math.inf
    last_barrier_time: float = -math.inf
    barrier_broken: bool = False
    stalled_since: float = math.nan
    resume_ordered: bool = False  # pending until the barrier is clear
    barrier_stops: int = 0
    refills: int = 0


class Verdict(NamedTuple):
    """Permissions for the next step."""

    state: PrintState
    reason: str
    guide_mode: GuideMode
    hold_winches: bool  # at once, overriding the controller
    valve_allowed: bool  # whether the valve may be open


class _Inputs(NamedTuple):
    now: float
    estimate: Estimate
    target: Target | None
    tensions: Array | None
    powder: float
    conditions: frozenset[Condition]


def step(
    settings: SupervisorSettings,
    state: SupervisorState,
    frame: SensorFrame,
    estimate: Estimate,
    *,
    target: Target | None = None,
    tensions: Array | None = None,
    powder: float = math.inf,
    orders: Iterable[Order] = (),
) -> Verdict:
    """Return the verdict for one step; *state* changes in place.

    *target*: of the last step. *tensions* (m,), N, and *powder*, kg: estimates.
    """
    now = frame.time
    _update_readings(state, frame, estimate)
    conditions = frozenset(notice.condition for notice in frame.notices)
    inputs = _Inputs(now, estimate, target, tensions, powder, conditions)
    for order in orders:
        _apply_order(state, order, now)
    hard = _hard_limit(settings, state, inputs)
    if hard and state.state not in (PrintState.FAULT, PrintState.IDLE):
        _enter(state, PrintState.FAULT, now, hard)
    elif state.state in (PrintState.READY, PrintState.PRINTING):
        _check_running(settings, state, inputs)
    _advance(settings, state, inputs)
    at_rest = target is None or (target.path_speed == 0.0 and not target.velocity.any())
    mode = _MODES.get(state.state, GuideMode.HOLD)
    if state.state is PrintState.READY and not _is_settled(settings, state, now):
        mode = GuideMode.HOLD
    hold = state.state is PrintState.FAULT or (mode is GuideMode.HOLD and at_rest)
    valve = state.state is not PrintState.FAULT and state.state is not PrintState.READY
    return Verdict(state.state, state.reason, mode, hold, valve)


_MODES = {PrintState.PRINTING: GuideMode.FOLLOW, PrintState.READY: GuideMode.APPROACH}


def _update_readings(state: SupervisorState, frame: SensorFrame, estimate: Estimate) -> None:
    state.first_frame_time = min(state.first_frame_time, frame.time)
    for reading in frame.readings:
        if isinstance(reading, Encoders):
            state.last_encoder_time = frame.time
        elif isinstance(reading, Barrier):
            state.last_barrier_time, state.barrier_broken = frame.time, reading.broken
    if estimate.valid:
        state.last_valid_time = frame.time
        if math.isnan(state.valid_since):
            state.valid_since = frame.time
    else:
        state.valid_since = math.nan
    stalled = any(notice.condition is Condition.STALLED for notice in frame.notices)
    if not stalled:
        state.stalled_since = math.nan
    elif math.isnan(state.stalled_since):
        state.stalled_since = frame.time


def _apply_order(state: SupervisorState, order: Order, now: float) -> None:
    """Apply an order; one that does not fit the state has no effect."""
    current = state.state
    if order is Order.EMERGENCY:
        _enter(state, PrintState.FAULT, now, "emergency stop")
    elif order is Order.RESET and current is PrintState.FAULT:
        _enter(state, PrintState.IDLE, now, "reset")
    elif order is Order.START and current is PrintState.IDLE:
        state.finished = False
        _enter(state, PrintState.READY, now, "")
    elif order is Order.PAUSE and current in (PrintState.READY, PrintState.PRINTING):
        _enter(state, PrintState.PAUSED, now, "paused by order")
    elif order is Order.STOP and current not in (PrintState.IDLE, PrintState.FAULT):
        _enter(state, PrintState.STOPPED, now, "stopped by order")
    elif (order is Order.RESUME and current in (PrintState.PAUSED, PrintState.STOPPED)) or (
        order is Order.REFILLED and current is PrintState.REFILLING
    ):
        state.resume_ordered = True


def _hard_limit(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> str:
    """Return the reason to stop the machine at once, or an empty text."""
    now, estimate = inputs.now, inputs.estimate
    if now - max(state.last_encoder_time, state.first_frame_time) > settings.encoder_timeout:
        return f"no reading of the encoders for over {settings.encoder_timeout:g} s"
    if Condition.NO_EQUILIBRIUM in inputs.conditions:
        return "the platform is in no equilibrium"
    if not estimate.valid:
        waited = now - max(state.last_valid_time, state.state_start)
        if state.state is not PrintState.REFILLING and waited > settings.position_timeout:
            return f"the position has not been known for over {settings.position_timeout:g} s"
        return ""
    x = estimate.position.tolist()
    for axis, low, at, high in zip("xyz", settings.min_position, x, settings.max_position, strict=True):
        if not low <= at <= high:
            return f"{axis} = {at:.3f} m is outside {low:g} to {high:g} m"
    speed = math.sqrt(float(estimate.velocity @ estimate.velocity))
    if speed > settings.max_speed:
        return f"the platform moves at {speed:.3f} m/s; at most {settings.max_speed:g} is allowed"
    if inputs.tensions is not None and (inputs.tensions > settings.max_tensions).any():
        worst = int(np.argmax(inputs.tensions / settings.max_tensions))
        tension, limit = inputs.tensions[worst], settings.max_tensions[worst]
        return f"line {worst + 1} pulls {tension:.0f} N; at most {limit:.0f} is allowed"
    return ""


def _check_running(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> None:
    """Leave a state in which the machine moves if there is a reason to stop."""
    now = inputs.now
    if settings.barrier_timeout is not None:
        timed_out = now - max(state.last_barrier_time, state.state_start) > settings.barrier_timeout
        if state.barrier_broken or timed_out:
            state.barrier_stops += 1
            reason = "somebody is in the light barrier" if state.barrier_broken else "no reading of the light barrier"
            _enter(state, PrintState.PAUSED, now, reason)
            return
    if not inputs.estimate.valid and state.state is PrintState.PRINTING:
        _enter(state, PrintState.PAUSED, now, _POSITION_LOST)
        return
    if inputs.powder <= settings.refill_mass or Condition.POWDER_OUT in inputs.conditions:
        state.refills += 1
        reason = "no powder is left" if Condition.POWDER_OUT in inputs.conditions else "little powder is left"
        _enter(state, PrintState.REFILLING, now, reason)
        return
    if reason := _soft_limit(settings, state, inputs):
        _enter(state, PrintState.STOPPED, now, reason)


_POSITION_LOST = "the position is not known"


def _soft_limit(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> str:
    """Return the reason for a controlled stop, or an empty text."""
    if inputs.now - state.stalled_since > settings.stall_timeout:
        return f"a motor cannot pull its load for over {settings.stall_timeout:g} s"
    if Condition.DRUM_END in inputs.conditions:
        return "a winch drum is empty or full"
    if inputs.target is not None and inputs.estimate.valid:
        error = inputs.target.position - inputs.estimate.position
        distance = math.sqrt(float(error @ error))
        if distance > settings.max_error:
            return f"the platform is {distance:.3f} m from its target; at most {settings.max_error:g} is allowed"
        excess = float(np.nanmax(inputs.estimate.excess, initial=-math.inf))
        if excess > settings.max_excess:
            return f"a line is {excess:.3f} m too long; at most {settings.max_excess:g} is allowed"
    return ""


def _is_settled(settings: SupervisorSettings, state: SupervisorState, now: float) -> bool:
    return now - state.valid_since >= settings.settling_time


def _advance(settings: SupervisorSettings, state: SupervisorState, inputs: _Inputs) -> None:
    """Leave a state whose condition is met."""
    now, target = inputs.now, inputs.target
    if state.state is PrintState.READY and target is not None and target.arrived and _is_settled(settings, state, now):
        _enter(state, PrintState.PRINTING, now, "")
    elif state.state is PrintState.PRINTING and target is not None and target.finished:
        state.finished = True
        _enter(state, PrintState.IDLE, now, "finished")
    found = state.state is PrintState.PAUSED and state.reason == _POSITION_LOST and _is_settled(settings, state, now)
    if found or (state.resume_ordered and not (settings.barrier_timeout is not None and state.barrier_broken)):
        _enter(state, PrintState.READY, now, "")


def _enter(state: SupervisorState, new: PrintState, now: float, reason: str) -> None:
    state.state, state.reason, state.state_start, state.resume_ordered = new, reason, now, False
