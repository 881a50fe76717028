"""Simulated accelerometers on the lines, a known distance before B: angle of the tangent, with the line's vibration."""

from __future__ import annotations

import math

import numpy as np

from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import LineSensor
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import LineAngles


class LineAccelerometers(TimedSensor[LineSensor]):
    """One accelerometer on each line; the angle of a line whose reading is lost is NaN."""

    def _measure(self, state: RigState) -> LineAngles:
        settings, count = self.settings, len(state.apparent_angles)
        angles = state.apparent_angles + settings.deviation * self._random.standard_normal(count)
        chance, anywhere = self._random.random(count), self._random.uniform(-0.5 * math.pi, 0.5 * math.pi, count)
        angles = np.where(chance > 1.0 - settings.outliers, anywhere, angles)
        angles[chance < settings.dropout] = np.nan
        angles.flags.writeable = False
        return LineAngles(state.truth.time, angles)
