"""Simulated sensors on a wire: the motors' incremental encoders, and the room's thermometer and hygrometer."""

from __future__ import annotations

from typing import Final

from cablewright.machine.sensors import ClimateSensor, Encoder
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import SensorFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import Climate, Encoders

_BITS: Final = 24  # of a counter


class EncoderReader(TimedSensor[Encoder, SensorFlaws]):
    """All encoders, read at once; their only error is quantisation."""

    def _measure(self, state: RigState) -> Encoders | None:
        chance, which, bit = self._random.random(), self._random.random(), int(self._random.integers(_BITS))
        if chance < self.flaws.dropout:
            return None
        counts = state.counts
        if chance > 1.0 - self.flaws.outliers:
            counts[int(which * len(counts))] ^= 1 << bit
        counts.flags.writeable = False
        return Encoders(state.truth.time, counts)


class Thermometer(TimedSensor[ClimateSensor, SensorFlaws]):
    """Temperature and relative humidity."""

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
        return Climate(state.truth.time, temperature, min(1.0, max(0.0, humidity)))
