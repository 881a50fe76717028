"""Creep of cables as a robot file describes it, as rates of strain for estimators of a point platform.

The memory of the loads is advanced once a second; in between the rate is that which loads that stay would give, and
what loads that changed made different is made good in the next second. Cables are taken to have rested before: a
filter learns a rate that is another.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.estimation.climate import FeltAir
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Climate
from cablewright.models.creep import CreepMemory, memory_of
from cablewright.robot import Robot

_PERIOD: Final = 1.0  # s between two looks at the loads, at least
_GAP: Final = 60.0  # s without loads, after which nothing is made good: lidars have seen it


class KnownCreep:
    """Creep of the cables by the robot file. ``rates`` (m,): 1/s, of the strain of each line, until the next time."""

    SAVED = ("_memory",)

    def __init__(self, memory: CreepMemory, m: int) -> None:
        """Of *m* lines that have not been loaded yet."""
        self.rates = np.zeros(m)
        self._memory, self._period, self._time = memory, _PERIOD, math.nan
        self._loads, self._counted = np.zeros(m), np.zeros(m)
        self._air = FeltAir()

    def read(self, reading: Climate) -> None:
        """Set the creep rate to the climate of a *reading* of temperature and humidity."""
        self._air.read(reading, self._memory)

    def follow(self, loads: Array, now: float) -> None:
        """Advance creep under *loads* (m,), N, to *now*, s, if a step is due.

        A clock that was set back begins again from there.
        """
        passed = now - self._time
        if 0.0 <= passed < _PERIOD:
            return
        if passed > 0.0:
            self._memory.advance(self._loads, loads, passed)
        strain = self._memory.strain
        counted = self._counted + self.rates * passed if 0.0 < passed <= _GAP else strain
        self._period = max(_PERIOD, passed) if passed > 0.0 else _PERIOD
        self.rates = (strain - counted + self._memory.gain(loads, self._period)) / self._period
        self._counted, self._loads, self._time = counted, loads.copy(), now


def known_creep(robot: Robot) -> KnownCreep | None:
    """Return the creep of a *robot*'s cables; None where none is described."""
    memory = memory_of([line.cable.creep for line in robot.lines])
    return None if memory is None else KnownCreep(memory, robot.m)
