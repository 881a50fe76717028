"""Control of slack: which line is slack, and by how much (Merlet and Papegay 2023, III.B).

With more lines than degrees of freedom, stiff lines share a load only if lengths are exact to a tenth of a millimetre.
So one line is always slack. Its accelerometer measures its sag, an angle, at the platform; the angle grows with the
square root of the excess of length and is far more sensitive than the length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.solvers.taut import Taut


@dataclass(frozen=True)
class SlackSettings:
    """Gains and targets of the slack lines.

    ``from_platform``: m along the line before B, where its angle is measured. ``gain``: m/s of the winch for a radian
    of sag. ``target_excess``: m, of a slack line under the law ``paper``. ``planned_excess``: m, of the line with the
    smallest tension under the law ``model``. ``switch_margin``: share of the mean tension by which another line's
    tension must be smaller for a change of the slack line. ``excess_rate``: m/s, rate of the planned excess.
    """

    from_platform: float = 0.2
    gain: float = 0.03
    target_excess: float = 4e-3
    planned_excess: float = 0.01
    switch_margin: float = 0.1
    excess_rate: float = 2e-3

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are negative or not finite."""
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} = {value:g}: must be a finite number, 0 or more")


def sag_angles(settings: SlackSettings, taut: Taut, excess: Array) -> Array:
    """Return gamma_measured - gamma_taut (m,), rad, of lines with an *excess* (m,), m, as parabolas; 0 if taut.

    At a distance d before its end, a parabola of excess e over a chord c is less steep by
    tan = sqrt(24 e / c) (1/2 - d / c) / cos^2, for any stiffness and weight of the cable.
    """
    c = np.cos(taut.angles)
    spans = np.rint(np.linalg.norm(taut.toward, axis=1))
    strain = np.maximum(excess, 0.0) / (spans * taut.free)
    slopes = np.sqrt(24.0 * strain) * (0.5 - settings.from_platform / taut.free) / np.maximum(c * c, 1e-6)
    return np.asarray(np.arctan(np.tan(taut.angles) + slopes) - taut.angles)


def slack_rates(settings: SlackSettings, taut: Taut, excess: Array, slack: Mask) -> Array:
    """Return rates (m,), m/s, for the lengths of *slack* lines, proportional to their sag beyond the target's."""
    target = sag_angles(settings, taut, np.full(len(excess), settings.target_excess))
    beyond = sag_angles(settings, taut, excess) - target
    return np.where(slack & np.isfinite(beyond), -settings.gain * beyond, 0.0)
