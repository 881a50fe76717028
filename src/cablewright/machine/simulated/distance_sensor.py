"""The distance sensor under the valve: down the drum's axis to the floor, or what lies on it."""

from __future__ import annotations

import numpy as np

from cablewright.kernels.plant.lidar_rays import ray_to_floor
from cablewright.machine.simulated.rig import Moment
from cablewright.machine.simulated.settings import DistanceSensor
from cablewright.machine.simulated.snapshot import Book
from cablewright.machine.simulated.ticks import every
from cablewright.signals import DistanceReading

__all__ = ["Rangefinder"]


class Rangefinder:
    """One unit."""

    def __init__(self, settings: DistanceSensor, valve: float, period: float, random: np.random.Generator) -> None:
        """Mount it *valve* (m) below B. Raises `InputError` for a rate that does not fit the *period*, s."""
        self.settings, self._valve, self._random = settings, valve, random
        self._every, self._step = every(period, 1.0 / settings.rate, f"distance.rate = {settings.rate:g} Hz"), 0

    def read(self, moment: Moment) -> DistanceReading | None:
        """Return a reading when one is due; NaN where nothing comes back."""
        self._step += 1
        if self._step % self._every:
            return None
        settings, ground = self.settings, moment.ground
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        down = -moment.rotation[:, 2]
        x, y, z = moment.truth.position + self._valve * down
        if down[2] >= 0.0:  # lies on its side: sees no floor
            return DistanceReading(moment.truth.time, float("nan"))
        found = ray_to_floor(x, y, z, *down.tolist(), settings.most, ground.grid, ground.heights)
        told = found + settings.deviation * noise
        if not settings.least <= told <= settings.most or chance < settings.dropout:
            told = float("nan")
        elif chance > 1.0 - settings.outliers:
            told = settings.least + anywhere * (settings.most - settings.least)
        return DistanceReading(moment.truth.time, float(told))

    def keep(self, book: Book) -> None:
        """Note, or take up again, what decides on the next readings."""
        self._step = book.count("step", self._step)
        book.random("random", self._random)
