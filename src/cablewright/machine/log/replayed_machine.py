"""A machine that was: it tells again what a log holds, whatever it is commanded."""

from __future__ import annotations

from cablewright.machine.log.log import Entry, Log
from cablewright.signals import Command, SensorFrame

__all__ = ["ReplayedMachine"]


class ReplayedMachine:
    """A `Machine`. Its steps are those of the log; `entry` is the last one, with its command and its truth."""

    def __init__(self, log: Log) -> None:
        """Replay *log* from where it stands."""
        self.log = log
        self.entry: Entry | None = None
        self._entries = log.entries()

    @property
    def period(self) -> float:
        """The time that a step takes on the machine's clock, s."""
        return self.log.head.period

    def step(self, command: Command | None = None) -> SensorFrame:  # noqa: ARG002, whatever it is
        """Return the next frame; raises `StopIteration` when there is none. `log.notes` says if the log was cut."""
        self.entry = next(self._entries)
        return self.entry.frame
