"""Simulated encoders of swivelling sheaves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.signals import Swivels
from cablewright.kernels import Direct
from cablewright.kernels.plant import sensor_errors
from cablewright.machine.sensors.swivels import SWIVELS, SwivelSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor
from cablewright.robot import Swivel

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class SwivelReader(TimedSensor[SwivelSensor, SensorFlaws]):
    """Angles of all swivels, read at the same time; their zeros are drawn once."""

    def _mount(self, machine: Mounted) -> None:
        flaws, m = self.flaws, machine.robot.m
        self._swivels = np.array([isinstance(line.sheave, Swivel) for line in machine.robot.lines])
        self._zeros = self.settings.bias * self._random.standard_normal(m)
        self._numbers = np.array([self.settings.deviation, flaws.dropout, flaws.outliers])
        self._noise, self._chance, self._show = np.empty(m), np.empty(2 * m), Direct(sensor_errors.show_swivels)

    def _measure(self, state: RigState) -> Swivels:
        noise, chance = self._random.standard_normal(out=self._noise), self._random.random(out=self._chance)
        shown = np.empty(len(noise))
        self._show.call(state.told, self._swivels, self._zeros, self._numbers, noise, chance, shown)
        shown.flags.writeable = False
        return Swivels(state.time, shown)


SIMULATED: Final = Simulated(SWIVELS, SensorFlaws, SwivelReader, place=9)
