"""The result of a survey: exit points, axes, walls, residuals, sigmas, and a robot with these exit points."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.calibration.survey.frame import SurveyFrame
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured, figures_dict
from cablewright.foundation.units import Vec3
from cablewright.foundation.validation import validated
from cablewright.models.support_table import Capability, require
from cablewright.robot.line import Line
from cablewright.robot.robot import Robot
from cablewright.robot.sheave import Eyelet

_SUSPECT: Final = 3.5  # sigmas
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
    Figure("residual", "m", "Distance from the fit; null without a redundant marker.", digits=3, shown="mm"),
    Figure("sigma", "m", "Expected size of the residual.", name="expected", digits=3, shown="mm"),
    Figure("repeat", "m", "Root mean square of its shots about their mean; null for one shot.", digits=3, shown="mm"),
    Figure("shots", "1", "Number of shots."),
    Figure("suspect", "", "Whether the residual is too large for chance."),
)
FRAME: Final = (
    Figure("along", "", "Wall that y follows, x into the room; or instrument: its own x and y."),
    Figure("origin", "", "station: below the instrument; `exits`: in the middle of the exit points."),
    Figure("zero_height", "", "What z = 0 is: floor, height (floor by the instrument's height), or instrument."),
    Figure("rotation", "rad", "Rotation of the frame from the instrument's.", detail=True),
    Figure("offset", "m", "Offset of the frame from the instrument's.", detail=True),
)
_DIGITS: Final = 5  # of a metre: 0.01 mm is far below the accuracy of a survey
_OFF_AXIS: Final = 5e-3  # m: horizontal distance of a winch from its swivel's axis that needs a note
_MOVED: Final = 0.3  # m: an exit point that moves by more is in another frame, or of another line


@dataclass(frozen=True, eq=False)
class Exit:
    """The surveyed exit point and winch exit of a line, m; None where they have no markers."""

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
    """An axis of a sheave, from a circle fitted to marks: vertical, ``swivel``, or of the wheel, ``sheave``."""

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
        """Name of the wall in messages: ``wall west``, ``floor``."""
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
        """Return whether the residual is too large for chance: over 3.5 sigma."""
        return self.residual > _SUSPECT * self.sigma > 0


def _frame(found: Survey) -> dict[str, Any]:
    frame = found.frame
    own = {name: getattr(frame, name) for name in ("along", "origin", "rotation")}
    return own | {"zero_height": frame.floor, "offset": frame.offset.value}


def _named(rows: Iterable[object], figures: tuple[Figure, ...], name: str) -> dict[str, Any]:
    return {getattr(row, name): figures_dict(figures, row) for row in rows}


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
        Figure("exits", "", "Exit points and winch exit points by line.", lambda of: _named(of.exits, EXIT, "line"),
               parts=EXIT),
        Figure("axes", "", "Axes of the sheaves and of their swivels.", parts=AXIS),
        Figure("walls", "", "Walls, floor and ceiling.", lambda of: _named(of.walls, WALL, "name"), parts=WALL),
        Figure("residuals", "", "Residuals of the markers.", parts=MARKER),
        Figure("covariance", "m^2", "Covariance of the coordinates of all points in `exits`, in their order.",
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
    covariance: (
        Array  # (k, k) m^2 of all coordinates of exit points, in the order of `exits`: exit point, then winch exit
    )
    notes: tuple[str, ...]

    @property
    def unchecked(self) -> int:
        """Number of markers that no other measurement checks."""
        return sum(math.isnan(row.residual) and math.isnan(row.repeat) for row in self.residuals)


def surveyed(robot: Robot, found: Survey) -> tuple[Robot, tuple[str, ...]]:
    """Return the robot with the surveyed exit points of its lines, and sentences on data that could not be transferred.

    A robot file has the winch exit of a swivelling sheave straight below or above the exit point. Where the winch is
    beside that axis, only its height is taken, with a note. Dead spans that are given as lengths get the surveyed
    lengths. Raises `InputError` if the survey has no exit points, for lines out of the plane, or if the resulting robot
    is not valid.
    """
    require(robot, Capability.SURVEY)
    by_line = {exit_.line: exit_ for exit_ in found.exits}
    if not by_line:
        raise InputError(
            "the survey has no exit point and no winch of any line: there is nothing to write into a robot"
        )
    notes: list[str] = []
    missing = [line.name for line in robot.lines if line.name not in by_line]
    if missing:
        notes.append(f"not surveyed, so kept as they are: {', '.join(missing[:8])}")
    lines = [_line(line, by_line[line.name], notes) if line.name in by_line else line for line in robot.lines]
    surveyed = robot.model_dump() | {"lines": [line.model_dump() for line in lines]}
    return validated(Robot, surveyed, "the robot cannot be as surveyed"), tuple(notes)


def _line(line: Line, exit_: Exit, notes: list[str]) -> Line:
    changes: dict[str, Any] = {}
    point = line.exit_point if exit_.exit_point is None else _rounded(exit_.exit_point)
    changes["exit_point"] = point
    moved = math.dist(point, line.exit_point)
    if moved > _MOVED:
        notes.append(
            f"exit point of {line.name} moves by {moved:.3g} m: is the survey's frame the robot's? (origin and wall "
            "are set in the plan's [frame])"
        )
    if line.winch_exit is not None:
        changes["winch_exit"] = _winch_exit(line, line.winch_exit, point, exit_, notes)
    elif exit_.winch_exit is not None:
        if line.dead_length and exit_.exit_point is not None:
            changes["dead_length"] = round(exit_.dead_length, _DIGITS)
        else:
            notes.append(f"{line.name} has no dead span in the robot file: its winch is not written")
    return line.model_copy(update=changes)


def _winch_exit(line: Line, before: Vec3, point: Vec3, exit_: Exit, notes: list[str]) -> Vec3:
    place = before if exit_.winch_exit is None else _rounded(exit_.winch_exit)
    if isinstance(line.sheave, Eyelet):
        return place
    off = 0.0 if exit_.winch_exit is None else math.dist(place[:2], point[:2])
    if off > _OFF_AXIS:
        way = math.hypot(off, place[2] - point[2]) - abs(place[2] - point[2])
        notes.append(
            f"winch of {line.name} is {1e3 * off:.0f} mm beside its sheave's axis: only its height is written, which "
            f"makes the dead span {1e3 * way:.2g} mm too short"
        )
    return point[0], point[1], place[2]


def _rounded(place: Array) -> Vec3:
    x, y, z = (round(float(value), _DIGITS) + 0.0 for value in place)
    return x, y, z
