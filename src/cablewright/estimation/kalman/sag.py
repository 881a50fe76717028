"""Excess length and angle of hanging lines by their horizontal forces, and the forces that balance the platform.

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
from cablewright.kernels.filtering import sagging_lines as kernel
from cablewright.solvers.taut import Taut

_MIN_FORCE: Final = 0.5  # N, of a line that hangs as a parabola
_FREEDOMS: Final = 3


class Sag(NamedTuple):
    """Relations of force, excess length and angle of all lines at one position of B."""

    laws: Array  # (LAWS, m), see `kernels.filtering.sagging_lines`

    @classmethod
    def at(cls, sensors: SlacknessSettings, taut: Taut, compliances: Array) -> Sag:
        """Return the relations of lines whose *taut* shapes are given.

        *compliances* (m,): relative to those described.
        """
        laws, straight = np.empty((kernel.LAWS, len(compliances))), (taut.angles, taut.free, taut.lengths, taut.toward)
        kernel.laws_of(sensors.model.packed.lines, *straight, compliances, sensors.from_platform, laws)
        return cls(laws)

    def excess(self, forces: Array) -> Array:
        """Excess (..., m), m, by horizontal *forces* (..., m), N."""
        return np.asarray(self.laws[kernel.SAGGING] / forces**2 - self.laws[kernel.STRETCHING] * forces)

    def forces(self, excess: Array) -> Array:
        """Horizontal forces (m,), N, of lines with an *excess* (m,), m."""
        found = np.empty(len(excess))
        kernel.forces_of(self.laws, excess, found)
        return found


class Balanced(NamedTuple):
    """Possible horizontal forces: a first set plus a share, from 0 to 1, of a change; and the uncertainty of both.

    ``unsure``: how both change with q numbers of standard deviation 1.
    """

    forces: Array  # (2, m) N: the first, and the change
    unsure: Array  # (2, m, q) N


def balanced(sensors: SlacknessSettings, taut: Taut, weight: float, weight_sigma: float) -> Balanced | None:
    """Return the forces of at most four lines that hold a *weight*, N, at one position, known to *weight_sigma*, N.

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
        return (
            Balanced(np.stack([some, np.zeros(m)]), np.stack([unsure, nothing])) if (some >= _MIN_FORCE).all() else None
        )
    along = np.linalg.svd(pulls)[2][-1]  # the forces that balance each other
    limits = (_MIN_FORCE - some) / along
    low, high = np.where(along > 0.0, limits, -np.inf), np.where(along < 0.0, limits, np.inf)
    least, most = int(np.argmax(low)), int(np.argmin(high))
    if not (np.isfinite([low[least], high[most]]).all() and low[least] < high[most]):
        return None
    # at both ends the line that is slack there stays so, however heavy the drum is
    ends = [unsure - np.outer(along, unsure[line] / along[line]) for line in (least, most)]
    forces = np.stack([some + low[least] * along, (high[most] - low[least]) * along])
    return Balanced(forces, np.stack([ends[0], ends[1] - ends[0]]))


def each_alone(forces: Array) -> Balanced:
    """Return *forces* (m,), N, as completely uncertain: a line's angle then shows its own excess alone."""
    own = np.diag(forces)
    return Balanced(np.stack([forces, np.zeros(len(forces))]), np.stack([own, np.zeros_like(own)]))
