"""The plan of a calibration: unknowns, sigmas of the sensors, further measurements, and the datum of the frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self, TypeVar

from annotated_types import Ge, Le
from pydantic import Field, Strict, model_validator

from cablewright.calibration.unknowns import BOUNDED, COORDINATES, DEFAULT, NAMES, Unknown
from cablewright.foundation.errors import suggestion
from cablewright.foundation.toml_input import load_model
from cablewright.foundation.units import Angle, Force, Length, Positive, Vec3
from cablewright.foundation.validation import Description, FileDescription, refusal
from cablewright.robot.parameters import KINDS_OF

INNER: Final = "inner"
"""The default datum, the inner constraint: on average exit points keep the position and direction of the file."""

SIGMAS: Final = (1e-9, 1e9)
"""Min and max of a standard deviation, SI: with a smaller or larger one squares of residuals have no numbers."""

STRETCH: Final = "stretch"
"""The name of the stretch of lines that count as stiff, over that by the file's stiffness."""

SETTABLE: Final = (
    "build_up", "length_scale", "tension_offset", "tension_scale", "swivel_offset", "yaw_offset",
)  # fmt: skip
"""Numbers that a plan may say instead of the robot file."""

_MAX_ENTRIES: Final = 1000
_Axis = Annotated[float, Strict()]
_Quantity = TypeVar("_Quantity")
_Sigma = Annotated[_Quantity, Ge(SIGMAS[0]), Le(SIGMAS[1])]
_Poses = Annotated[tuple[Annotated[int, Strict(), Field(ge=1)], ...], Field(min_length=1, max_length=100_000)]


class Sigmas(Description):
    """Standard deviations of the sensors. Without ``encoder``, that of the encoders is estimated from the residuals.

    ``friction``: friction of the guides between exit point and load cell, as a share of the tension. ``frequency``: of
    the first lateral vibration of a free cable, Hz.
    """

    encoder: _Sigma[Length] | None = None
    tension: _Sigma[Force] = 5.0
    friction: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = 0.0
    swivel: _Sigma[Angle] = 1e-3
    tilt: _Sigma[Angle] = 1e-3
    yaw: _Sigma[Angle] = 1e-2
    frequency: _Sigma[_Axis] = 0.05


class Prior(Description):
    """Prior knowledge of an unknown: the file's value, or ``value``, with a standard deviation, in its SI unit.

    ``name`` may be of a coordinate: ``exit_point.z``. ``alike``: the lines differ from the file by the same number,
    which is unknown, to that deviation. ``tilted``: exit points are those of the file to that deviation, but for
    a tilt of all together, as by a survey in a frame that is not level.
    """

    name: str
    lines: tuple[str, ...] | None = None
    value: Annotated[float, Strict(), Field(allow_inf_nan=False)] | None = None
    deviation: _Sigma[_Axis]
    alike: bool = False
    tilted: bool = False

    @model_validator(mode="after")
    def _is_known(self) -> Self:
        if self.name not in (*NAMES, *COORDINATES):
            raise refusal("name", f"unknown number; {suggestion(self.name, (*NAMES, *COORDINATES))}")
        if self.tilted and (self.name != "exit_point" or self.alike or self.lines is not None):
            raise refusal("tilted", "is of the exit_point of all lines: give it alone")
        if self.alike and self.value is not None:
            raise refusal("alike", "is of numbers whose value is not known: leave out this or value")
        if self.value is not None and self.name not in (*BOUNDED, *COORDINATES):
            raise refusal("value", f"is one number: name a coordinate, as {self.name}.z")
        if self.name == "length_offset" and self.value is None and not self.alike:
            raise refusal("value", "is required: no robot file has a length at home")
        return self

    def is_of(self, unknown: Unknown) -> bool:
        """Return whether the entry of a plan is of the number *name* of a *line*, or of all lines for None."""
        return self.name in (unknown.name, unknown.kind) and (
            self.lines is None or any(unknown.of_line(line) for line in self.lines)
        )


class Known(Description):
    """A number that is not estimated: its ``value``, and the standard deviation of that, in its SI unit.

    Without ``value`` it is that of the robot file, 0 or 1; without ``deviation`` it is assumed as for other robots.
    ``stretch``: stretch of lines that count as stiff, relative to that by the file's stiffness.
    """

    name: str
    lines: tuple[str, ...] | None = None
    value: Annotated[float, Strict(), Field(allow_inf_nan=False)] | None = None
    deviation: Annotated[float, Strict(), Field(ge=0.0, le=SIGMAS[1])] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        names = (*(name for name in NAMES if name != "length_offset"), STRETCH)
        if self.name not in names:
            raise refusal("name", f"unknown number; {suggestion(self.name, names)}")
        if self.value is None and self.deviation is None:
            raise refusal("value", "give this or deviation")
        if self.value is not None and self.name not in SETTABLE:
            raise refusal("value", f"is in the robot file, or of several numbers; give it for {', '.join(SETTABLE)}")
        if self.name == STRETCH and self.lines is not None:
            raise refusal("lines", "stretch is one number for all lines")
        return self

    def is_of(self, name: str, line: str | None) -> bool:
        """Return whether the entry is of the number *name* of a *line*, or of all lines for None."""
        return self.name == name and (self.lines is None or line is None or line in self.lines)


class Bound(Description):
    """The range of an unknown, in its SI unit, instead of that by its physics."""

    name: str
    lines: tuple[str, ...] | None = None
    min: Annotated[float, Strict(), Field(allow_inf_nan=False)]
    max: Annotated[float, Strict(), Field(allow_inf_nan=False)]

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.name not in BOUNDED:
            raise refusal("name", f"has no bounds of one number; {suggestion(self.name, BOUNDED)}")
        if not self.min < self.max:
            raise refusal("max", f"must be over min, {self.min:g}")
        if self.min <= 0.0 and KINDS_OF[self.name][0].min_value == 0.0 and not KINDS_OF[self.name][0].closed:
            raise refusal("min", "must be over 0")
        return self


class Group(Description):
    """Lines that have one number in common."""

    name: str
    lines: Annotated[tuple[str, ...], Field(min_length=2, max_length=_MAX_ENTRIES)]

    @model_validator(mode="after")
    def _is_known(self) -> Self:
        if self.name not in NAMES:
            raise refusal("name", f"unknown number; {suggestion(self.name, NAMES)}")
        return self


class MeasuredDistance(Description):
    """A measured distance between the exit points of two lines."""

    between: tuple[str, str]
    value: Positive[Length]
    deviation: _Sigma[Length] = 1e-3

    @model_validator(mode="after")
    def _are_two(self) -> Self:
        if self.between[0] == self.between[1]:
            raise refusal("between", "must name two lines")
        return self


class Point(Description):
    """A surveyed exit point, in the world frame."""

    line: str
    at: Vec3
    deviation: _Sigma[Length] = 1e-3


class TouchedPlane(Description):
    """Poses (rows of the data, counted from 1) at which the nozzle touched the plane through ``point``."""

    poses: _Poses
    point: Vec3
    normal: tuple[_Axis, _Axis, _Axis]
    deviation: _Sigma[Length] = 1e-3

    @model_validator(mode="after")
    def _has_a_normal(self) -> Self:
        if not 0.0 < math.hypot(*self.normal) < math.inf:
            raise refusal("normal", "must be finite and not zero")
        return self


class MeasuredRange(Description):
    """Measured distances of the nozzle from a known ``point``, world frame, at poses (rows, counted from 1)."""

    point: Vec3
    poses: _Poses
    values: Annotated[tuple[Positive[Length], ...], Field(min_length=1, max_length=100_000)]
    deviation: _Sigma[Length] = 1e-3

    @model_validator(mode="after")
    def _go_together(self) -> Self:
        if len(self.poses) != len(self.values):
            raise refusal("values", f"must be as many as poses: {len(self.values)} and {len(self.poses)} are given")
        return self


class CalibrationPlan(FileDescription):
    """The plan of a calibration.

    ``lengths``: whether counts are lengths from the exit point on (absolute) or changes since home (relative; the
    default, with ``length_offset`` among the unknowns). ``shared``: unknowns that are one number for all lines;
    ``groups``: unknowns that some lines share. ``datum``: exit points (``south-west``) or coordinates
    (``south-east.y``) to hold. ``level``: sigma of the tilt of all exit points against the file, rad. ``across``: for a
    platform in a plane, sigma of the file's distance of each exit point from it, m.
    """

    lengths: Literal["absolute", "relative"] | None = None
    unknowns: Annotated[tuple[str, ...], Field(max_length=len(NAMES))] = DEFAULT
    shared: Annotated[tuple[str, ...], Field(max_length=len(NAMES))] = ()
    groups: Annotated[tuple[Group, ...], Field(max_length=_MAX_ENTRIES)] = ()
    datum: Annotated[tuple[str, ...], Field(max_length=_MAX_ENTRIES)] = ()
    sigma: Sigmas = Sigmas()
    level: _Sigma[Angle] | None = None
    across: _Sigma[Length] | None = None
    priors: Annotated[tuple[Prior, ...], Field(max_length=_MAX_ENTRIES)] = ()
    known: Annotated[tuple[Known, ...], Field(max_length=_MAX_ENTRIES)] = ()
    bounds: Annotated[tuple[Bound, ...], Field(max_length=_MAX_ENTRIES)] = ()
    distances: Annotated[tuple[MeasuredDistance, ...], Field(max_length=_MAX_ENTRIES)] = ()
    points: Annotated[tuple[Point, ...], Field(max_length=_MAX_ENTRIES)] = ()
    planes: Annotated[tuple[TouchedPlane, ...], Field(max_length=8)] = ()
    ranges: Annotated[tuple[MeasuredRange, ...], Field(max_length=8)] = ()

    @model_validator(mode="before")
    @classmethod
    def _absolute_lengths_have_no_home(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("lengths") == "absolute":
            return {"unknowns": [name for name in DEFAULT if name != "length_offset"]} | data
        return data

    @model_validator(mode="after")
    def _says_what_lengths_are(self) -> Self:
        home = "length_offset" in self.unknowns
        if self.lengths == "absolute" and home:
            raise refusal("lengths", "absolute ones have no length at home: leave length_offset out of unknowns")
        if self.lengths == "relative" and not home:
            raise refusal("lengths", "relative ones have an unknown length at home: add length_offset to unknowns")
        return self

    @model_validator(mode="after")
    def _known_ones_are_no_unknowns(self) -> Self:
        for at, each in enumerate(self.known):
            if each.name in self.unknowns:
                raise refusal(f"known[{at}].name", f"{each.name} is among the unknowns: give a prior instead")
        return self

    @model_validator(mode="after")
    def _each_number_is_given_once(self) -> Self:
        given: dict[str, Sequence[Known | Bound]] = {"known": self.known, "bounds": self.bounds}
        for key, entries in given.items():
            for (before, one), (at, two) in combinations(enumerate(entries), 2):
                both = set(one.lines or two.lines or ()) & set(two.lines or one.lines or ())
                if one.name == two.name and (both or one.lines is two.lines is None):
                    of = f" of {', '.join(sorted(both))}" if both else ""
                    why = f"{one.name}{of} is in {key}[{before}] too: give it once, by lines"
                    raise refusal(f"{key}[{at}].name", why)
        return self

    @property
    def grouped(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The groups as pairs of a name and lines."""
        return tuple((each.name, each.lines) for each in self.groups)


def load_plan(path: str | Path) -> CalibrationPlan:
    """Read a calibration plan from a TOML file.

    Raises `InputError`, one line naming file, key, value and the allowed range.
    """
    return load_model(CalibrationPlan, path)


def plan_of(plan: str | Path | CalibrationPlan | None) -> CalibrationPlan:
    """Return *plan*, read from its file if it is a path; the default for None. Raises `InputError` as `load_plan`."""
    if plan is None:
        return CalibrationPlan()
    return plan if isinstance(plan, CalibrationPlan) else load_plan(plan)
