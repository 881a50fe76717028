"""The motors' incremental encoders, and the room's thermometer and hygrometer: what is read over a wire."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.machine.simulated.rig import Moment
from cablewright.machine.simulated.settings import ClimateSensor, Encoder
from cablewright.machine.simulated.snapshot import Book
from cablewright.machine.simulated.ticks import every
from cablewright.signals import Climate, Encoders

__all__ = ["Counters", "Thermometer"]


_BITS: Final = 24  # of a counter


class Counters:
    """All encoders, read at once; their error is that they count in whole numbers."""

    def __init__(self, settings: Encoder, period: float, random: np.random.Generator) -> None:
        """Raise `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._every, self._step = every(period, 1.0 / settings.rate, f"encoders.rate = {settings.rate:g} Hz"), 0

    def read(self, moment: Moment) -> Encoders | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._every:
            return None
        chance, which, bit = self._random.random(), self._random.random(), int(self._random.integers(_BITS))
        if chance < self.settings.dropout:
            return None
        counts = moment.counts
        if chance > 1.0 - self.settings.outliers:
            counts[int(which * len(counts))] ^= 1 << bit
        counts.flags.writeable = False
        return Encoders(moment.truth.time, counts)

    def keep(self, book: Book) -> None:
        """Note, or take up again, what decides on the next readings."""
        self._step = book.count("step", self._step)
        book.random("random", self._random)


class Thermometer:
    """Temperature and relative humidity."""

    def __init__(self, settings: ClimateSensor, period: float, random: np.random.Generator) -> None:
        """Raise `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._every, self._step = every(period, 1.0 / settings.rate, f"climate_sensor.rate = {settings.rate:g} Hz"), 0

    def read(self, moment: Moment) -> Climate | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._every:
            return None
        settings = self.settings
        warmth, damp = self._random.standard_normal(2).tolist()
        chance, hot, wet = self._random.random(3).tolist()
        if chance < settings.dropout:
            return None
        temperature = moment.temperature + settings.temperature_deviation * warmth
        humidity = moment.humidity + settings.humidity_deviation * damp
        if chance > 1.0 - settings.outliers:
            temperature, humidity = -40.0 + 125.0 * hot, wet
        return Climate(moment.truth.time, temperature, min(1.0, max(0.0, humidity)))

    def keep(self, book: Book) -> None:
        """Note, or take up again, what decides on the next readings."""
        self._step = book.count("step", self._step)
        book.random("random", self._random)
