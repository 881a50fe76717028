"""Simulated planar lidar on the drum: its rays are cast one after another while the drum moves."""

from __future__ import annotations

import math

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.plant.lidar_rays import turn_lidar
from cablewright.machine.sensors import LidarSettings
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import LidarFlaws
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.timed_sensor import steps_per_interval
from cablewright.signals import Scan


class SimulatedLidar:
    """One lidar; its bias is drawn once."""

    def __init__(
        self,
        source: str,
        settings: LidarSettings,
        flaws: LidarFlaws,
        walls: Array,
        ceiling: float,
        period: float,
        random: np.random.Generator,
    ) -> None:
        """*walls* (j, 4) and *ceiling*, m, are seen besides the floor; *period*: s, of a step.

        Raises `InputError` for a turn that is no whole number of steps.
        """
        self.source, self.settings, self.flaws = source, settings, flaws
        spread = settings.bias if flaws.bias is None else flaws.bias
        self.bias = float(spread * random.standard_normal())
        self._walls, self._ceiling, self._random = walls, ceiling, random
        self._steps = steps_per_interval(period, settings.turn, f"lidars.{source}.turn")
        x, y = np.array(settings.axes)
        self.mount = np.column_stack([x, y, np.cross(x, y), settings.place])  # (3, 4)
        self._masks = np.array(settings.masks, dtype=np.float64).reshape(-1, 2)
        self._poses: list[Array] = []  # time and pose at each step of this turn

    def read(self, state: RigState) -> Scan | None:
        """Record the drum's pose; return a scan at the end of a turn."""
        truth = state.truth
        self._poses.append(np.concatenate([[truth.time], truth.position, truth.rotation]))
        if len(self._poses) <= self._steps:
            return None
        poses = np.array(self._poses)
        self._poses = self._poses[-1:]
        settings, ranges = self.settings, np.empty(self.settings.rays)
        begin, between = float(poses[0, 0]), settings.turn / settings.rays
        first, step = -math.pi, 2.0 * math.pi / settings.rays
        turn_lidar(
            np.ascontiguousarray(poses[:, 0]),
            np.ascontiguousarray(poses[:, 1:]),
            begin,
            between,
            first,
            step,
            self.mount,
            self._masks,
            self._walls,
            self._ceiling,
            state.ground.grid,
            state.ground.heights,
            ranges,
        )
        return Scan(self.source, begin, between, first, step, self._add_noise(ranges))

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._poses = archive.rows("poses", self._poses, 7, self._steps)
        archive.random("random", self._random)

    def _add_noise(self, ranges: Array) -> Array:
        """Add bias, noise, dropouts and outliers to *ranges* (k,), m; masked rays stay NaN."""
        settings, flaws, random, count = self.settings, self.flaws, self._random, len(ranges)
        measured = ranges + self.bias + settings.deviation * random.standard_normal(count)
        measured[~((measured >= settings.least) & (measured <= settings.most))] = np.nan
        chance, anywhere = random.random(count), random.uniform(settings.least, settings.most, count)
        measured = np.round(measured / settings.resolution) / (1.0 / settings.resolution)  # as its protocol counts
        measured[chance < flaws.dropout] = np.nan
        outlier = (chance > 1.0 - flaws.outliers) & ~np.isnan(ranges)
        measured[outlier] = np.round(anywhere[outlier], 3)
        measured.flags.writeable = False
        return measured
