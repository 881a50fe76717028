"""Simulated inertial measurement unit on the platform: accelerometer and gyro."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.signals import Inertial
from cablewright.kernels import Direct
from cablewright.kernels.plant import sensor_errors
from cablewright.machine.quantities import Size
from cablewright.machine.sensors.inertial import INERTIAL, InertialSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


_RANGE: Final = np.repeat([4.0 * 9.81, 8.7], 3)
"""Largest outliers: 4 g and 500 degrees per second, the range of such a unit."""


class InertialFlaws(SensorFlaws):
    """Flaws of an inertial unit. Biases: standard deviations, m/s^2 and rad/s; None: as on the data sheet."""

    acceleration_bias: Size | None = None
    rate_bias: Size | None = None


class InertialUnit(TimedSensor[InertialSensor, InertialFlaws]):
    """One simulated inertial unit; its biases are drawn once."""

    def _mount(self, machine: Mounted) -> None:
        self._gravity, self._place = machine.robot.scene.gravity, np.array(self.settings.place)
        self._axes = np.ascontiguousarray(machine.mounting(self.source))
        sheet, flaws = self.settings, self.flaws
        force = sheet.acceleration_bias if flaws.acceleration_bias is None else flaws.acceleration_bias
        turn = sheet.rate_bias if flaws.rate_bias is None else flaws.rate_bias
        self.bias = np.repeat([force, turn], 3) * self._random.standard_normal(6)
        self._deviation = np.repeat([sheet.acceleration_deviation, sheet.rate_deviation], 3)
        self._noise, self._draws, self._show = np.empty(6), np.empty(7), Direct(sensor_errors.show_motion)

    def _measure(self, state: RigState) -> Inertial | None:
        noise, draws = self._random.standard_normal(out=self._noise), self._random.random(out=self._draws)
        if self.flaws.dropout and draws[sensor_errors.CHANCE] < self.flaws.dropout:
            return None
        measured = np.empty(6)
        self._show.call(
            state.rotation, self._place, state.acceleration, state.told, self._gravity, self._axes, self.bias,
            self._deviation, self.flaws.outliers, _RANGE, noise, draws, measured,
        )  # fmt: skip
        measured.flags.writeable = False
        return Inertial(state.time, measured[:3], measured[3:])


SIMULATED: Final = Simulated(INERTIAL, InertialFlaws, InertialUnit)
