"""What every machine is, simulated, replayed or real: it takes a command, lives for one step and tells its readings."""

from __future__ import annotations

from typing import Protocol

from cablewright.signals import Command, SensorFrame

__all__ = ["Machine"]


class Machine(Protocol):
    """A machine of m winches. Its clock begins at 0 and goes on by ``period`` with each step."""

    @property
    def period(self) -> float:
        """The time that a step takes on the machine's clock, s."""

    def step(self, command: Command) -> SensorFrame:
        """Do as *command* says for one period. Returns what arrived meanwhile.

        Raises `InputError` for a command that is none: of another number of winches, not finite, older than the last.
        Raises `StopIteration` when a replayed machine's log is over.
        """
