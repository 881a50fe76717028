"""Simulated accelerometers on the lines, a known distance before B: angle of the tangent, with the line's vibration."""

from __future__ import annotations

import math

import numpy as np

from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import LineSensor
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.ticks import steps_per_interval
from cablewright.signals import LineAngles


class LineAccelerometers:
    """One accelerometer on each line."""

    def __init__(self, settings: LineSensor, period: float, random: np.random.Generator) -> None:
        """Raises `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._interval, self._step = (
            steps_per_interval(period, 1.0 / settings.rate, f"line_angles.rate = {settings.rate:g} Hz"),
            0,
        )

    def read(self, state: RigState) -> LineAngles | None:
        """Return a reading when one is due; lines whose reading is lost are NaN."""
        self._step += 1
        if self._step % self._interval:
            return None
        settings, count = self.settings, len(state.apparent_angles)
        angles = state.apparent_angles + settings.deviation * self._random.standard_normal(count)
        chance, anywhere = self._random.random(count), self._random.uniform(-0.5 * math.pi, 0.5 * math.pi, count)
        angles = np.where(chance > 1.0 - settings.outliers, anywhere, angles)
        angles[chance < settings.dropout] = np.nan
        angles.flags.writeable = False
        return LineAngles(state.truth.time, angles)

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._step = archive.count("step", self._step)
        archive.random("random", self._random)
