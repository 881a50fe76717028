"""Control of slack: which line is slack, and by how much (Merlet and Papegay 2023, III.B).

With more lines than freedoms not all stiff lines can share a load: lengths would have to be exact to a tenth of a
millimetre. So one line is always slack. Its sag at the platform, an angle that its accelerometer measures, shows by how
much, far more sensitively than the length: it grows with the square root of the excess.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.errors import InputError
from cablewright.solvers.taut import Taut


@dataclass(frozen=True)
class SlackSettings:
    """Gains and targets of the slack lines.

    ``from_platform``: m along the line before B, where its angle is measured. ``gain``: m/s of the winch for a radian
    of sag. ``target_excess``: m, of a slack line under the law ``paper``. ``planned_excess``: m, of the line with the
    smallest tension under the law ``model``. ``switch_margin``: share of the mean tension by which another line's has
    to be smaller to be chosen instead. ``excess_rate``: m/s at which the planned excess changes.
    """

    from_platform: float = 0.2
    gain: float = 0.03
    target_excess: float = 4e-3
    planned_excess: float = 0.01
    switch_margin: float = 0.1
    excess_rate: float = 2e-3

    def __post_init__(self) -> None:
        """Refuse numbers that are negative or not finite."""
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} = {value:g}: a finite number from 0 on is wanted")


def sag_angles(settings: SlackSettings, taut: Taut, excess: Array) -> Array:
    """gamma_measured - gamma_taut (m,), rad, of lines with that *excess* (m,), m, as parabolas; 0 if taut.

    At a distance d before its end a parabola of excess e over a chord c is less steep by
    tan = sqrt(24 e / c) (1/2 - d / c) / cos^2, whatever the cable's stiffness and weight.
    """
    c = np.cos(taut.angles)
    strain = np.maximum(excess, 0.0) / taut.free
    slopes = np.sqrt(24.0 * strain) * (0.5 - settings.from_platform / taut.free) / np.maximum(c * c, 1e-6)
    return np.asarray(np.arctan(np.tan(taut.angles) + slopes) - taut.angles)


def slack_rates(settings: SlackSettings, taut: Taut, excess: Array, slack: Mask) -> Array:
    """Rates (m,), m/s, added to the lengths of *slack* lines: proportional to their sag beyond the target's."""
    beyond = sag_angles(settings, taut, excess) - sag_angles(
        settings, taut, np.full(len(excess), settings.target_excess)
    )
    return np.where(slack & np.isfinite(beyond), -settings.gain * beyond, 0.0)


def choose_slack_line(settings: SlackSettings, tensions: Array, current: int) -> int:
    """Index of the line to be slack: the smallest of *tensions* (m,), N; *current* unless that is far smaller."""
    smallest = int(np.argmin(tensions))
    if current < 0 or tensions[current] - tensions[smallest] > settings.switch_margin * float(tensions.mean()):
        return smallest
    return current
