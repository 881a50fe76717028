"""Simulated sensors on a wire: encoders of motors, of swivels and of a retraction, thermometer and hygrometer."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.arrays import Mask
from cablewright.machine.carriers import RetractionDrive
from cablewright.machine.sensors import ClimateSensor, Encoder, SwivelSensor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import SensorFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import BeamLength, Climate, Encoders, Swivels

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


class SwivelReader(TimedSensor[SwivelSensor, SensorFlaws]):
    """Angles of all swivels, read at once; their zeros are drawn once."""

    def __init__(
        self,
        key: str,
        settings: SwivelSensor,
        flaws: SensorFlaws,
        period: float,
        random: np.random.Generator,
        swivels: Mask,
    ) -> None:
        """*swivels* (m,): whether each line has one that turns about the vertical; the rest as `TimedSensor`."""
        super().__init__(key, settings, flaws, period, random)
        self._swivels = swivels
        self._zeros = settings.bias * random.standard_normal(len(swivels))

    def _measure(self, state: RigState) -> Swivels:
        m = len(self._swivels)
        noise, chance = self._random.standard_normal(m), self._random.random(m)
        anywhere = self._random.uniform(-np.pi, np.pi, m)
        shown = state.swivels + self._zeros + self.settings.deviation * noise
        shown = np.where(
            chance > 1.0 - self.flaws.outliers, anywhere, shown - 2.0 * np.pi * np.rint(shown / 2.0 / np.pi)
        )
        shown[(chance < self.flaws.dropout) | ~self._swivels] = np.nan
        shown.flags.writeable = False
        return Swivels(state.truth.time, shown)


class BeamReader(TimedSensor[RetractionDrive, SensorFlaws]):
    """Length of a platform that retracts."""

    def _measure(self, state: RigState) -> BeamLength | None:
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        if chance < self.flaws.dropout:
            return None
        length = state.truth.retraction
        shown = length + self.settings.deviation * noise
        if chance > 1.0 - self.flaws.outliers:
            shown = 2.0 * anywhere * length
        return BeamLength(state.truth.time, float(shown))
