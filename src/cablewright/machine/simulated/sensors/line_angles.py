"""Simulated accelerometers on the lines near B: angle of the cable, with its vibration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.signals import LineAngles
from cablewright.machine.sensors.line_angles import LINE_ANGLES, LineSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class LineAccelerometers(TimedSensor[LineSensor, SensorFlaws]):
    """One accelerometer on each line; the angle of a line whose reading is lost is NaN."""

    def _mount(self, machine: Mounted) -> None:
        self._zeros = machine.angle_zeros()

    def _measure(self, state: RigState) -> LineAngles:
        settings, flaws, count = self.settings, self.flaws, len(state.apparent_angles)
        angles = state.apparent_angles + self._zeros + settings.deviation * self._random.standard_normal(count)
        chance, anywhere = self._random.random(count), self._random.random(count)
        if flaws.outliers:
            angles = np.where(chance > 1.0 - flaws.outliers, math.pi * anywhere - 0.5 * math.pi, angles)
        if min(chance.tolist()) < flaws.dropout:
            angles[chance < flaws.dropout] = np.nan
        angles.flags.writeable = False
        return LineAngles(state.truth.time, angles)


SIMULATED: Final = Simulated(LINE_ANGLES, SensorFlaws, LineAccelerometers)
