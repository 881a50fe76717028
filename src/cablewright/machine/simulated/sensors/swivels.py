"""Simulated encoders of swivelling sheaves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.signals import Swivels
from cablewright.machine.sensors.swivels import SWIVELS, SwivelSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor
from cablewright.robot import Swivel

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class SwivelReader(TimedSensor[SwivelSensor, SensorFlaws]):
    """Angles of all swivels, read at the same time; their zeros are drawn once."""

    def _mount(self, machine: Mounted) -> None:
        self._swivels = np.array([isinstance(line.sheave, Swivel) for line in machine.robot.lines])
        self._zeros = self.settings.bias * self._random.standard_normal(machine.robot.m)

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


SIMULATED: Final = Simulated(SWIVELS, SensorFlaws, SwivelReader, place=9)
