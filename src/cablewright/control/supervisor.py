"""What a print may do now: its states, what ends each of them, and the limits that stop the machine.

    idle -start-> ready -there-> printing -end of path-> idle
    printing -barrier, pause, no position-> paused -resume, barrier clear-> ready
    printing -powder low or out-> refilling -refilled, barrier clear-> ready
    any -a soft limit, stop-> stopped -resume-> ready          any -a hard limit, emergency stop-> fault -reset-> idle

A controlled stop slows down along the path and then holds the winches, so that all lines keep their tension. An
emergency stop and every hard limit hold the winches at once. Nothing goes on by itself where a person may stand: who
paused orders the resume. Only a position that was lost and found again needs no order.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.control.guide import Target, Wish
from cablewright.errors import InputError
from cablewright.signals import Barrier, Condition, Encoders, Estimate, PrintState, SensorFrame

__all__ = ["Order", "SupervisorSettings", "SupervisorState", "Verdict", "step"]

Array = NDArray[np.float64]


class Order(Enum):
    """What people may order."""

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

    ``low``, ``high``: (3,) where the platform may be. ``speed``: m/s of it; ``tension``: (m,) N at the sheaves, as
    lengths tell it; ``slack``: m of any line's excess; ``error``: m from where it should be. ``barrier``: s without
    word from the light barrier, None: there is none. ``silence``: s without encoders. ``settle``: s for which the
    position has to be known before it moves. ``patience``: s without a position until that is a fault. ``reserve``:
    kg of powder at which to refill. ``stall``: s for which a motor may fail to pull.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    speed: float
    tension: Array
    slack: float = 0.3
    error: float = 0.15
    barrier: float | None = None
    silence: float = 0.5
    settle: float = 3.0
    patience: float = 60.0
    reserve: float = 0.2
    stall: float = 2.0

    def __post_init__(self) -> None:
        """Refuse limits that limit nothing."""
        for name in ("speed", "slack", "error", "silence", "settle", "patience", "stall"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise InputError(f"limits of the place: {self.low} to {self.high} m leaves no room")


@dataclass(eq=False)
class SupervisorState:
    """What `step` changes."""

    state: PrintState = PrintState.IDLE
    reason: str = ""
    since: float = 0.0  # s: when this state began
    begun: float = math.inf  # s: when the first frame came
    finished: bool = False
    known_since: float = math.nan  # s: from when on the position was always known
    known_at: float = -math.inf  # s: when it was known last
    encoders_at: float = -math.inf
    barrier_at: float = -math.inf
    broken: bool = False
    stalled_since: float = math.nan
    resume: bool = False  # ordered, and waits for the barrier
    stops: int = 0  # by the light barrier
    refills: int = 0


class Verdict(NamedTuple):
    """What may be done in the next step."""

    state: PrintState
    reason: str
    wish: Wish
    freeze: bool  # hold all winches at once, whatever control says
    valve: bool  # material may be laid


class _Seen(NamedTuple):
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
    """Judge one step; *state* changes in place. *target*: the last; *tensions* (m,), N, *powder*, kg: as believed."""
    now = frame.time
    _listen(state, frame, estimate)
    conditions = frozenset(notice.condition for notice in frame.notices)
    seen = _Seen(now, estimate, target, tensions, powder, conditions)
    for order in orders:
        _obey(state, order, now)
    hard = _hard(settings, state, seen)
    if hard and state.state not in (PrintState.FAULT, PrintState.IDLE):
        _enter(state, PrintState.FAULT, now, hard)
    elif state.state in (PrintState.READY, PrintState.PRINTING):
        _check_running(settings, state, seen)
    _move_on(settings, state, seen)
    stands = target is None or (target.pace == 0.0 and not target.velocity.any())
    wish = _WISHES.get(state.state, Wish.HOLD)
    if state.state is PrintState.READY and not _settled(settings, state, now):
        wish = Wish.HOLD
    freeze = state.state is PrintState.FAULT or (wish is Wish.HOLD and stands)
    valve = state.state is not PrintState.FAULT and state.state is not PrintState.READY
    return Verdict(state.state, state.reason, wish, freeze, valve)


_WISHES = {PrintState.PRINTING: Wish.FOLLOW, PrintState.READY: Wish.APPROACH}


def _listen(state: SupervisorState, frame: SensorFrame, estimate: Estimate) -> None:
    state.begun = min(state.begun, frame.time)
    for reading in frame.readings:
        if isinstance(reading, Encoders):
            state.encoders_at = frame.time
        elif isinstance(reading, Barrier):
            state.barrier_at, state.broken = frame.time, reading.broken
    if estimate.valid:
        state.known_at = frame.time
        if math.isnan(state.known_since):
            state.known_since = frame.time
    else:
        state.known_since = math.nan
    stalled = any(notice.condition is Condition.STALLED for notice in frame.notices)
    if not stalled:
        state.stalled_since = math.nan
    elif math.isnan(state.stalled_since):
        state.stalled_since = frame.time


def _obey(state: SupervisorState, order: Order, now: float) -> None:
    """Take an order; one that does not fit the state is without effect."""
    was = state.state
    if order is Order.EMERGENCY:
        _enter(state, PrintState.FAULT, now, "emergency stop")
    elif order is Order.RESET and was is PrintState.FAULT:
        _enter(state, PrintState.IDLE, now, "reset")
    elif order is Order.START and was is PrintState.IDLE:
        state.finished = False
        _enter(state, PrintState.READY, now, "")
    elif order is Order.PAUSE and was in (PrintState.READY, PrintState.PRINTING):
        _enter(state, PrintState.PAUSED, now, "paused by order")
    elif order is Order.STOP and was not in (PrintState.IDLE, PrintState.FAULT):
        _enter(state, PrintState.STOPPED, now, "stopped by order")
    elif (order is Order.RESUME and was in (PrintState.PAUSED, PrintState.STOPPED)) or (
        order is Order.REFILLED and was is PrintState.REFILLING
    ):
        state.resume = True


def _hard(settings: SupervisorSettings, state: SupervisorState, seen: _Seen) -> str:
    """What stops the machine at once, or an empty text."""
    now, estimate = seen.now, seen.estimate
    if now - max(state.encoders_at, state.begun) > settings.silence:
        return f"no word from the encoders for over {settings.silence:g} s"
    if Condition.NO_EQUILIBRIUM in seen.conditions:
        return "the platform is in no equilibrium"
    if not estimate.valid:
        waited = now - max(state.known_at, state.since)
        if state.state is not PrintState.REFILLING and waited > settings.patience:
            return f"the position has not been known for over {settings.patience:g} s"
        return ""
    x = estimate.position.tolist()
    for axis, low, at, high in zip("xyz", settings.low, x, settings.high, strict=True):
        if not low <= at <= high:
            return f"{axis} = {at:.3f} m is outside {low:g} to {high:g} m"
    speed = math.sqrt(float(estimate.velocity @ estimate.velocity))
    if speed > settings.speed:
        return f"the platform moves at {speed:.3f} m/s; at most {settings.speed:g} is allowed"
    if seen.tensions is not None and (seen.tensions > settings.tension).any():
        worst = int(np.argmax(seen.tensions / settings.tension))
        return f"line {worst + 1} pulls {seen.tensions[worst]:.0f} N; at most {settings.tension[worst]:.0f} is allowed"
    return ""


def _check_running(settings: SupervisorSettings, state: SupervisorState, seen: _Seen) -> None:
    """End a state in which the machine moves, where something asks for it."""
    now, estimate, target = seen.now, seen.estimate, seen.target
    if settings.barrier is not None:
        quiet = now - max(state.barrier_at, state.since) > settings.barrier
        if state.broken or quiet:
            state.stops += 1
            why = "somebody is in the light barrier" if state.broken else "no word from the light barrier"
            _enter(state, PrintState.PAUSED, now, why)
            return
    if not estimate.valid and state.state is PrintState.PRINTING:
        _enter(state, PrintState.PAUSED, now, _LOST)
        return
    if seen.powder <= settings.reserve or Condition.POWDER_OUT in seen.conditions:
        state.refills += 1
        out = Condition.POWDER_OUT in seen.conditions
        _enter(state, PrintState.REFILLING, now, "no powder is left" if out else "little powder is left")
        return
    soft = _soft(settings, state, seen, target)
    if soft:
        _enter(state, PrintState.STOPPED, now, soft)


_LOST = "the position is not known"


def _soft(settings: SupervisorSettings, state: SupervisorState, seen: _Seen, target: Target | None) -> str:
    """What asks for a controlled stop, or an empty text."""
    if seen.now - state.stalled_since > settings.stall:
        return f"a motor cannot pull its load for over {settings.stall:g} s"
    if Condition.DRUM_END in seen.conditions:
        return "a winch drum is empty or full"
    if target is not None and seen.estimate.valid:
        off = target.position - seen.estimate.position
        away = math.sqrt(float(off @ off))
        if away > settings.error:
            return f"the platform is {away:.3f} m from where it should be; at most {settings.error:g} is allowed"
        most = float(np.nanmax(seen.estimate.excess, initial=-math.inf))
        if most > settings.slack:
            return f"a line is {most:.3f} m too long; at most {settings.slack:g} is allowed"
    return ""


def _settled(settings: SupervisorSettings, state: SupervisorState, now: float) -> bool:
    return now - state.known_since >= settings.settle


def _move_on(settings: SupervisorSettings, state: SupervisorState, seen: _Seen) -> None:
    """Go from a state that waits to the next one."""
    now, target = seen.now, seen.target
    if state.state is PrintState.READY and target is not None and target.there and _settled(settings, state, now):
        _enter(state, PrintState.PRINTING, now, "")
    elif state.state is PrintState.PRINTING and target is not None and target.over:
        state.finished = True
        _enter(state, PrintState.IDLE, now, "finished")
    found = state.state is PrintState.PAUSED and state.reason == _LOST and _settled(settings, state, now)
    if found or (state.resume and not (settings.barrier is not None and state.broken)):
        _enter(state, PrintState.READY, now, "")


def _enter(state: SupervisorState, new: PrintState, now: float, reason: str) -> None:
    state.state, state.reason, state.since, state.resume = new, reason, now, False
