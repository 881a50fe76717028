"""Rotation and retraction of a rigid platform along a path, by the schedule of its job."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.rotation import matrices, matrix_of, motion_between
from cablewright.printing.schedule import Schedule, ScheduleStep


class Carried(NamedTuple):
    """Motion of a platform whose nozzle follows a path: motion of its origin, and rotation."""

    position: Array  # (3,) m, world, of the origin
    velocity: Array  # (3,) m/s
    rotation: Array  # (3,) rad
    rate: Array  # (3,) rad/s, world


@dataclass(frozen=True, eq=False)
class Attitude:
    """Settings of a platform's rotation and retraction along a path.

    ``schedule`` by the nozzle's height; ``nozzle`` (3,): m, platform frame.
    """

    schedule: Schedule
    nozzle: Array

    @classmethod
    def of(cls, steps: tuple[ScheduleStep, ...], nozzle: tuple[float, float, float]) -> Attitude:
        """Return the attitude from the schedule *steps* of a job, for a platform with its *nozzle* there, m."""
        return cls(Schedule(steps), np.array(nozzle))

    def rotations(self, heights: Array) -> Array:
        """Return the rotations (k, 3), rad, with the nozzle at *heights* (k,), m."""
        return self.schedule.rotations(heights) if self.schedule.turns else np.zeros((len(heights), 3))

    def nozzles_at(self, positions: Array, rotations: Array) -> Array:
        """Return the positions (k, 3), m, of the nozzle, with the origin at *positions* (k, 3)."""
        return np.asarray(positions + matrices(rotations) @ self.nozzle)

    def rotation(self, height: float) -> Array:
        """Return the rotation (3,), rad, with the nozzle at a *height*, m."""
        return np.asarray(self.schedule.rotations(np.array([height]))[0]) if self.schedule.turns else np.zeros(3)

    def retraction(self, height: float) -> float:
        """Return the retraction length, m, with the nozzle at a *height*, m; NaN: the schedule has none."""
        found = self.schedule.retractions(np.array([height]))
        return math.nan if found is None else float(found[0])

    def origin(self, nozzle: Array, rotation: Array) -> Array:
        """Return the position (3,), m, of the platform's origin with its *nozzle* (3,), m, there."""
        return np.asarray(nozzle - matrix_of(rotation) @ self.nozzle)

    def nozzle_at(self, position: Array, rotation: Array) -> Array:
        """Return the position (3,), m, of the nozzle, with the origin at *position*."""
        return np.asarray(position + matrix_of(rotation) @ self.nozzle)

    def carried(self, here: Array, there: Array, turned: Array, then: Array, dt: float) -> Carried:
        """Return the platform's mean motion over *dt*, s, as its nozzle moves from *here* to *there*, m.

        *turned*, *then*: rotations (3,), rad, at both ends.
        """
        begin = self.origin(here, turned)
        end = begin + (there - here) if turned.tolist() == then.tolist() else self.origin(there, then)
        twist = motion_between(np.concatenate([begin, turned]), np.concatenate([end, then])) / dt
        return Carried(begin, twist[:3], turned, twist[3:])
