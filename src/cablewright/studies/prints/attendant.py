"""The operator of a simulated machine."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from cablewright.signals import Order, OrderKind, PrintState
from cablewright.studies.prints.loop import Printer

_NAME = "attendant"


@dataclass
class Attendant:
    """Resets and starts the machine, refills it, and resumes once the light barrier is clear."""

    refill_drum: Callable[[], None]
    resume_delay: float = 5.0  # s from a stop, or from the light barrier being clear, to the order to resume
    refill_time: float = 60.0  # s that a refill takes
    _since: float = field(default=math.nan, repr=False)
    _state: PrintState = field(default=PrintState.READY, repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders at *now*, s."""
        return tuple(Order(kind, _NAME, now) for kind in self._kinds(printer, now))

    def is_over(self, printer: Printer) -> bool:
        """Whether the path has ended, or the machine has stopped and knows why: an attendant asks no further."""
        stopped = printer.supervisor.state in (PrintState.STOPPED, PrintState.FAULT)
        return printer.finished or (stopped and not printer.searches)

    def _kinds(self, printer: Printer, now: float) -> tuple[OrderKind, ...]:
        state = printer.supervisor.state
        if state is not self._state:
            self._since, self._state = now, state
        if printer.supervisor.is_new and not printer.finished:
            return (OrderKind.RESET, OrderKind.ENABLE, OrderKind.START)
        if state is PrintState.IDLE and not printer.finished:
            return (OrderKind.START,)
        if state is PrintState.PAUSED:
            if printer.supervisor.barrier_broken:
                self._since = now
            return (OrderKind.RESUME,) if now - self._since >= self.resume_delay else ()
        due = state is PrintState.REFILLING and now - self._since >= self.refill_time
        if due and not printer.supervisor.resume_ordered:
            self.refill_drum()
            printer.refilled()
            return (OrderKind.REFILLED,)
        return ()
