"""The operator at the page: messages become orders of the loop, and their results go back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from cablewright.control.manual import LEASE
from cablewright.control.orders import CALMING
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import ORDER_LIFE, Order, OrderKind, PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.serve.events import Events
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.messages import LoadMessage, OrderMessage
from cablewright.live.serve.winch import HELD, WINCH, WinchByHand

_NOBODY: Final = "the control: the operator has left"
_TOO_OLD: Final = f"the control: it was ordered over {ORDER_LIFE:g} s ago"
_GOING_ON: Final = (OrderKind.RESUME, OrderKind.REFILLED)
_HANDLED: Final = (PrintState.TENSIONING, PrintState.HOMING, PrintState.MANUAL)
_AT_REST: Final = (
    PrintState.FAULT,
    PrintState.OFF,
    PrintState.IDLE,
    PrintState.PAUSED,
    PrintState.STOPPED,
    PrintState.REFILLING,
)


@dataclass(eq=False)
class PageOperator:
    """An `Operator` at the page.

    ``may_load``: why a job may not be taken up, or an empty text. ``ends``: whether all ends.
    """

    link: ControlLink
    events: Events
    has_job: bool
    may_load: Callable[[LoadMessage], str]
    refill: Callable[[], None]
    ends: Callable[[], bool]
    home_at: Callable[[Array | None], None] = lambda _place: None
    winches: WinchByHand | None = None
    load: LoadMessage | None = None  # taken up next
    _lease: int = field(default=0, repr=False)  # under which somebody operates
    _resumed: float = field(default=math.inf, repr=False)  # s of the server's clock, of the last order to go on
    _waiting: list[tuple[int, str]] = field(default_factory=list, repr=False)
    _jog: tuple[str, float, int] | None = field(default=None, repr=False)  # who, last time, how often

    @property
    def jogged(self) -> float | None:
        """Machine time of the last lease of the present jog, s; None: no jog."""
        return None if self._jog is None else self._jog[1]

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s; see `Operator.orders`."""
        given = self._withdrawal(printer, now)
        for message in self.link.messages():
            if isinstance(message, LoadMessage):
                refusal = self.link.untimely(message) or self._loaded(printer, message)
                self._answer(message.number, message.by, "load", refusal)
            elif message.kind is OrderKind.TAKE_UP and HELD in message.arguments:
                self._hold(message)
            elif (why := self._refusal(printer, message)) is not None:
                self._answer(message.number, message.by, message.kind.value, why)
            else:
                self._waiting.append((message.number, message.kind.value))
                self._resumed = message.at if message.kind in _GOING_ON else self._resumed
                given.append(Order(message.kind, message.by, now - self.link.age(message), message.arguments))
        return tuple(given)

    def is_over(self, printer: Printer) -> bool:
        """Return whether the run ends; see `Operator.is_over`.

        True when another job is loaded, this one is printed, or the control ends.
        """
        return self.load is not None or (self.has_job and printer.finished) or self.ends()

    def answered(self, printer: Printer, orders: tuple[Order, ...], now: float) -> None:
        """Record the results of the orders of a step."""
        waiting, self._waiting = self._waiting, []
        for (number, _), order in zip(waiting, orders, strict=True):
            if order.kind is OrderKind.JOG and not order.refusal:
                self._note_jog(order.by, now)
                continue
            if order.kind is OrderKind.REFILLED and not order.refusal:
                self.refill()
            self._answer(number, order.by, order.kind.value, order.refusal, dict(order.arguments))
        if self._jog is not None and now - self._jog[1] > LEASE:
            by, _, times = self._jog
            self._jog = None
            self._keep(by, "jog", "", {}, f"ended after {times} leases; {printer.supervisor.state}")

    def _withdrawal(self, printer: Printer, now: float) -> list[Order]:
        """Orders to end what moves by hand or by a procedure, or waits to go on, once its lease has ended.

        What waits also ends as it gets too old by the server's clock: that of a simulated machine stands still while
        the control hangs.
        """
        before, self._lease = self._lease, self.link.lease
        waits, ended = printer.supervisor.resume_ordered, self._lease != before
        too_old = waits and self.link.clock() - self._resumed > ORDER_LIFE
        if not (too_old or (ended and (waits or printer.supervisor.state in _HANDLED))):
            return []
        kind = OrderKind.PAUSE if waits else OrderKind.STOP
        self._waiting.append((0, kind.value))
        return [Order(kind, _NOBODY if ended else _TOO_OLD, now)]

    def _refusal(self, printer: Printer, message: OrderMessage) -> str | None:
        """Why an order does not reach the loop; None: it does."""
        if message.kind not in CALMING and (why := self.link.untimely(message)):
            return f"{message.kind}: {why}"
        if message.kind is OrderKind.START and not self.has_job:
            return "start: no job is loaded"
        if message.kind is OrderKind.HOME and printer.supervisor.state is PrintState.IDLE:
            return self._homes(printer, message.arguments.get("place"))
        if message.kind is OrderKind.TAKE_UP and self.winches:  # whatever the state: it may be idle when it is obeyed
            return self.winches.choose(message.arguments.get(WINCH)) or None
        return None

    def _hold(self, message: OrderMessage) -> None:
        """Go on with a winch that is turned by hand, by a message that is not old."""
        if self.winches and not self.link.untimely(message) and self.link.age(message) <= LEASE:
            self.winches.hold(message.arguments.get(WINCH, ()))

    def _homes(self, printer: Printer, place: tuple[float, ...] | None) -> str | None:
        """Take a measured place for homing; why not, or None."""
        robot = printer.plan.velocity.model.robot
        if place is not None:
            if len(place) not in (3, robot.n):
                turned = "" if robot.n == 3 else ", or six, m and rad,"
                return f"home: place = {place}: three numbers, m{turned} are expected"
            for axis, low, at, high in zip("xyz", robot.scene.frame_min, place[:3], robot.scene.frame_max, strict=True):
                if not low <= at <= high:
                    return f"home: {axis} = {at:g} m is outside {low:g} to {high:g} m"
        self.home_at(None if place is None else np.array(place))
        return None

    def _loaded(self, printer: Printer, message: LoadMessage) -> str:
        state = printer.supervisor.state
        if state not in _AT_REST or printer.command.winch_speeds.any():
            return f"load: the machine is not at rest, its state is {state}"
        if message.load is not None and (why := self.may_load(message)):
            return f"load: {why}"
        self.load = message
        return ""

    def _note_jog(self, by: str, now: float) -> None:
        if self._jog is None:
            self._keep(by, "jog", "", {}, "begins")
            self.events.tell("order", f"jog by {by}")
        times = 1 if self._jog is None else self._jog[2] + 1
        self._jog = (by, now, times)

    def _answer(self, number: int, by: str, what: str, why: str, arguments: dict[str, Any] | None = None) -> None:
        self.events.answers.append((number, by, why))
        if not (what == "jog" and why and self._same_refusal(why)):
            self._keep(by, what, why, arguments or {})
        self.events.tell("refusal" if why else "order", f"{why} (asked by {by})" if why else f"{what} by {by}")

    def _same_refusal(self, why: str) -> bool:
        return bool(self.events.told) and why in self.events.told[-1][3]

    def _keep(self, by: str, what: str, why: str, arguments: dict[str, Any], note: str = "") -> None:
        kept = {"by": by, "order": what, "arguments": arguments, "refusal": why, "note": note}
        self.events.keep({key: value for key, value in kept.items() if value})
