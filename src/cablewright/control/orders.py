"""Examination of orders from all sources: which can be obeyed in any state, and which take precedence."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Final

from cablewright.control import manual
from cablewright.control.manual import ManualSettings
from cablewright.control.supervisor import MOVING
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import ORDER_LIFE, Order, OrderKind, PrintState
from cablewright.foundation.units import LARGEST

BY_HAND: Final = (OrderKind.JOG, OrderKind.GO_TO, OrderKind.PARK)
"""Orders of motions by hand."""

STOPS: Final = (OrderKind.STOP, OrderKind.EMERGENCY, OrderKind.PAUSE)
"""Orders to come to rest."""

CALMING: Final = (*STOPS, OrderKind.RELEASE)
"""Orders that are obeyed however old they are, and whoever operates now."""

_PROCEDURES: Final = {OrderKind.TAKE_UP: PrintState.TENSIONING, OrderKind.HOME: PrintState.HOMING}
_MAX_ARGUMENTS: Final = 20  # of an order


@dataclass(eq=False)
class OrderState:
    """Memory of the examination of orders, changed in place by `examine`."""

    times: ReadingTimes = field(default_factory=ReadingTimes)  # of orders to jog
    jog_time: float = -math.inf  # s, of the last order to jog
    jog_stopped: bool = False  # a stop was ordered since the last pause of jog requests


def examine(
    settings: ManualSettings,
    state: OrderState,
    orders: tuple[Order, ...],
    now: float,
    *,
    known: bool,
    procedures: Collection[PrintState],
    step: float = 0.0,
) -> list[Order]:
    """Return the orders at *now*, s, with `refusal` filled in; an empty one leaves the decision to the state machine.

    *known*: whether the position is known. *procedures*: procedures that the plan has. *step*: planned duration of the
    last step, s; an order given before it is no older for that. A stop overrides motion orders of the same step, and a
    jog that was stopped begins again only after a pause of all jog requests. Every order except a stop is rejected
    `ORDER_LIFE` after it was given.
    """
    found: list[Order] = []
    if not orders:
        return found
    stops = any(order.kind in STOPS for order in orders)
    for order in orders:
        if not _is_sound(order):
            why = f"{order.kind}: time and arguments: finite numbers are expected, in tuples"
            found.append(replace(order, time=now, arguments={}, refusal=why))
        elif stops and order.kind in (*MOVING, OrderKind.RESUME, OrderKind.RESET):
            found.append(replace(order, refusal=f"{order.kind}: a stop was ordered at the same time"))
        else:
            why = _untimely(state, order, now, step) or _refusal(settings, state, order, now, known, procedures)
            found.append(replace(order, refusal=why))
    state.jog_stopped |= stops
    return found


def _untimely(state: OrderState, order: Order, now: float, step: float) -> str:
    """Whether an order comes too late, or was overtaken by a newer one: why, or an empty text.

    One of the future counts as of now.
    """
    if order.kind in CALMING:
        return ""
    if (age := now - step - order.time) > ORDER_LIFE:
        return f"{order.kind}: it was ordered {age:.1f} s ago; at most {ORDER_LIFE:g} s are allowed: order it again"
    state.times.judge(order.kind, min(order.time, now), now)
    overtaken = order.kind is OrderKind.JOG and order.time < state.times.last(order.kind)
    return "jog: a newer order to jog has come before it" if overtaken else ""


def _refusal(
    settings: ManualSettings,
    state: OrderState,
    order: Order,
    now: float,
    known: bool,
    procedures: Collection[PrintState],
) -> str:
    if order.kind in BY_HAND and not known:
        return f"{order.kind}: the position is not known"
    if order.kind is OrderKind.JOG:
        held, state.jog_time = now - state.jog_time <= manual.LEASE, now
        if state.jog_stopped and held:
            return "jog: it was stopped; let go first"
        state.jog_stopped = False
    if order.kind in BY_HAND:
        return manual.refusal(settings, order, now)
    if order.kind in _PROCEDURES and _PROCEDURES[order.kind] not in procedures:
        return f"{order.kind}: the plan has no procedure for it"
    if order.kind is OrderKind.OVERRIDE:
        share = order.arguments.get("share", ())
        if len(share) != 1 or not 0.0 <= share[0] <= 1.0:
            return f"override: share = {share}: one number from 0 to 1 is expected"
    return ""


def _is_sound(order: Order) -> bool:
    """Whether time and arguments, which may come from anywhere, are finite numbers and tuples of such."""
    arguments: object = order.arguments
    if not (isinstance(arguments, dict) and len(arguments) <= _MAX_ARGUMENTS and _is_finite(order.time)):
        return False
    return all(
        isinstance(key, str) and isinstance(values, tuple) and all(map(_is_finite, values))
        for key, values in arguments.items()
    )


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and abs(value) <= LARGEST
