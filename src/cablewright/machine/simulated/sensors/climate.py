"""Simulated thermometer and hygrometer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from cablewright.foundation.signals import Climate
from cablewright.machine.sensors.climate import CLIMATE, ClimateSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.true_state import RigState


class Thermometer(TimedSensor[ClimateSensor, SensorFlaws]):
    """Simulated sensor of temperature and relative humidity."""

    def _measure(self, state: RigState) -> Climate | None:
        settings, flaws = self.settings, self.flaws
        heat_noise, damp_noise = self._random.standard_normal(2).tolist()
        chance, any_heat, any_damp = self._random.random(3).tolist()
        if chance < flaws.dropout:
            return None
        temperature = state.temperature + settings.temperature_deviation * heat_noise
        humidity = state.humidity + settings.humidity_deviation * damp_noise
        if chance > 1.0 - flaws.outliers:
            temperature, humidity = -40.0 + 125.0 * any_heat, any_damp
        return Climate(state.time, temperature, min(1.0, max(0.0, humidity)))


SIMULATED: Final = Simulated(CLIMATE, SensorFlaws, Thermometer)
