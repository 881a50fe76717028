"""Drive train between a winch's motor and its cable: elastic, uneven gears, and cable that slides on the drum.

So motor counts and the cable paid out differ. Gears twist in proportion to the torque of the line; toothing moves the
drum by a sine of its own angle; and cable slides out under its pull, in proportion to the angle that the drum turns.
"""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.arrays import Array


class DrumDrive:
    """Lag of m drums behind their motors, rad of cable paid out. At the start it is 0."""

    SAVED = ("_angles", "_start", "_torque", "_twist", "slid")

    def __init__(
        self, torsion: float, ripple: tuple[float, float], slide: float, reference: float, angles: Array, phases: Array
    ) -> None:
        """*torsion*: rad per N m at the drum; *ripple*: rad, and periods of it in a turn; *phases* (m,), rad, of that.

        *slide*: share of the wound or paid-out length that slides out under the *reference*, N. *angles* (m,), rad,
        wound at the start.
        """
        self._torsion, (self._ripple, self._periods), self._slide = torsion, ripple, slide
        self._reference, self._phases, self._angles, self._start = reference, phases, angles.copy(), angles.copy()
        self._torque = np.full(len(angles), math.nan)  # N m, at the start
        self.slid = np.zeros(len(angles))  # rad
        self._twist = np.zeros(len(angles))  # rad

    @property
    def lag(self) -> Array:
        """Lag (m,) of the drums, rad."""
        return np.asarray(self._rippled(self._start) - self._rippled(self._angles) - self._twist - self.slid)

    def turn(self, angles: Array, pulls: Array, radii: Array, softness: Array) -> None:
        """Turn the motors to *angles* (m,), rad wound, under *pulls* (m,), N, at *radii* (m,), m.

        *softness* (m,): m/N, by which the lines stretch.
        """
        torque = pulls * radii
        if np.isnan(self._torque).any():
            self._torque = torque
        # torque and twist follow each other: in each step as far as between fixed points
        share = 1.0 / (1.0 + self._torsion * radii * radii / softness)
        self._twist = self._twist + share * (self._torsion * (torque - self._torque) - self._twist)
        self.slid = self.slid + self._slide * pulls / self._reference * np.abs(angles - self._angles)
        self._angles = angles.copy()

    def _rippled(self, angles: Array) -> Array:
        return np.asarray(self._ripple * np.sin(self._periods * angles + self._phases))
