"""Simulated distance sensor at the nozzle: along the platform's z, to the floor or the laid material."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from cablewright.foundation.signals import Distance
from cablewright.machine.sensors.distance import DISTANCE, DistanceSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


class Rangefinder(TimedSensor[DistanceSensor, SensorFlaws]):
    """One simulated distance sensor; its reading is NaN where no echo comes back."""

    def _mount(self, machine: Mounted) -> None:
        self._nozzle, self._way = machine.nozzle, -machine.mounting(self.source)[:, 2]

    def _measure(self, state: RigState) -> Distance:
        settings, flaws, ground = self.settings, self.flaws, state.ground
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        x, y, z = state.truth.position + state.rotation @ self._nozzle
        down = state.rotation @ self._way
        if down[2] >= 0.0:  # lies on its side: sees no floor
            return Distance(state.time, float("nan"))
        found = ground.distance((x, y, z), down, settings.most)
        measured = found + settings.deviation * noise
        if not settings.least <= measured <= settings.most or chance < flaws.dropout:
            measured = float("nan")
        elif chance > 1.0 - flaws.outliers:
            measured = settings.least + anywhere * (settings.most - settings.least)
        return Distance(state.time, float(measured))


SIMULATED: Final = Simulated(DISTANCE, SensorFlaws, Rangefinder)
