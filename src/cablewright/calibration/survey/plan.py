"""What the markers of a survey are: their names, how they sit about the points looked for, and the instrument.

A marker's name says what it is on: `X3-1` the first marker about the exit point of line 3. A plan, a small TOML file,
says what differs from that.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Final, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from cablewright.errors import InputError, UnknownName
from cablewright.toml_input import load_model
from cablewright.units import Angle, Length, NonNegative, Positive, Vec3
from cablewright.validation import Description, FileDescription, refusal

MAX_POINTS: Final = 5000

SCHEME: Final = (
    "X3-1 (exit point of line 3), W3-1 (its winch), A3-1 (a mark that swings with its sheave), "
    "S3-1 (a mark that turns with it), NORTH1, EAST1, SOUTH1, WEST1 (walls), FLOOR1, CEILING1"
)
"""Names of markers that need no plan, for messages."""

Kind = Literal["exit", "winch", "axis", "sheave", "wall", "floor", "ceiling"]
_BY_LETTER: Final[Mapping[str, Kind]] = {"X": "exit", "W": "winch", "A": "axis", "S": "sheave"}
_OF_LINES: Final[tuple[Kind, ...]] = tuple(_BY_LETTER.values())
_NAMED: Final[tuple[Kind, ...]] = (*_OF_LINES, "wall")
_LINE_MARK = re.compile(r"([XWAS])([1-9][0-9]?)(?:[-._](\w{1,8}))?", re.IGNORECASE)
_WALL_MARK = re.compile(r"(NORTH|EAST|SOUTH|WEST|FLOOR|CEIL(?:ING)?)[-._]?([0-9]{0,4})", re.IGNORECASE)


class Feature(NamedTuple):
    """What a marker is on: its kind, and the line's or wall's name ("" for floor and ceiling)."""

    kind: Kind
    name: str

    @property
    def words(self) -> str:
        """For people: ``wall north``, ``exit of south-west``."""
        return f"{self.kind} of {self.name}" if self.kind in _OF_LINES else f"{self.kind} {self.name}".rstrip()


class Instrument(Description):
    """How exact the total station is, as its data sheet says, and where it stands.

    ``angle``: sigma of one direction, both circles. ``distance`` and ``ppm``: sigma of a slope distance, a part that
    does not grow with it and millionths of it. ``marker``: how far a marker may sit from where it should, sigma per
    axis. ``height``: of the instrument over the floor where the file does not say it. ``station``: where it stands in
    the file's coordinates, where those do not begin at it.

    The defaults are those of an instrument of 5 seconds and 2 mm + 2 ppm, as many rented ones; no marker is perfect,
    but how bad it is nobody else knows, so that is 0.
    """

    angle: Positive[Angle] = math.radians(5 / 3600)
    distance: Positive[Length] = 2e-3
    ppm: NonNegative[float] = 2.0
    marker: NonNegative[Length] = 0.0
    height: Length | None = None
    station: Vec3 | None = None


class Placing(Description):
    """How markers sit about the point looked for.

    ``offset``: from the mean of the markers to the point: along the level direction from the first marker to the
    second, level and to the left of it, and up. ``spacing``: from the first to the second, a check.
    """

    offset: Vec3 = (0.0, 0.0, 0.0)
    spacing: Positive[Length] | None = None


class LinePlan(Description):
    """What differs for one line."""

    exit: Placing | None = None
    winch: Placing | None = None


class Frame(Description):
    """The frame of the answer: z up, y along the wall ``along``, x away from it into the room.

    ``origin``: below the instrument, or in the middle of the exit points; z is 0 on the floor either way, where that
    is known. ``along = "instrument"`` keeps the instrument's own directions.
    """

    along: Annotated[str, Field(min_length=1, max_length=40)] = "west"
    origin: Literal["station", "exits"] = "station"


class SurveyPlan(FileDescription):
    """A survey's plan. ``points`` says what markers are on whose names do not: ``P17 = "exit south-west"``."""

    instrument: Instrument = Instrument()
    exit: Placing = Placing()
    winch: Placing = Placing()
    lines: dict[str, LinePlan] = Field(default_factory=dict)
    points: dict[str, str] = Field(default_factory=dict, max_length=MAX_POINTS)
    frame: Frame = Frame()

    @model_validator(mode="after")
    def _points_are_on_something(self) -> Self:
        for point, text in self.points.items():
            if _spelled(text) is None:
                kinds = "'exit LINE', 'winch LINE', 'axis LINE', 'sheave LINE', 'wall NAME', 'floor', 'ceiling', 'none'"
                raise refusal("points", f"{point} = {text[:60]!r}: must be one of {kinds}")
        return self

    def placing(self, feature: Feature) -> Placing:
        """How the markers of an exit or a winch sit."""
        own = self.lines.get(feature.name)
        if feature.kind == "winch":
            return (own and own.winch) or self.winch
        return (own and own.exit) or self.exit


Where = Feature | None


def load_plan(path: str | Path) -> SurveyPlan:
    """Read a plan from a TOML file. Raises `InputError`."""
    return load_model(SurveyPlan, path)


def feature_of(point: str, plan: SurveyPlan, lines: Sequence[str] | None) -> Where:
    """Say what a marker is on; None where neither its name nor the plan says so.

    ``lines``: the names of the robot's lines in their order, None where there is no robot: a line is then called by its
    number. Raises `InputError` for a line that the robot does not have.
    """
    if point in plan.points:
        found = _spelled(plan.points[point])
        return None if found is None or found == "none" else _known(found, point, lines)
    if match := _LINE_MARK.fullmatch(point):
        number = int(match[2])
        if lines is None:
            return Feature(_BY_LETTER[match[1].upper()], str(number))
        if number > len(lines):
            raise InputError(f"marker {point!r}: line {number}; the robot has {len(lines)} lines")
        return Feature(_BY_LETTER[match[1].upper()], lines[number - 1])
    if match := _WALL_MARK.fullmatch(point):
        word = match[1].casefold()
        if word == "floor":
            return Feature("floor", "")
        return Feature("ceiling", "") if word.startswith("ceil") else Feature("wall", word)
    return None


def _spelled(text: str) -> Feature | Literal["none"] | None:
    """Read what a plan says of a point; None if it is not understood."""
    kind, _, name = " ".join(text.split()).partition(" ")
    for known in _NAMED:
        if kind == known:
            return Feature(known, name) if name else None
    if name:
        return None
    if kind == "none":
        return "none"
    if kind == "floor":
        return Feature("floor", "")
    return Feature("ceiling", "") if kind == "ceiling" else None


def _known(feature: Feature, point: str, lines: Sequence[str] | None) -> Feature:
    if feature.kind not in _OF_LINES or lines is None or feature.name in lines:
        return feature
    if feature.name.isdecimal() and 1 <= int(feature.name[:4]) <= len(lines):
        return Feature(feature.kind, lines[int(feature.name) - 1])
    raise UnknownName(f"line (marker {point!r})", feature.name, lines)
