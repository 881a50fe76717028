"""Simulated sensors on a wire: the motors' incremental encoders, and the room's thermometer and hygrometer."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import ClimateSensor, Encoder
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.ticks import steps_per_interval
from cablewright.signals import Climate, Encoders

_BITS: Final = 24  # of a counter


class EncoderReader:
    """All encoders, read at once; their only error is quantisation."""

    def __init__(self, settings: Encoder, period: float, random: np.random.Generator) -> None:
        """Raises `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._interval, self._step = (
            steps_per_interval(period, 1.0 / settings.rate, f"encoders.rate = {settings.rate:g} Hz"),
            0,
        )

    def read(self, state: RigState) -> Encoders | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._interval:
            return None
        chance, which, bit = self._random.random(), self._random.random(), int(self._random.integers(_BITS))
        if chance < self.settings.dropout:
            return None
        counts = state.counts
        if chance > 1.0 - self.settings.outliers:
            counts[int(which * len(counts))] ^= 1 << bit
        counts.flags.writeable = False
        return Encoders(state.truth.time, counts)

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._step = archive.count("step", self._step)
        archive.random("random", self._random)


class Thermometer:
    """Temperature and relative humidity."""

    def __init__(self, settings: ClimateSensor, period: float, random: np.random.Generator) -> None:
        """Raises `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._interval, self._step = (
            steps_per_interval(period, 1.0 / settings.rate, f"climate_sensor.rate = {settings.rate:g} Hz"),
            0,
        )

    def read(self, state: RigState) -> Climate | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._interval:
            return None
        settings = self.settings
        heat_noise, damp_noise = self._random.standard_normal(2).tolist()
        chance, any_heat, any_damp = self._random.random(3).tolist()
        if chance < settings.dropout:
            return None
        temperature = state.temperature + settings.temperature_deviation * heat_noise
        humidity = state.humidity + settings.humidity_deviation * damp_noise
        if chance > 1.0 - settings.outliers:
            temperature, humidity = -40.0 + 125.0 * any_heat, any_damp
        return Climate(state.truth.time, temperature, min(1.0, max(0.0, humidity)))

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._step = archive.count("step", self._step)
        archive.random("random", self._random)
