"""What keeps slack lines nearly taut, and which line is to be slack (Merlet and Papegay 2023, III.B).

With more lines than freedoms not all stiff lines can share a load: lengths would have to be exact to a tenth of a
millimetre. So one line is always slack, and its sag at the platform, an angle that its accelerometer sees, says how
much. The angle is far more sensitive than the length: it grows as the root of the excess.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.solvers.taut import Taut

__all__ = ["SlackSettings", "planned", "sag", "term"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SlackSettings:
    """``from_platform``: m along the line before B, where its angle is measured.

    ``gain``: m/s of the winch for a radian of sag. ``wanted``: m of excess that a slack line is kept at. ``plan``: m of
    excess that the line with the least to do is given where lengths follow the full model. ``even``: share of the mean
    tension by which another line has to have less to do to take its place. ``ease``: m/s by which that changes.
    """

    from_platform: float = 0.2
    gain: float = 0.03
    wanted: float = 4e-3
    plan: float = 0.01
    even: float = 0.1
    ease: float = 2e-3

    def __post_init__(self) -> None:
        """Refuse what is no number of its kind."""
        for name in ("from_platform", "gain", "wanted", "plan", "even", "ease"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number from 0 on is wanted")


def sag(settings: SlackSettings, taut: Taut, excess: Array) -> Array:
    """gamma_measured - gamma_taut (m,), rad, of lines whose *excess* (m,), m, makes them hang as parabolas; 0 if taut.

    A parabola of excess e over a chord c runs less steeply at its end by tan = sqrt(24 e / c) (1/2 - d / c) / cos^2, d
    before the end: no stiffness and no weight of the cable is in it.
    """
    c = np.cos(taut.angles)
    loose = np.maximum(excess, 0.0) / taut.free
    slopes = np.sqrt(24.0 * loose) * (0.5 - settings.from_platform / taut.free) / np.maximum(c * c, 1e-6)
    return np.asarray(np.arctan(np.tan(taut.angles) + slopes) - taut.angles)


def term(settings: SlackSettings, taut: Taut, excess: Array, slack: NDArray[np.bool_]) -> Array:
    """What is added to the lengths' rates (m,), m/s, of *slack* lines: proportional to what they sag beyond wanted."""
    beyond = sag(settings, taut, excess) - sag(settings, taut, np.full(len(excess), settings.wanted))
    return np.where(slack & np.isfinite(beyond), -settings.gain * beyond, 0.0)


def planned(settings: SlackSettings, tensions: Array, chosen: int) -> int:
    """Which line is to be slack: that with the least to do by *tensions* (m,), N; *chosen* stays unless by far."""
    least = int(np.argmin(tensions))
    if chosen < 0 or tensions[chosen] - tensions[least] > settings.even * float(tensions.mean()):
        return least
    return chosen
