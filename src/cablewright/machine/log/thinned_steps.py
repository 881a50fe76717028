"""Thinned logs: one of every N steps is written, with the readings and notices of those between."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

from cablewright.foundation.signals import (
    Command,
    Estimate,
    Notice,
    Order,
    PrintState,
    Progress,
    Reading,
    Scan,
    SensorFrame,
    Truth,
)

_MOST_SCANS: Final = 500  # that wait for a step: they are one step of a log, whose size is bounded


class Logged(NamedTuple):
    """One step of a thinned log, as it is written."""

    frame: SensorFrame
    command: Command | None
    truth: Truth | None
    estimate: Estimate | None
    progress: Progress | None
    orders: tuple[Order, ...]


class ThinnedSteps:
    """Chooses one of *every* steps, and all with an order, a new state, or 500 scans since the last chosen one.

    A chosen step also has data of the steps since the last: all scans, the last reading of each other source, and all
    notices. ``last``: the last step, where it was not chosen.
    """

    def __init__(self, every: int) -> None:
        """With 1, every step is chosen as it is."""
        self._every, self._left = every, 0
        self._state: PrintState | None = None
        self._scans: list[Scan] = []
        self._readings: dict[str, Reading] = {}
        self._notices: dict[Notice, None] = {}
        self.last: Logged | None = None

    def take(self, step: Logged) -> Logged | None:
        """Return the step to log, or None where *step* is left out."""
        if self._every == 1:
            return step
        for reading in step.frame.readings:
            if isinstance(reading, Scan):
                self._scans.append(reading)
            else:
                self._readings.pop(reading.source, None)
                self._readings[reading.source] = reading
        self._notices |= dict.fromkeys(step.frame.notices)
        before, self._state = self._state, None if step.progress is None else step.progress.state
        readings = (*self._scans, *self._readings.values())
        step = step._replace(frame=replace(step.frame, readings=readings, notices=tuple(self._notices)))
        if self._left and not step.orders and self._state is before and len(self._scans) < _MOST_SCANS:
            self._left, self.last = self._left - 1, step
            return None
        self._left, self.last = self._every - 1, None
        self._scans, self._readings, self._notices = [], {}, {}
        return step
