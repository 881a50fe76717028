"""Interface of a machine, simulated, replayed or real: it takes a command for one step and returns its readings."""

from __future__ import annotations

from typing import Protocol

from cablewright.signals import Command, SensorFrame


class Machine(Protocol):
    """A machine with m winches. Its clock starts at 0 and advances by ``period`` with each step."""

    @property
    def period(self) -> float:
        """Time of one step, s."""

    def step(self, command: Command) -> SensorFrame:
        """Apply *command* for one period. Returns the readings that arrived.

        Raises `InputError` for an invalid command: of another number of winches, not finite, older than the last.
        Raises `StopIteration` when a replayed machine's log is over.
        """
