"""What a survey found: exits, axes, walls and residuals, each with its sigma, in the frame of the answer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.survey.frame import SurveyFrame

__all__ = ["Axis", "Exit", "MarkerResidual", "Survey", "SurveyedWall"]

Array = NDArray[np.float64]

_SUSPECT: Final = 3.5  # sigmas


@dataclass(frozen=True, eq=False)
class Exit:
    """Where a line leaves its winch and its sheave, as far as markers say; m."""

    line: str
    exit_point: Array | None  # (3,)
    winch_exit: Array | None  # (3,)
    exit_sigma: Array | None  # (3,)
    winch_sigma: Array | None  # (3,)

    @property
    def dead_length(self) -> float:
        """From winch to exit, m; NaN where one is not known."""
        if self.exit_point is None or self.winch_exit is None:
            return math.nan
        return float(np.linalg.norm(self.exit_point - self.winch_exit))


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis found by a circle: ``swivel``, upright, about which a sheave swings, or ``sheave``, its own."""

    line: str
    kind: str
    point: Array  # (3,) m, centre of the circle
    direction: Array  # (3,) unit
    radius: float  # m, of the mark's circle
    sigma: Array  # (3,) m, of the centre
    radius_sigma: float  # m
    arc: float  # rad, from the first mark to the last about the centre


@dataclass(frozen=True, eq=False)
class SurveyedWall:
    """A plane, normal . p = distance: a wall, floor or ceiling; its normal leaves the room."""

    name: str
    normal: Array  # (3,) level for a wall
    distance: float  # m, from the frame's origin; below 0 where that is outside
    angle_sigma: float  # rad, of the normal's azimuth; 0 of the wall that the frame follows
    distance_sigma: float  # m
    lean: float  # rad, upwards of the normal in a fit of its own; NaN where the markers cannot tell
    lean_sigma: float  # rad
    rms: float  # m
    points: int


@dataclass(frozen=True)
class MarkerResidual:
    """How far a marker is from what was fitted, and its shots from each other."""

    point: str
    feature: str
    residual: float  # m; NaN where no other marker checks it
    sigma: float  # m, how large the residual should be
    repeat: float  # m, rms of its shots about their mean; NaN for one shot
    shots: int

    @property
    def suspect(self) -> bool:
        """Whether it is too large for chance."""
        return self.residual > _SUSPECT * self.sigma > 0


@dataclass(frozen=True, eq=False)
class Survey:
    """What a survey found, in the frame of the answer."""

    exits: tuple[Exit, ...]
    axes: tuple[Axis, ...]
    walls: tuple[SurveyedWall, ...]
    residuals: tuple[MarkerResidual, ...]
    rms: float  # m, of all residuals that are checked; NaN if none is
    unit_weight: float  # rms of residuals over their sigmas; about 1 where the instrument is as good as stated
    frame: SurveyFrame
    covariance: Array  # (k, k) m^2 of all coordinates of exits, in the order of `exits`: exit point, then winch exit
    notes: tuple[str, ...]
