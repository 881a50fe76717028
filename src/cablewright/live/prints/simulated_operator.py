"""The simulated operator of a simulated machine, who sees the powder and the platform as a person would."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.measurement_stops import PlaceVisits
from cablewright.live.prints.plan import PrintOptions
from cablewright.machine.simulated.simulated_machine import SimulatedMachine

_NAME = "attendant"


@dataclass
class Attendant:
    """Resets and starts the machine, refills it, and resumes once the light barrier is clear.

    It also stops the machine where its ``visits`` are due, and reports the platform's position by ``measure``, with the
    layer and the number of the stop.
    """

    refill_drum: Callable[[], None]
    resume_delay: float = 5.0  # s from a stop, or from the light barrier being clear, to the order to resume
    refill_time: float = 60.0  # s that a refill takes
    visits: PlaceVisits = field(default_factory=PlaceVisits)
    measure: Callable[[int, int], None] = lambda _layer, _along: None
    measure_time: float = 60.0  # s that the platform stands until its place is measured
    _measures: bool = field(default=False, repr=False)
    _since: float = field(default=math.nan, repr=False)
    _state: PrintState = field(default=PrintState.READY, repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the simulated operator's orders at the time *now*, s."""
        return tuple([Order(kind, _NAME, now) for kind in self._kinds(printer, now)])

    def is_over(self, printer: Printer) -> bool:
        """Return whether the path has ended, or the machine has stopped with a cause: an attendant tries no further."""
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
        if self._is_to_measure(printer, state, now):
            return (OrderKind.PAUSE,)
        if state is PrintState.PAUSED:
            if printer.supervisor.barrier_broken:
                self._since = now
            if self._measures:
                self._measure(printer, now)
                return ()
            return (OrderKind.RESUME,) if now - self._since >= self.resume_delay else ()
        due = state is PrintState.REFILLING and now - self._since >= self.refill_time
        if due and not printer.supervisor.resume_ordered:
            self.refill_drum()
            printer.refilled()
            return (OrderKind.REFILLED,)
        return ()

    def _is_to_measure(self, printer: Printer, state: PrintState, now: float) -> bool:
        """Whether the machine is to stop, so that its place is measured."""
        if state is not PrintState.PRINTING or printer.target is None or self._measures:
            return False
        self._measures = self.visits.is_due(printer.plan.path.track, printer.target, now)
        return self._measures

    def _measure(self, printer: Printer, now: float) -> None:
        """Measure the place once the platform has stood long enough, and count the time to go on from then."""
        assert printer.target is not None  # since it printed
        if now - self._since < self.measure_time:
            return
        self.measure(printer.target.layer, self.visits.stopped())
        self._measures, self._since = False, now


def attendant_of(machine: SimulatedMachine, printer: Printer, choices: PrintOptions) -> Attendant:
    """Return the simulated operator of a print, who measures positions with their standard deviation."""

    def measure(layer: int, along: int) -> None:
        noise = np.random.default_rng([choices.seed, 9, layer, along]).normal(0.0, choices.place_sigma, 3)
        printer.place_measured(machine.truth.position + noise, by_tensions=choices.place_tensions)

    visits = PlaceVisits(choices.place_layers, choices.place_every, choices.place_stops)
    return Attendant(lambda: machine.refill(printer.plan.powder), visits=visits, measure=measure)
