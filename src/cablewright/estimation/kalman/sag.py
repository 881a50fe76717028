"""Excess and angle of hanging lines by their horizontal forces, and the forces that balance the drum's weight.

A line with the horizontal force h hangs as a parabola: its excess over the taut length is a / h^2 for its sag less c h
for its stretch, and near the platform it descends less steeply than the straight line by a slope of r / h. At the
platform it pulls with h towards the sheave, upwards with h times the straight line's slope, and down with half of its
weight: linear in h. So with one line more than degrees of freedom one number describes all forces, slack lines or not.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.slackness import SlacknessSettings
from cablewright.foundation.arrays import Array
from cablewright.solvers.taut import Taut, stretches

_FORCES: Final = np.geomspace(0.2, 2e4, 160)  # N: of the tables by which an excess gives the force
_MIN_FORCE: Final = 0.5  # N, of a line that hangs as a parabola
_FREEDOMS: Final = 3
_LEAST_SHARE: Final = 1e-4  # of the range of the unknown force


class Sag(NamedTuple):
    """The laws of all lines at one position of B; (m,) arrays."""

    sagging: Array  # N^2 m: a
    stretching: Array  # m/N: c
    rising: Array  # N: r, at the sensor
    slopes: Array  # of the straight lines, seen from the sheave: negative downwards
    angles: Array  # rad, of the straight lines

    @classmethod
    def at(cls, sensors: SlacknessSettings, taut: Taut, compliances: Array) -> Sag:
        """Return the laws of lines that are *taut* there, by *compliances* (m,) as shares of those described."""
        lines, cosine = sensors.model.lines, np.cos(taut.angles)
        return cls(
            lines.spans * (lines.weight * taut.free * cosine**2) ** 2 * taut.free / 24.0,
            compliances * stretches(lines, taut) / cosine,
            lines.weight * (0.5 * taut.free - sensors.from_platform),
            np.tan(taut.angles),
            taut.angles,
        )

    def excess(self, forces: Array) -> Array:
        """Excess (..., m), m, by horizontal *forces* (..., m), N."""
        return np.asarray(self.sagging / forces**2 - self.stretching * forces)

    def excess_slopes(self, forces: Array) -> Array:
        """Derivative of the excess by the force, m/N."""
        return np.asarray(-2.0 * self.sagging / forces**3 - self.stretching)

    def differences(self, forces: Array) -> Array:
        """Angle near the platform less that of the straight line (..., m), rad."""
        return np.asarray(np.arctan(self.slopes + self.rising / forces) - self.angles)

    def difference_slopes(self, forces: Array) -> Array:
        """Derivative of the difference by the force, rad/N."""
        return np.asarray(-self.rising / (forces**2 * (1.0 + (self.slopes + self.rising / forces) ** 2)))

    def forces(self, excess: Array) -> Array:
        """Horizontal forces (m,), N, of lines with an *excess* (m,), m."""
        table = self.excess(_FORCES[:, None])
        found = [np.interp(-each, -column, _FORCES) for each, column in zip(excess, table.T, strict=True)]
        return np.array(found)


class Balanced(NamedTuple):
    """Horizontal forces that may be: ``first + share * change``, a share from 0 to 1, and what is not sure in both."""

    first: Array  # (m,) N
    change: Array  # (m,) N
    first_unsure: Array  # (m, j) N: how it changes with j numbers of standard deviation 1
    change_unsure: Array  # (m, j) N

    def forces(self, shares: Array) -> Array:
        """Forces (k, m), N, by *shares* (k,)."""
        return np.asarray(self.first + shares[:, None] * self.change)

    def unsure(self, shares: Array) -> Array:
        """How forces change with the j numbers, (k, m, j), N, by *shares* (k,)."""
        return np.asarray(self.first_unsure + shares[:, None, None] * self.change_unsure)


def share_at(places: Array) -> Array:
    """Shares (k,) by *places* (k,) from 0 to 1, dense at both ends, where a line is slack and its excess steep."""
    near = np.minimum(places, 1.0 - places)
    share = _LEAST_SHARE * (0.5 / _LEAST_SHARE) ** (2.0 * near)
    return np.asarray(np.where(places <= 0.5, share, 1.0 - share))


def balanced(sensors: SlacknessSettings, taut: Taut, weight: float, weight_sigma: float) -> Balanced | None:
    """Return the forces that hold a *weight*, N, at one position, known to *weight_sigma*, N, by at most four lines.

    None for more lines, or where no forces of pulling lines hold it.
    """
    lines = sensors.model.lines
    level = np.hypot(taut.toward[:, 0], taut.toward[:, 1])
    pulls = lines.pulls * np.vstack(
        [-(taut.toward[:, :2] / level[:, None]).T, -np.tan(taut.angles)]
    )  # (3, m) per force
    m = pulls.shape[1]
    if m > _FREEDOMS + 1:
        return None
    load = np.array([0.0, 0.0, weight + 0.5 * float((lines.pulls * lines.weight * taut.free).sum())])
    inverse = np.linalg.pinv(pulls)
    some, unsure = inverse @ load, weight_sigma * inverse[:, 2:]
    if m <= _FREEDOMS:
        nothing = np.zeros_like(unsure)
        return Balanced(some, np.zeros(m), unsure, nothing) if (some >= _MIN_FORCE).all() else None
    along = np.linalg.svd(pulls)[2][-1]  # the forces that balance each other
    limits = (_MIN_FORCE - some) / along
    low, high = np.where(along > 0.0, limits, -np.inf), np.where(along < 0.0, limits, np.inf)
    least, most = int(np.argmax(low)), int(np.argmin(high))
    if not (np.isfinite([low[least], high[most]]).all() and low[least] < high[most]):
        return None
    # at both ends the line that is slack there stays so, however heavy the drum is
    ends = [unsure - np.outer(along, unsure[line] / along[line]) for line in (least, most)]
    return Balanced(some + low[least] * along, (high[most] - low[least]) * along, ends[0], ends[1] - ends[0])


def each_alone(forces: Array) -> Balanced:
    """Return *forces* (m,), N, of which nothing is sure: a line's angle then shows its own excess alone."""
    return Balanced(forces, np.zeros(len(forces)), np.diag(forces), np.zeros((len(forces), len(forces))))
