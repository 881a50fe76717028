"""A simulated machine at the pace of a real one."""

from __future__ import annotations

import time
from array import array
from dataclasses import replace
from typing import Final

from cablewright.machine.interface import Abilities, Machine
from cablewright.signals import Command, SensorFrame

_SPIN_TIME: Final = 0.02  # s of busy waiting before a step is due: after sleeping it takes half as long again


class Paced:
    """A machine whose steps take their time, the last part of it in a busy loop, which needs a core of its own."""

    def __init__(self, machine: Machine) -> None:
        """Begin with the first step; *machine* is one that does not wait by itself."""
        self._machine, self._start, self._steps = machine, time.monotonic(), 0
        self.lateness: array[float] = array("d")
        """Of each step when it was due, s: negative where there was time left."""

    @property
    def period(self) -> float:
        """Time of one step, s."""
        return self._machine.period

    @property
    def abilities(self) -> Abilities:
        """Those of the machine, in real time."""
        return replace(self._machine.abilities, real_time=True)

    def open(self) -> None:
        """As `Machine`; the time of the first step begins."""
        self._machine.open()
        self._start, self._steps = time.monotonic(), 0

    def step(self, command: Command) -> SensorFrame:
        """As `Machine`."""
        if self._steps:  # the computer of the last step is at work until now
            due = self._start + self._steps * self.period
            self.lateness.append(time.monotonic() - due)
            time.sleep(max(0.0, due - time.monotonic() - _SPIN_TIME))
            while time.monotonic() < due:
                pass
        self._steps += 1
        return self._machine.step(command)

    def stop(self) -> None:
        """As `Machine`."""
        self._machine.stop()

    def close(self) -> None:
        """As `Machine`."""
        self._machine.close()
