"""Simulated light barrier around the machine."""

from __future__ import annotations

import numpy as np

from cablewright.machine.sensors import BarrierSensor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import BarrierFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import Barrier


class LightBarrier(TimedSensor[BarrierSensor, BarrierFlaws]):
    """One light barrier. It latches: an interruption since the last reading shows in the next one."""

    SAVED = (*TimedSensor.SAVED, "_last_read")

    _last_read = -np.inf  # s, time of the last reading

    def _measure(self, state: RigState) -> Barrier | None:
        now, chance = state.truth.time, self._random.random()
        broken = any(begin <= now and self._last_read < end for begin, end in self.flaws.intrusions)
        self._last_read = now
        if chance < self.flaws.dropout:
            return None
        return Barrier(now, broken != (chance > 1.0 - self.flaws.outliers))
