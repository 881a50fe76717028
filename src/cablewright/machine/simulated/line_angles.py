"""Simulated accelerometers on the lines, a known distance before B: angle of the tangent, with the line's vibration."""

from __future__ import annotations

import math

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.sensors import LineSensor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import SensorFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import LineAngles


class LineAccelerometers(TimedSensor[LineSensor, SensorFlaws]):
    """One accelerometer on each line; the angle of a line whose reading is lost is NaN."""

    def __init__(
        self,
        key: str,
        settings: LineSensor,
        flaws: SensorFlaws,
        period: float,
        random: np.random.Generator,
        zeros: Array,
    ) -> None:
        """*zeros* (m,): rad, what each shows too much; the rest as `TimedSensor`."""
        super().__init__(key, settings, flaws, period, random)
        self._zeros = zeros

    def _measure(self, state: RigState) -> LineAngles:
        settings, flaws, count = self.settings, self.flaws, len(state.apparent_angles)
        angles = state.apparent_angles + self._zeros + settings.deviation * self._random.standard_normal(count)
        chance, anywhere = self._random.random(count), self._random.uniform(-0.5 * math.pi, 0.5 * math.pi, count)
        angles = np.where(chance > 1.0 - flaws.outliers, anywhere, angles)
        angles[chance < flaws.dropout] = np.nan
        angles.flags.writeable = False
        return LineAngles(state.truth.time, angles)
