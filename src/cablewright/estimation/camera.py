"""What a camera in the room shows wrong of the platform's pose, by small errors of the camera: both filters learn them.

A camera that is d from its place, turned by t, and whose focal length is short by a share s shows a point p, from a
place c with the axis a, at p - d + (p - c) x t + s a (a . (p - c)), and a rotation turned by -t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import CameraPose

ERRORS: Final = 7
"""Number of a camera's errors: place (3), m, and direction (3), rad, along the world's axes, and focal length, a share."""

_LEAST: Final = np.array([1e-5, 1e-5, 1e-5, 1e-6, 1e-6, 1e-6, 1e-6])  # no camera is known better


@dataclass(frozen=True, eq=False)
class KnownCamera:
    """A camera as its data sheet has it: ``place`` (3,), m, ``axis`` (3,), a unit vector, ``sigmas`` (7,) of its errors.

    ``time_sigma``: s, of all its times together.
    """

    place: Array
    axis: Array
    sigmas: Array
    time_sigma: float

    @classmethod
    def told(cls, sheet: Any) -> Self:
        """Return the camera of a data *sheet*."""
        spread = np.repeat([sheet.place_deviation, sheet.turn_deviation, sheet.focal_deviation], [3, 3, 1])
        return cls(np.array(sheet.at), sheet.axes[:, 2], np.maximum(spread, _LEAST), sheet.time_deviation)

    def slopes(self, position: Array) -> Array:
        """Return the change (6, 7) of a shown pose, translation and rotation in space, by each error, at *position*."""
        away, found = position - self.place, np.zeros((6, ERRORS))
        found[:3, :3] = found[3:, 3:6] = -np.eye(3)
        found[:3, 3:6] = np.cross(away, np.eye(3)).T
        found[:3, 6] = self.axis * float(self.axis @ away)
        return found

    def noise(self, reading: CameraPose, velocity: Array) -> Array:
        """Return the covariance (6, 6) of a *reading* of a platform with a *velocity* (6,), m/s and rad/s."""
        late = self.time_sigma * velocity
        return np.asarray(reading.spread + np.outer(late, late))
