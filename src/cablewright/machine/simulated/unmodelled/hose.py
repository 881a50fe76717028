"""Force of a hose or cable chain that hangs from a point of the frame to the platform's origin.

An inextensible catenary: with u = w d / 2H over the horizontal distance d and the height h between its ends, sinh(u) /
u = sqrt(L^2 - h^2) / d (Irvine 1981). It touches nothing, and does not bend against its stiffness.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array

_TAUT: Final = 1.001  # lengths per distance of a hose that is too short: longer ones hang
_STEEP: Final = 1e-6  # of the length: least horizontal distance
_STEPS: Final = 60


class Hose:
    """The pull of a material hose on the platform."""

    def __init__(self, start: tuple[float, float, float], length: float, weight: float) -> None:
        """*start*: (3,) m, world, where it is fixed; *length*: m; *weight*: N/m."""
        self._start, self._length, self._weight = np.array(start), length, weight

    def pull(self, place: Array) -> Array:
        """Return the force (3,), N, world, on a platform at *place* (3,), m."""
        away = place - self._start
        distance, rise = math.hypot(away[0], away[1]), float(away[2])
        length = max(self._length, _TAUT * math.hypot(distance, rise))
        across = max(distance, _STEEP * length)
        slack = math.sqrt((length - rise) * (length + rise)) / across
        u = math.sqrt(6.0 * (slack - 1.0)) if slack < 3.0 else math.log(2.0 * slack) + math.log(math.log(2.0 * slack))
        for _ in range(_STEPS):
            step = (math.sinh(u) - slack * u) / (math.cosh(u) - slack)
            u -= step
            if abs(step) < 1e-14 * u:
                break
        level = 0.5 * self._weight * across / u  # N
        down = level * math.sinh(math.atanh(rise / length) + u)  # at the platform: of the hose below it
        toward = -away[:2] / distance if distance > 0.0 else np.zeros(2)
        return np.array([*(level * toward), -down])
