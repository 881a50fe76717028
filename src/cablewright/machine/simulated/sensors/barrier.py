"""Simulated light barrier around the machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Self

import numpy as np
from pydantic import model_validator

from cablewright.foundation.signals import Barrier
from cablewright.machine.quantities import Times, require_pairs_rise
from cablewright.machine.sensors.barrier import BARRIER, BarrierSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.true_state import RigState


class BarrierFlaws(SensorFlaws):
    """Flaws of a light barrier, and the start and end of its interruptions, ``intrusions``."""

    intrusions: Times = ()

    @model_validator(mode="after")
    def _intrusions_rise(self) -> Self:
        require_pairs_rise("intrusions", self.intrusions)
        return self


class LightBarrier(TimedSensor[BarrierSensor, BarrierFlaws]):
    """One light barrier. It latches: an interruption since the last reading shows in the next one."""

    SAVED = (*TimedSensor.SAVED, "_last_read")

    _last_read = -np.inf  # s, time of the last reading

    def _measure(self, state: RigState) -> Barrier | None:
        now, chance = state.time, self._random.random()
        broken = any(begin <= now and self._last_read < end for begin, end in self.flaws.intrusions)
        self._last_read = now
        if chance < self.flaws.dropout:
            return None
        return Barrier(now, broken != (chance > 1.0 - self.flaws.outliers))


SIMULATED: Final = Simulated(BARRIER, BarrierFlaws, LightBarrier)
