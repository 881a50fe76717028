"""The result of a survey: exits, axes, walls and residuals with their sigmas, in the survey frame."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.survey.frame import SurveyFrame
from cablewright.results import Figure, Pictured, figures_dict

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
class SheaveAxis:
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

    @property
    def words(self) -> str:
        """What messages call it: ``wall west``, ``floor``."""
        return self.name if self.name in ("floor", "ceiling") else f"wall {self.name}"


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


def _frame(found: Survey) -> dict[str, Any]:
    frame = found.frame
    own = {name: getattr(frame, name) for name in ("along", "origin", "rotation")}
    return own | {"zero_height": frame.floor, "offset": frame.offset.value}


def _named(rows: Iterable[object], figures: tuple[Figure, ...], name: str) -> dict[str, Any]:
    return {getattr(row, name): figures_dict(figures, row) for row in rows}


EXIT: Final = (
    Figure("exit_point", "m", "Exit point; null where no marker gives it.", digits=5, shown="m"),
    Figure("exit_sigma", "m", "Standard deviations of its coordinates.", name="sigma", digits=2, shown="mm"),
    Figure("winch_exit", "m", "Winch exit; null where no marker gives it.", digits=5, shown="m"),
    Figure("winch_sigma", "m", "Standard deviations of its coordinates.", name="sigma", digits=2, shown="mm"),
    Figure("dead_length", "m", "Distance of the two; null where one is not known.", digits=5, shown="m"),
)
AXIS: Final = (
    Figure("line", "", "Line of the sheave."),
    Figure("kind", "", "swivel: the upright axis of the swivel; sheave: the axis of the sheave."),
    Figure("point", "m", "Centre of the markers' circle.", digits=5, shown="m"),
    Figure("sigma", "m", "Standard deviations of its coordinates.", digits=2, shown="mm"),
    Figure("direction", "1", "Unit vector of the axis.", digits=5),
    Figure("radius", "m", "Radius of the markers' circle.", shown="mm"),
    Figure("radius_sigma", "m", "Its standard deviation.", name="sigma", digits=2, shown="mm"),
    Figure("arc", "rad", "Arc from the first marker to the last.", digits=3),
)
WALL: Final = (
    Figure("normal", "1", "Unit normal, out of the room: normal . p = distance.", digits=5),
    Figure("distance", "m", "Distance of the plane from the frame's origin.", digits=5, shown="m"),
    Figure("distance_sigma", "m", "Its standard deviation.", name="sigma", digits=2, shown="mm"),
    Figure("angle_sigma", "rad", "Standard deviation of the normal's azimuth.", name="azimuth sigma", digits=2),
    Figure("lean", "rad", "Upward lean of the normal in a free fit; null where the markers do not show it.", digits=3),
    Figure("lean_sigma", "rad", "Its standard deviation.", name="sigma", digits=2),
    Figure("rms", "m", "Root mean square of the markers' residuals.", digits=3, shown="mm"),
    Figure("points", "1", "Number of markers."),
)
MARKER: Final = (
    Figure("point", "", "Name of the marker.", name="marker"),
    Figure("feature", "", "Feature that the marker is on.", name="on"),
    Figure(
        "residual", "m", "Distance from what was fitted; null where no other marker checks it.", digits=3, shown="mm"
    ),
    Figure("sigma", "m", "Expected size of the residual.", name="expected", digits=3, shown="mm"),
    Figure("repeat", "m", "Root mean square of its shots about their mean; null for one shot.", digits=3, shown="mm"),
    Figure("shots", "1", "Number of shots."),
    Figure("suspect", "", "Whether the residual is too large for chance."),
)
FRAME: Final = (
    Figure("along", "", "Wall that y follows, x into the room; or instrument: its own x and y."),
    Figure("origin", "", "station: below the instrument; exits: in the middle of the exit points."),
    Figure("zero_height", "", "What z = 0 is: floor, height (floor by the instrument's height), or instrument."),
    Figure("rotation", "rad", "Rotation of the frame from the instrument's.", detail=True),
    Figure("offset", "m", "Offset of the frame from the instrument's.", detail=True),
)


@dataclass(frozen=True, eq=False, repr=False)
class Survey(Pictured):
    """The result of a survey, in the survey frame."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok.", lambda _: "ok"),
        Figure("rms", "m", "Root mean square of all residuals that are checked.", digits=3, shown="mm"),
        Figure("unit_weight", "1",
               "Residuals over their expected size; about 1 if the instrument is as good as stated."),
        Figure("unchecked", "1", "Number of markers that no other marker and no second shot checks."),
        Figure("frame", "", "Frame of the coordinates.", _frame, parts=FRAME),
        Figure("exits", "", "Exit points and winch exits by line.", lambda of: _named(of.exits, EXIT, "line"),
               parts=EXIT),
        Figure("axes", "", "Axes of the sheaves and of their swivels.", parts=AXIS),
        Figure("walls", "", "Walls, floor and ceiling.", lambda of: _named(of.walls, WALL, "name"), parts=WALL),
        Figure("residuals", "", "Residuals of the markers.", parts=MARKER),
        Figure("covariance", "m^2", "Covariance of the coordinates of all exits: exit point, then winch exit.",
               detail=True),
        Figure("notes", "", "What a careful person would ask.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("rms", "unit_weight")

    exits: tuple[Exit, ...]
    axes: tuple[SheaveAxis, ...]
    walls: tuple[SurveyedWall, ...]
    residuals: tuple[MarkerResidual, ...]
    rms: float  # m, of all residuals that are checked; NaN if none is
    unit_weight: float  # rms of residuals over their sigmas; about 1 if the instrument is as accurate as stated
    frame: SurveyFrame
    covariance: Array  # (k, k) m^2 of all coordinates of exits, in the order of `exits`: exit point, then winch exit
    notes: tuple[str, ...]

    @property
    def unchecked(self) -> int:
        """How many markers nothing checks."""
        return sum(math.isnan(row.residual) and math.isnan(row.repeat) for row in self.residuals)
