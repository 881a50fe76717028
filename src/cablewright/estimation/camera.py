"""What a camera in the room shows wrong of the platform's pose, by small errors of the camera: both filters learn them.

A camera that is d from its place, turned by t, and whose focal length is short by a share s shows a point p, from a
place c with the axis a, at p - d + (p - c) x t + s a (a . (p - c)), and a rotation turned by -t. Its times are late by
one more number, and by as much again at random: rows of a picture are read one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import CameraPose

ERRORS: Final = 8
"""Number of a camera's errors: place (3), m, and direction (3), rad, along the world's axes, focal length, a share, and
its times, s."""

_LEAST: Final = np.repeat([1e-5, 1e-6], [3, 5])  # no camera is known better


@dataclass(frozen=True, eq=False)
class KnownCamera:
    """A camera as its data sheet has it: ``place`` (3,), m, unit vector ``axis`` (3,), ``sigmas`` (8,) of errors."""

    place: Array
    axis: Array
    sigmas: Array

    @classmethod
    def told(cls, sheet: Any) -> Self:
        """Return the camera of a data *sheet*."""
        sizes = sheet.place_deviation, sheet.turn_deviation, sheet.focal_deviation, sheet.time_deviation
        return cls(np.array(sheet.at), sheet.axes[:, 2], np.maximum(np.repeat(sizes, [3, 3, 1, 1]), _LEAST))

    def slopes(self, position: Array, velocity: Array) -> Array:
        """Return the change (6, 8) of a shown pose, translation and rotation in space, by each error.

        At a *position* (3,), m, with a *velocity* (6,), m/s and rad/s.
        """
        away, found = position - self.place, np.zeros((6, ERRORS))
        found[:3, :3] = found[3:, 3:6] = -np.eye(3)
        found[:3, 3:6] = np.cross(away, np.eye(3)).T
        found[:3, 6], found[:, 7] = self.axis * float(self.axis @ away), velocity
        return found

    def noise(self, reading: CameraPose, velocity: Array) -> Array:
        """Return the covariance (6, 6) of a *reading* of a platform with a *velocity* (6,), m/s and rad/s."""
        late = self.sigmas[7] * velocity
        return np.asarray(reading.spread + np.outer(late, late))
