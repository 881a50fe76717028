"""Angle of a winch's drum by the length of its line: of a bare drum, with a build-up, or with layers of cable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.coil import TURN, Coil
from cablewright.robot import Line


@dataclass(frozen=True, eq=False)
class WinchDrum:
    """A drum that pays out a line. ``radius``: m, of a drum with one layer; or a ``coil`` of ``held`` m of cable.

    The coil has wound what is not in the line; its length and that of the line add up to ``held``. A drum without a
    coil may have a ``build_up``, 1/m: it has its radius where the line is ``at`` m long, and the square of the radius
    falls by 2 build_up radius^2 per length paid out, the law of RepRapFirmware's Hangprinter.
    """

    radius: float
    coil: Coil | None = None
    held: float = 0.0
    build_up: float = 0.0
    at: float = 0.0

    def angles(self, lengths: Array) -> Array:
        """Return the angles (k,), rad, at which the line has *lengths* (k,), m; they rise as the drum pays out.

        Of a bare drum they count from a line without length, with a build-up from the length at which the drum has its
        radius, of a coil from the empty drum, so they are negative there.
        Raises `InputError` for a length that the drum does not hold.
        """
        if self.coil is None:
            if self.build_up == 0.0:
                return np.asarray(lengths / self.radius)
            return 2.0 * (lengths - self.at) / (self.radius + self.radii(lengths))  # their integral, dL over radius
        wound = self.held - lengths
        low, high = float(wound.min()), float(wound.max())
        if low < 0.0 or high > self.coil.wound[-1]:
            reach = f"{self.held - min(self.held, float(self.coil.wound[-1])):g} to {self.held:g} m"
            raise InputError(f"lengths of {lengths.min():g} to {lengths.max():g} m: the winch pays out {reach}")
        return np.array([-self.coil.angle(float(each)) for each in wound])

    def lengths(self, angles: Array) -> Array:
        """Return the lengths (k,), m, at *angles* (k,), rad: the inverse of `angles`."""
        if self.coil is None:
            return np.asarray(self.at + self.radius * angles * (1.0 - 0.5 * self.build_up * self.radius * angles))
        return np.array([self.held - self.coil.length(float(-each)) for each in angles])

    def radii(self, lengths: Array) -> Array:
        """Return the radii, m, at which the cable leaves the drum where the line has *lengths*, m; NaN where NaN.

        Raises `InputError` for a length that the drum does not hold.
        """
        if self.coil is not None:
            flat = [self.coil.radius(self.coil.angle(self.held - float(each))) for each in np.ravel(lengths)]
            return np.reshape(flat, np.shape(lengths))
        share = 1.0 - 2.0 * self.build_up * (lengths - self.at)
        if np.any(share <= 0.0):
            longest = self.at + 0.5 / self.build_up
            raise InputError(f"winch.build_up = {self.build_up:g} 1/m: the drum is empty with a line of {longest:g} m")
        return np.asarray(self.radius * np.sqrt(share))

    def per_turn(self, length: float) -> float:
        """Return the cable that one turn pays out, m, where the line is *length* m long."""
        return TURN * float(self.radii(np.asarray(length)))


def drum_of(line: Line) -> WinchDrum | None:
    """Return the drum of a line by its robot file; None where the radius is unknown."""
    winch = line.winch
    if winch.drum_radius is None:
        return None
    if winch.build_up is None or winch.drum_length is None:
        return WinchDrum(winch.drum_radius)
    return WinchDrum(winch.drum_radius, build_up=winch.build_up, at=winch.drum_length)
