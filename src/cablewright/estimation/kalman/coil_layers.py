"""Steps of a winch drum's radius at the ends of its cable layers, whose positions are known to half a revolution."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.coil import TURN, Coil

_STEP: Final = 0.02  # m, of the table
_QUANTILES: Final = np.array([NormalDist().inv_cdf((k + 0.5) / 41.0) for k in range(41)])
_SURE: Final = 0.1  # revolutions: smallest error of an end


class CoilLayers:
    """Expected radii of m winch drums by the length that is paid out.

    The end of a layer is known with the standard deviation that irregular turns add up to: *deviation* of each radius,
    m, correlated over *turns*. There the expected radius changes from one layer's to the next, and `doubt` is how much
    of the step may come within one revolution.
    """

    def __init__(
        self, coils: Sequence[Coil], total_length: float, pitch: float, deviation: float, turns: float
    ) -> None:
        """*coils*: coils of the lines in their regular state, each with *total_length* of cable, m.

        *pitch*: pitch of their layers, m.
        """
        self._pitch = pitch
        out = np.arange(0.0, total_length, _STEP)
        self._table = np.array([_expected(coil, total_length - out, deviation, turns) for coil in coils])
        self._lines = np.arange(len(coils))

    def radii(self, lengths: Array) -> Array:
        """Return the expected radius (m,), m, of each drum with *lengths* (m,), m, out."""
        place = np.clip(lengths / _STEP, 0.0, self._table.shape[1] - 1.001)
        below = place.astype(np.intp)
        low, high = self._table[self._lines, below], self._table[self._lines, below + 1]
        return np.asarray(low + (place - below) * (high - low))

    def doubt(self, change: Array, radii: Array) -> Array:
        """Return the variance (m,) of each radius, as a share, after an expected *change* (m,), m, of *radii* (m,).

        A step of one pitch comes somewhere in the change with the probability change / pitch.
        """
        return np.asarray(self._pitch * np.abs(change) / radii**2)


def _expected(coil: Coil, wound: Array, deviation: float, turns: float) -> Array:
    """Mean radius (k,), m, over all places where the layers of a *coil* may end, with the length *wound* (k,), m."""
    regular = np.array([coil.angle(float(each)) / TURN for each in wound])
    radii = np.interp(regular, np.arange(len(coil.radii)), coil.radii)
    off = deviation / radii * np.sqrt(2.0 * turns * regular)  # revolutions, error of the sum of all
    places = regular[:, None] + np.maximum(off, _SURE)[:, None] * _QUANTILES
    return np.asarray(np.interp(places, np.arange(len(coil.radii)), coil.radii).mean(axis=1))
