"""Simulated encoder of the drive that turns the container about its axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from cablewright.foundation.signals import YawAngle
from cablewright.machine.sensors.yaw_encoder import YAW_ENCODER, YawEncoder
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.true_state import RigState


class YawReader(TimedSensor[YawEncoder, SensorFlaws]):
    """Simulated angle of the container's yaw drive."""

    def _measure(self, state: RigState) -> YawAngle | None:
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        if chance < self.flaws.dropout:
            return None
        shown = state.yaw + self.settings.deviation * noise
        if chance > 1.0 - self.flaws.outliers:
            shown = math.tau * (anywhere - 0.5)
        return YawAngle(state.time, float(shown))


SIMULATED: Final = Simulated(YAW_ENCODER, SensorFlaws, YawReader)
