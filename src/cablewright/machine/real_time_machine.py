"""A simulated machine that runs in real time."""

from __future__ import annotations

import time
from array import array
from dataclasses import replace
from typing import Final

from cablewright.foundation.signals import ORDER_LIFE, Command, Condition, Notice, SensorFrame
from cablewright.kernels import prepared_count
from cablewright.machine.interface import Abilities, Machine

_SPIN_TIME: Final = 0.02  # s of busy waiting before a step is due: after sleeping it takes half as long again


class Paced:
    """A simulated machine whose steps take real time; the last part is a busy loop, which needs a core of its own.

    It never runs faster than the clock: after a step that began late the pace starts again. As the drives of a real
    machine would, it reports a control that hung for longer than an order lives, unless it waited for kernels.
    """

    def __init__(self, machine: Machine) -> None:
        """Begin with the first step; *machine* is one that does not wait by itself."""
        self._machine, self._due = machine, 0.0  # s, when the next step is due; 0: now
        self._prepared = 0  # kernels, at the last step
        self.lateness: array[float] = array("d")
        """Of each step when it was due, s: negative where there was time left."""

    @property
    def period(self) -> float:
        """Time of one step, s."""
        return self._machine.period

    @property
    def abilities(self) -> Abilities:
        """Abilities of the machine, marked as real time."""
        return replace(self._machine.abilities, real_time=True)

    def open(self) -> None:
        """Connect to the machine; see `Machine.open`."""
        self._machine.open()
        self._due = 0.0

    def step(self, command: Command) -> SensorFrame:
        """Send *command*, wait for the step, and return the readings that arrived; see `Machine.step`."""
        due = self._due or time.monotonic()
        if self._due:  # the computer of the last step is at work until now
            self.lateness.append(time.monotonic() - due)
            time.sleep(max(0.0, due - time.monotonic() - _SPIN_TIME))
            while time.monotonic() < due:
                pass
        begin = time.monotonic()
        self._due = begin + self.period
        waited, self._prepared = self._prepared != prepared_count(), prepared_count()
        frame = self._machine.step(command)
        if (hung := begin - due) <= ORDER_LIFE or waited:
            return frame
        return replace(frame, notices=(*frame.notices, Notice(Condition.HUNG, f"{hung:.1f} s")))

    def stop(self) -> None:
        """Stop and hold all winches; see `Machine.stop`."""
        self._machine.stop()

    def close(self) -> None:
        """Disconnect from the machine; see `Machine.close`."""
        self._machine.close()
