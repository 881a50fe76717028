"""Simulated distance sensor at the nozzle: along the drum's or the body's z, to the floor or what lies on it."""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.plant.lidar_rays import ray_to_floor
from cablewright.machine.sensors import DistanceSensor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import SensorFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import Distance


class Rangefinder(TimedSensor[DistanceSensor, SensorFlaws]):
    """One distance sensor; its reading is NaN where nothing comes back."""

    def __init__(
        self,
        key: str,
        settings: DistanceSensor,
        flaws: SensorFlaws,
        period: float,
        random: np.random.Generator,
        nozzle: Array,
        mounting: Array,
    ) -> None:
        """Place it at *nozzle* (3,), m, turned by *mounting* (3, 3), in the drum's frame; else as `TimedSensor`."""
        super().__init__(key, settings, flaws, period, random)
        self._nozzle, self._way = nozzle, -mounting[:, 2]

    def _measure(self, state: RigState) -> Distance:
        settings, flaws, ground = self.settings, self.flaws, state.ground
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        x, y, z = state.truth.position + state.rotation @ self._nozzle
        down = state.rotation @ self._way
        if down[2] >= 0.0:  # lies on its side: sees no floor
            return Distance(state.truth.time, float("nan"))
        found = ray_to_floor(x, y, z, *down.tolist(), settings.most, ground.grid, ground.heights)
        measured = found + settings.deviation * noise
        if not settings.least <= measured <= settings.most or chance < flaws.dropout:
            measured = float("nan")
        elif chance > 1.0 - flaws.outliers:
            measured = settings.least + anywhere * (settings.most - settings.least)
        return Distance(state.truth.time, float(measured))
