"""The result of a survey: exits, axes, walls and residuals with their sigmas, in the survey frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.survey.frame import SurveyFrame
from cablewright.results import Figure, Pictured

_SUSPECT: Final = 3.5  # sigmas


@dataclass(frozen=True, eq=False)
class Exit:
    """The exit point and the winch exit of a line, m; None where they have no markers."""

    line: str
    exit_point: Array | None  # (3,)
    winch_exit: Array | None  # (3,)
    exit_sigma: Array | None  # (3,)
    winch_sigma: Array | None  # (3,)

    @property
    def dead_length(self) -> float:
        """Distance from winch exit to exit point, m; NaN where one is not known."""
        if self.exit_point is None or self.winch_exit is None:
            return math.nan
        return float(np.linalg.norm(self.exit_point - self.winch_exit))


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis, the centre of a fitted circle of marks: a sheave's upright ``swivel`` axis, or its own, ``sheave``."""

    line: str
    kind: str
    point: Array  # (3,) m, centre of the circle
    direction: Array  # (3,) unit
    radius: float  # m, of the marks' circle
    sigma: Array  # (3,) m, of the centre
    radius_sigma: float  # m
    arc: float  # rad, that the marks span about the centre


@dataclass(frozen=True, eq=False)
class SurveyedWall:
    """A plane, normal . p = distance: a wall, floor or ceiling; its normal points out of the room."""

    name: str
    normal: Array  # (3,), level for a wall
    distance: float  # m, from the frame's origin; negative if the origin is outside
    angle_sigma: float  # rad, of the normal's azimuth; 0 for the wall that the frame follows
    distance_sigma: float  # m
    lean: float  # rad, outwards at the top, from a fit of its own; NaN where the markers leave it open
    lean_sigma: float  # rad
    rms: float  # m
    points: int


@dataclass(frozen=True)
class MarkerResidual:
    """The distance of a marker from its fitted feature, and of its shots from each other."""

    point: str
    feature: str
    residual: float  # m; NaN where no other marker checks it
    sigma: float  # m, expected size of the residual
    repeat: float  # m, rms distance of its shots from their mean; NaN for one shot
    shots: int

    @property
    def suspect(self) -> bool:
        """Whether the residual is too large for chance: over 3.5 sigma."""
        return self.residual > _SUSPECT * self.sigma > 0


def _exits(found: Survey) -> dict[str, dict[str, Any]]:
    return {one.line: _taken(one, "exit_point", "winch_exit", "dead_length") for one in found.exits}


def _sigmas(found: Survey) -> dict[str, Any]:
    return {
        "exits": {one.line: {"exit_point": one.exit_sigma, "winch_exit": one.winch_sigma} for one in found.exits},
        "axes": [{"line": one.line, "point": one.sigma, "radius": one.radius_sigma} for one in found.axes],
        "walls": {
            one.name: {"angle": one.angle_sigma, "distance": one.distance_sigma, "lean": one.lean_sigma}
            for one in found.walls
        },
    }


def _frame(found: Survey) -> dict[str, Any]:
    frame = found.frame
    return _taken(frame, "along", "origin", "rotation") | {"zero_height": frame.floor, "offset": frame.offset.value}


def _taken(value: object, *names: str) -> dict[str, Any]:
    return {name: getattr(value, name) for name in names}


_AXIS: Final = ("line", "kind", "point", "direction", "radius", "arc")
_WALL: Final = ("normal", "distance", "lean", "rms", "points")
_MARKER: Final = ("point", "feature", "residual", "sigma", "repeat", "shots", "suspect")


@dataclass(frozen=True, eq=False, repr=False)
class Survey(Pictured):
    """The result of a survey, in the survey frame."""

    FIGURES: ClassVar = (
        Figure("exits", "m", "Exit point, winch exit and dead length of each line.", _exits),
        Figure(
            "axes",
            "m, rad",
            "Axes of the sheaves and of their swivels.",
            lambda found: [_taken(one, *_AXIS) for one in found.axes],
        ),
        Figure(
            "walls",
            "m, rad",
            "Walls, floor and ceiling: normal . p = distance.",
            lambda found: {one.name: _taken(one, *_WALL) for one in found.walls},
        ),
        Figure(
            "residuals",
            "m",
            "How far each marker is from what was fitted.",
            lambda found: [_taken(row, *_MARKER) for row in found.residuals],
        ),
        Figure("rms", "m", "Of all residuals that are checked, root mean square."),
        Figure("unit_weight", "1", "Residuals over their sigmas: about 1 where the instrument is as good as stated."),
        Figure("frame", "", "Where the answer's frame is.", _frame),
        Figure("sigma", "m, rad", "Standard deviations of exits, axes and walls.", _sigmas),
        Figure("covariance", "m^2", "Of the coordinates of all exits: exit point, then winch exit."),
        Figure("notes", "", "What a careful person would ask."),
    )
    HEADLINES: ClassVar = ("rms", "unit_weight")

    exits: tuple[Exit, ...]
    axes: tuple[Axis, ...]
    walls: tuple[SurveyedWall, ...]
    residuals: tuple[MarkerResidual, ...]
    rms: float  # m, of all residuals that are checked; NaN if none is
    unit_weight: float  # rms of residuals over their sigmas; about 1 if the instrument is as accurate as stated
    frame: SurveyFrame
    covariance: Array  # (k, k) m^2 of all coordinates of exits, in the order of `exits`: exit point, then winch exit
    notes: tuple[str, ...]
