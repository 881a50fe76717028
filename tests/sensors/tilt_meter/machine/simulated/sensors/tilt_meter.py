"""Simulated tilt meter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from cablewright.foundation.signals.tilt_meter import TiltMeter
from cablewright.machine.sensors.tilt_meter import TILT_METER, TiltSheet

from cablewright.foundation.signals.frame import frozen
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class TiltReader(TimedSensor[TiltSheet, SensorFlaws]):
    """One tilt meter; its zero is drawn once."""

    def _mount(self, machine: Mounted) -> None:
        self._zero = self.settings.bias * self._random.standard_normal(2)

    def _measure(self, state: RigState) -> TiltMeter | None:
        noise, chance = self._random.standard_normal(2), self._random.random()
        if chance < self.flaws.dropout:
            return None
        return TiltMeter(state.truth.time, frozen(state.rotation[2, :2] + self._zero + self.settings.deviation * noise))


SIMULATED: Final = Simulated(TILT_METER, SensorFlaws, TiltReader)
