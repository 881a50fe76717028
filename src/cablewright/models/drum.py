"""Angle of a winch's drum by the length of its line: of a bare drum, or of one with layers of cable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.coil import TURN, Coil


@dataclass(frozen=True, eq=False)
class Drum:
    """A drum that pays out a line. ``radius``: m, of a drum with one layer; or a ``coil`` of ``held`` m of cable.

    The coil has wound what is not in the line; its length and that of the line add up to ``held``.
    """

    radius: float
    coil: Coil | None = None
    held: float = 0.0

    def angles(self, lengths: Array) -> Array:
        """Return the angles (k,), rad, at which the line has *lengths* (k,), m; they rise as the drum pays out.

        Of a bare drum they count from a line without length, of a coil from the empty drum, so they are negative there.
        Raises `InputError` for a length that the drum does not hold.
        """
        if self.coil is None:
            return np.asarray(lengths / self.radius)
        wound = self.held - lengths
        low, high = float(wound.min()), float(wound.max())
        if low < 0.0 or high > self.coil.wound[-1]:
            reach = f"{self.held - min(self.held, float(self.coil.wound[-1])):g} to {self.held:g} m"
            raise InputError(f"lengths of {lengths.min():g} to {lengths.max():g} m: the winch pays out {reach}")
        return np.array([-self.coil.angle(float(each)) for each in wound])

    def lengths(self, angles: Array) -> Array:
        """Return the lengths (k,), m, at *angles* (k,), rad: the inverse of `angles`."""
        if self.coil is None:
            return np.asarray(angles * self.radius)
        return np.array([self.held - self.coil.length(float(-each)) for each in angles])

    def per_turn(self, length: float) -> float:
        """Return the cable that one turn pays out, m, where the line is *length* m long."""
        if self.coil is None:
            return TURN * self.radius
        return TURN * self.coil.radius(self.coil.angle(self.held - length))
