"""Simulated load cells at the sheaves, or torques of the motors, as tensions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Tensions, frozen
from cablewright.kernels import Direct
from cablewright.kernels.plant import sensor_errors
from cablewright.kernels.plant.machine_step import WINCH_PULLS
from cablewright.machine.quantities import Share, Size
from cablewright.machine.sensors.tensions import LOAD_CELLS, MOTOR_TORQUES, TensionSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor
from cablewright.models.winch_lines import WinchLines

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


_HOUR: Final = 3600.0  # s


class TensionFlaws(SensorFlaws):
    """Flaws of load cells or torques. ``bias``: standard deviation of a unit's zero, N; None: as on the data sheet.

    ``drift``: standard deviation of the zero's drift after an hour, N. ``cross_talk``: share of the mean of
    both neighbouring lines' tensions that a line shows in addition.
    """

    bias: Size | None = None
    drift: Size = 0.0
    cross_talk: Share = 0.0


class TensionSensors(TimedSensor[TensionSensor, TensionFlaws]):
    """Simulated tension sensors, one for each line. Their zeros are drawn once and then drift as a random walk."""

    SAVED = (*TimedSensor.SAVED, "_zeros")

    def _mount(self, machine: Mounted) -> None:
        spread = self.settings.bias if self.flaws.bias is None else self.flaws.bias
        self._zeros = spread * self._random.standard_normal(machine.robot.m)  # N
        self._winches = winches = WinchLines.of(machine.robot)
        self._shared = ~winches.alone[winches.hosts]  # (w,)
        self._cables = np.array([line.cables for line in machine.robot.lines])
        self._factors = 1.0 + machine.tension_gains(self.source)
        settings, flaws, m = self.settings, self.flaws, machine.robot.m
        drift = math.hypot(flaws.drift, machine.tolerances.tension_drift * settings.most)
        walk, own = drift * math.sqrt(1.0 / (settings.rate * _HOUR)), (flaws.dropout, flaws.outliers)
        self._numbers = np.array([settings.deviation, *own, settings.most, walk, flaws.cross_talk])
        self._noise, self._chance, self._pulls = np.empty(2 * m), np.empty(2 * m), np.empty(m)
        self._pull, self._show = Direct(sensor_errors.pull_of_cells), Direct(sensor_errors.show_tensions)

    def _measure(self, state: RigState) -> Tensions:
        # a motor sees the winch's side of the sheave, a load cell on its axle the mean of both
        by_motors, winches, arms = self.source == "motor_torques", self._winches, self._cables * state.truth.radii
        if by_motors:  # a motor holds all cables of its drum: as a tension of the line that it is named for
            self._pulls[:] = state.of_lines(WINCH_PULLS)
            shared = winches.hosts[self._shared]
            self._pulls[shared] = winches.torques(self._pulls, arms)[self._shared] / arms[shared]
        else:
            self._pull.call(state.told, self._pulls)
        noise, chance = self._random.standard_normal(out=self._noise), self._random.random(out=self._chance)
        shown = np.empty(len(self._pulls))
        self._show.call(self._pulls, self._factors, self._zeros, self._numbers, noise, chance, shown)
        shown.flags.writeable = False
        if not by_motors:
            return Tensions(self.source, state.time, shown)
        torques = frozen(shown[winches.hosts] * arms[winches.hosts])
        return Tensions(self.source, state.time, frozen(np.where(winches.alone, shown, np.nan)), torques)


def _offset(offsets: Array, _: Mounted) -> Array:
    """Return what a reading shows too much, (m,) N."""
    return offsets


CELLS: Final = Simulated(LOAD_CELLS, TensionFlaws, TensionSensors, {"offset": _offset}, place=11)
TORQUES: Final = Simulated(MOTOR_TORQUES, TensionFlaws, TensionSensors, {"offset": _offset}, place=12)
