"""Simulated accelerometers on the lines near B: angle of the cable, with its vibration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.signals import LineAngles
from cablewright.kernels import Direct
from cablewright.kernels.plant import sensor_errors
from cablewright.machine.sensors.line_angles import LINE_ANGLES, LineSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class LineAccelerometers(TimedSensor[LineSensor, SensorFlaws]):
    """One accelerometer on each line; the angle of a line whose reading is lost is NaN."""

    def _mount(self, machine: Mounted) -> None:
        self._zeros, flaws = machine.angle_zeros(), self.flaws
        m = len(self._zeros)
        self._numbers = np.array([self.settings.deviation, flaws.dropout, flaws.outliers])
        self._noise, self._chance, self._show = np.empty(m), np.empty(2 * m), Direct(sensor_errors.show_angles)

    def _measure(self, state: RigState) -> LineAngles:
        noise, chance = self._random.standard_normal(out=self._noise), self._random.random(out=self._chance)
        angles = np.empty(len(noise))
        self._show.call(state.told, self._zeros, self._numbers, noise, chance, angles)
        angles.flags.writeable = False
        return LineAngles(state.time, angles)


SIMULATED: Final = Simulated(LINE_ANGLES, SensorFlaws, LineAccelerometers)
