"""Simulated distance sensor under the valve: along the drum's axis to the floor or what lies on it."""

from __future__ import annotations

import numpy as np

from cablewright.kernels.plant.lidar_rays import ray_to_floor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import DistanceSensor
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.ticks import steps_per_interval
from cablewright.signals import Distance


class Rangefinder:
    """One distance sensor."""

    def __init__(self, settings: DistanceSensor, valve: float, period: float, random: np.random.Generator) -> None:
        """Place it *valve* (m) below B. Raises `InputError` for a rate that does not fit the *period*, s."""
        self.settings, self._valve, self._random = settings, valve, random
        self._interval, self._step = (
            steps_per_interval(period, 1.0 / settings.rate, f"distance.rate = {settings.rate:g} Hz"),
            0,
        )

    def read(self, state: RigState) -> Distance | None:
        """Return a reading when one is due; NaN where nothing comes back."""
        self._step += 1
        if self._step % self._interval:
            return None
        settings, ground = self.settings, state.ground
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        down = -state.rotation[:, 2]
        x, y, z = state.truth.position + self._valve * down
        if down[2] >= 0.0:  # lies on its side: sees no floor
            return Distance(state.truth.time, float("nan"))
        found = ray_to_floor(x, y, z, *down.tolist(), settings.most, ground.grid, ground.heights)
        measured = found + settings.deviation * noise
        if not settings.least <= measured <= settings.most or chance < settings.dropout:
            measured = float("nan")
        elif chance > 1.0 - settings.outliers:
            measured = settings.least + anywhere * (settings.most - settings.least)
        return Distance(state.truth.time, float(measured))

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._step = archive.count("step", self._step)
        archive.random("random", self._random)
