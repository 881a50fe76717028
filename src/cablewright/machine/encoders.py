"""The motors' incremental encoders, and the room's thermometer and hygrometer: what is read over a wire."""

from __future__ import annotations

import numpy as np

from cablewright.machine.rig import Moment
from cablewright.machine.settings import ClimateSensor, Encoder
from cablewright.machine.ticks import every
from cablewright.signals import Climate, Encoders

__all__ = ["Counters", "Thermometer"]


class Counters:
    """All encoders, read at once; their error is that they count in whole numbers."""

    def __init__(self, settings: Encoder, period: float) -> None:
        """Raise `InputError` for a rate that does not fit the machine's *period*, s."""
        self._every, self._step = every(period, 1.0 / settings.rate, f"encoders.rate = {settings.rate:g} Hz"), 0

    def read(self, moment: Moment) -> Encoders | None:
        """Return a reading when one is due."""
        self._step += 1
        if self._step % self._every:
            return None
        moment.counts.flags.writeable = False
        return Encoders(moment.truth.time, moment.counts)


class Thermometer:
    """Temperature and relative humidity."""

    def __init__(self, settings: ClimateSensor, period: float, random: np.random.Generator) -> None:
        """Raise `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._every, self._step = every(period, 1.0 / settings.rate, f"climate_sensor.rate = {settings.rate:g} Hz"), 0

    def read(self, moment: Moment) -> Climate | None:
        """Return a reading when one is due."""
        self._step += 1
        if self._step % self._every:
            return None
        warmth, damp = self._random.standard_normal(2).tolist()
        settings = self.settings
        humidity = moment.humidity + settings.humidity_deviation * damp
        temperature = moment.temperature + settings.temperature_deviation * warmth
        return Climate(moment.truth.time, temperature, min(1.0, max(0.0, humidity)))
