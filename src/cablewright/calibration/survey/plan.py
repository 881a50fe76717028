"""The plan of a survey: names of markers, their offsets from the surveyed points, the instrument and the frame.

A marker's name says which feature it is on: `X3-1` is the first marker of the exit point of line 3. A plan, a small
TOML file, has what differs from that.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Final, Literal, NamedTuple, Self, get_args

from pydantic import Field, model_validator

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.toml_input import load_model
from cablewright.foundation.units import Angle, Length, NonNegative, Positive, Vec3
from cablewright.foundation.validation import Description, FileDescription, refusal

MAX_POINTS: Final = 5000

SCHEME: Final = (
    "X3-1 (exit point of line 3), W3-1 (its winch), A3-1 (a mark that swings with its sheave), "
    "S3-1 (a mark that turns with it), NORTH1, EAST1, SOUTH1, WEST1 (walls), FLOOR1, CEILING1"
)
"""Names of markers that are known without a plan, for messages."""

Kind = Literal["exit", "winch", "axis", "sheave", "wall", "floor", "ceiling"]
_BY_LETTER: Final[Mapping[str, Kind]] = {"X": "exit", "W": "winch", "A": "axis", "S": "sheave"}
_OF_LINES: Final[tuple[Kind, ...]] = tuple(_BY_LETTER.values())
_KINDS: Final[Mapping[str, Kind]] = {kind: kind for kind in get_args(Kind)}
_LINE_MARK = re.compile(r"([XWAS])([1-9][0-9]?)(?:[-._](\w{1,8}))?", re.IGNORECASE)
_WALL_MARK = re.compile(r"(NORTH|EAST|SOUTH|WEST|FLOOR|CEIL(?:ING)?)[-._]?([0-9]{0,4})", re.IGNORECASE)


class MarkedFeature(NamedTuple):
    """The feature of the machine that a marker is on: its kind, and the name of line or wall.

    The name is "" for floor and ceiling.
    """

    kind: Kind
    name: str

    @property
    def words(self) -> str:
        """The feature in messages: ``wall north``, ``exit of south-west``."""
        return f"{self.kind} of {self.name}" if self.kind in _OF_LINES else f"{self.kind} {self.name}".rstrip()


class Instrument(Description):
    """The accuracy of the total station by its data sheet, and its position.

    ``angle``: sigma of a direction, for both circles. ``distance`` and ``ppm``: sigma of a slope distance, its constant
    part and millionths of the distance. ``marker``: sigma of a marker's own position along each axis. ``height``:
    height of the instrument above the floor, if the file does not state it. ``station``: position of the instrument in
    the file's coordinates, if it is not their origin.

    The defaults are those of an instrument of 5 seconds and 2 mm + 2 ppm, which many rented ones have, and of perfect
    markers.
    """

    angle: Positive[Angle] = math.radians(5 / 3600)
    distance: Positive[Length] = 2e-3
    ppm: NonNegative[float] = 2.0
    marker: NonNegative[Length] = 0.0
    height: Length | None = None
    station: Vec3 | None = None


class Placing(Description):
    """Position of a point relative to its markers.

    ``offset``: vector from the mean of the markers to the point: along the level direction from the first marker to the
    second, level and to the left of it, and up. ``spacing``: distance from the first marker to the second; it is only
    checked.
    """

    offset: Vec3 = (0.0, 0.0, 0.0)
    spacing: Positive[Length] | None = None


class LinePlan(Description):
    """Offsets of the markers of one line, where they differ from those of all lines."""

    exit: Placing | None = None
    winch: Placing | None = None


class Frame(Description):
    """The frame of the results: z up, y along the wall ``along``, x from it into the room.

    ``origin``: below the instrument, or at the mean of the exit points; z is 0 on the floor in both cases, where the
    floor is known. ``along = "instrument"`` keeps the instrument's own directions.
    """

    along: Annotated[str, Field(min_length=1, max_length=40)] = "west"
    origin: Literal["station", "exits"] = "station"


class SurveyPlan(FileDescription):
    """A survey's plan. ``points`` assigns markers whose names do not: ``P17 = "exit south-west"``."""

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

    def placing(self, feature: MarkedFeature) -> Placing:
        """Return the offset of the markers of an exit point or a winch."""
        own = self.lines.get(feature.name, LinePlan())
        return own.winch or self.winch if feature.kind == "winch" else own.exit or self.exit


def load_plan(path: str | Path) -> SurveyPlan:
    """Read a survey plan from a TOML file. Raises `InputError`."""
    return load_model(SurveyPlan, path)


def feature_of(point: str, plan: SurveyPlan, lines: Sequence[str] | None) -> MarkedFeature | None:
    """Return the feature that a marker is on, by its name or the plan; None without one.

    ``lines``: the names of the robot's lines in their order. None without a robot: then a line's name is its number.
    Raises `InputError` for a line that the robot does not have.
    """
    if point in plan.points:
        found = _spelled(plan.points[point])
        return None if found is None or found == "none" else _known(found, point, lines)
    if match := _LINE_MARK.fullmatch(point):
        number = int(match[2])
        if lines is not None and number > len(lines):
            raise InputError(f"marker {point!r}: line {number}; the robot has {len(lines)} lines")
        return MarkedFeature(_BY_LETTER[match[1].upper()], str(number) if lines is None else lines[number - 1])
    if match := _WALL_MARK.fullmatch(point):
        word = match[1].casefold()
        if word == "floor":
            return MarkedFeature("floor", "")
        return MarkedFeature("ceiling", "") if word.startswith("ceil") else MarkedFeature("wall", word)
    return None


def _spelled(text: str) -> MarkedFeature | Literal["none"] | None:
    """Return the feature that the words of a plan name, "none" for no feature; None if they are not understood."""
    word, _, name = " ".join(text.split()).partition(" ")
    if word == "none" and not name:
        return "none"
    kind = _KINDS.get(word)
    if kind is None or (name == "") != (kind in ("floor", "ceiling")):
        return None
    return MarkedFeature(kind, name)


def _known(feature: MarkedFeature, point: str, lines: Sequence[str] | None) -> MarkedFeature:
    if feature.kind not in _OF_LINES or lines is None or feature.name in lines:
        return feature
    if feature.name.isdecimal() and 1 <= int(feature.name[:4]) <= len(lines):
        return MarkedFeature(feature.kind, lines[int(feature.name) - 1])
    raise UnknownName(f"line (marker {point!r})", feature.name, lines)
