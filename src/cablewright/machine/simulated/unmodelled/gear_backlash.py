"""Backlash of a winch's gear: the drum may deviate from the position that the motor's encoder shows.

A line that pulls turns its drum against one flank, always the same: nothing is lost however the motor turns. A line
that pulls less than the bearings' friction leaves the drum where it stands until the other flank takes it along.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array


class GearBacklash:
    """Lag of m drums behind their motors by backlash."""

    SAVED = ("_angles", "lag")

    def __init__(self, backlash: float, bearing_friction: float, angles: Array) -> None:
        """*backlash*: rad at the drum; *bearing_friction*: N of a line's pull; *angles* (m,), rad, wound at first."""
        self._backlash, self._friction = backlash, bearing_friction
        self._angles = angles.copy()
        self.lag = np.zeros(len(angles))  # rad, by which the drum has paid out less than the motor says

    def turn(self, angles: Array, pulls: Array) -> None:
        """Turn the motors to *angles* (m,), rad wound, with *pulls* (m,), N, at the drums."""
        held = np.minimum(np.maximum(self.lag + self._angles - angles, 0.0), self._backlash)
        self.lag = held * (pulls < self._friction)
        self._angles = angles
