"""Simulated planar lidar on the platform: its rays are cast one after another while the platform moves."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import SOURCES, Scan
from cablewright.kernels.plant.lidar_rays import turn_lidar
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.machine.simulated.as_built_room import FoundRoom, detours
from cablewright.machine.simulated.floor import Ground
from cablewright.machine.simulated.sensors.timed_sensor import steps_per_interval
from cablewright.machine.simulated.settings import LidarFlaws
from cablewright.machine.simulated.true_state import RigState

_FIRST: Final = -math.pi  # rad, of a turn's first ray


class SimulatedLidar:
    """One simulated lidar, whose range bias is drawn once."""

    SAVED = ("_poses", "_count", "_random")

    def __init__(
        self,
        source: str,
        settings: LidarSettings,
        flaws: LidarFlaws,
        room: FoundRoom,
        period: float,
        random: np.random.Generator,
    ) -> None:
        """The *room* is seen besides the floor; *period*: s, of a step.

        Raises `InputError` for a turn that is no whole number of steps.
        """
        self.source, self.settings, self.flaws = source, settings, flaws
        spread = settings.bias if flaws.bias is None else flaws.bias
        self.bias = float(spread * random.standard_normal())
        self._room, self._random = room, random
        self._steps = steps_per_interval(period, settings.turn, f"lidars.{source}.turn")
        x, y = np.array(settings.axes)
        self.mount = np.column_stack([x, y, np.cross(x, y), settings.place])  # (3, 4)
        self._masks = np.array(settings.masks, dtype=np.float64).reshape(-1, 2)
        self._poses, self._count = np.zeros((self._steps + 1, 7)), 0  # time and pose at so many steps of this turn

    def read(self, state: RigState) -> Scan | None:
        """Record the platform's pose; return a scan at the end of each revolution of the lidar, otherwise None."""
        truth = state.truth
        pose = self._poses[self._count]
        pose[0], pose[1:4], pose[4:] = truth.time, truth.position, truth.rotation
        self._count += 1
        if self._count <= self._steps:
            return None
        poses = self._poses.copy()
        self._poses[0], self._count = poses[-1], 1
        settings, middle = self.settings, poses[len(poses) // 2]
        begin, between = float(poses[0, 0]), settings.turn / settings.rays
        faces = self._room.faces(float(middle[0]), middle[1:3])
        ranges = self._cast(poses, faces, state.ground)
        found = self._find(ranges, poses, faces, state.ground)
        return Scan(self.source, begin, between, _FIRST, math.tau / settings.rays, self._add_noise(found))

    def after_load(self) -> None:
        """Raise `InputError` if the loaded state has more poses than one scan of the lidar takes."""
        if self._count > self._steps:
            raise InputError(
                f"snapshot: lidar {self.source!r}: has {self._count} poses of a scan, must be at most {self._steps}; "
                "load a snapshot of a machine with the same settings"
            )

    def _cast(self, poses: Array, faces: Array, ground: Ground) -> Array:
        """Return ranges (k,), m, of the rays of one scan along *poses* to *faces*, ceiling and *ground*."""
        settings, ranges = self.settings, np.empty(self.settings.rays)
        turn_lidar(
            np.ascontiguousarray(poses[:, 0]),
            np.ascontiguousarray(poses[:, 1:]),
            float(poses[0, 0]),
            settings.turn / settings.rays,
            _FIRST,
            math.tau / settings.rays,
            self.mount,
            self._masks,
            faces,
            self._room.ceiling,
            ground.grid,
            ground.heights,
            ranges,
        )
        return ranges

    def _find(self, ranges: Array, poses: Array, faces: Array, ground: Ground) -> Array:
        """Return measured ranges (k,), m, for true *ranges*: through glass, none of dark faces, with ghosts."""
        room, ghosts, count = self._room, self.flaws.ghosts, len(ranges)
        opaque, bright = room.without("glass", faces), room.without("dark", faces)
        if opaque is None and bright is None and not ghosts:
            return ranges
        random = room.random(SOURCES[self.source].stream, round(float(poses[0, 0]) / self.settings.turn))
        chance, found = random.random((2, count)), ranges
        if opaque is not None:
            passes = (self._cast(poses, opaque, ground) > ranges) & (chance[0] < room.law.glass_share)
            found = np.where(passes, self._cast(poses, room.behind_glass(faces), ground), found)
        if bright is not None:
            dies = (self._cast(poses, bright, ground) > ranges) & (chance[1] < room.law.dark_share)
            found = np.where(dies, np.inf, found)
        return found + detours(random, ghosts, count)

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
