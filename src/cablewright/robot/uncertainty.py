"""The uncertainty of a robot's parameters: its TOML file, and the ranges that follow for one robot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Final, Self

from pydantic import Field, Strict, StrictBool, WithJsonSchema, model_validator

from cablewright.foundation.errors import InputError, suggestion
from cablewright.foundation.toml_input import load_model
from cablewright.foundation.units import Vec3
from cablewright.foundation.validation import Description, FileDescription, refusal, require_rising
from cablewright.robot.cable import Cable
from cablewright.robot.line import MAX_LINES, Line
from cablewright.robot.parameter_values import Kind, Room
from cablewright.robot.parameters import (
    KINDS_OF,
    Described,
    Parameter,
    misuse,
    nominal,
    parameters_of,
    why_not,
    with_value,
)

MAX_ENTRIES: Final = 200

ASSUMED: Final = "assumed"
"""Name of the uncertainty that `assumed_uncertainty` returns."""

STEEL_DENSITY: Final = 1700.0
"""kg/m^3 of a cable's circle: cables of steel have 2000 to 6000, of fibres at most 1500."""

_STEP: Final = 1e-5  # m, of a coordinate

_KINDS: Final = {name: kinds for name, kinds in KINDS_OF.items() if kinds[0].role in ("hardware", "command", "load")}
"""Parameters that may be uncertain, by name."""

_WAYS: Final = ("factor", "range", "plus_minus", "deviation", "relative_deviation")
_WITH_UNIT: Final = ("range", "plus_minus", "deviation")
_RELATIVE: Final = {"factor": "plus_minus", "relative_deviation": "deviation"}
"""The ways that scale the nominal value, and the way to give instead where that is 0."""

_Number = Annotated[float, Strict()]
_Width = Annotated[float, Strict(), Field(gt=0)]
_OR_TEXT: Final = WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string"}]})
"""Of a number or a text with a unit, which the name of the entry decides."""


@dataclass(frozen=True)
class Range:
    """The range of one uncertain parameter, SI: from ``low`` to ``high``.

    With a ``deviation`` it is normal about ``nominal``, the robot file's value, with that standard deviation; None:
    uniform between the ends, and ``nominal`` may be outside. Valid values are between ``min_value`` and ``max_value``,
    without both.
    """

    parameter: Parameter
    nominal: float
    low: float
    high: float
    deviation: float | None = None
    min_value: float = field(default=-math.inf, compare=False, repr=False)
    max_value: float = field(default=math.inf, compare=False, repr=False)
    zeroing: tuple[float, ...] = field(default=(), repr=False)
    """Of each line, by how much zeroing it pays out more, m per unit of the parameter; empty: lines are not zeroed."""

    @property
    def middle(self) -> float:
        """The mean of ``low`` and ``high``."""
        return 0.5 * self.low + 0.5 * self.high

    @property
    def half_width(self) -> float:
        """Half the distance from ``low`` to ``high``; positive."""
        return 0.5 * (self.high - self.low)

    @property
    def sigma(self) -> float:
        """The given standard deviation, or that of the uniform distribution between the ends."""
        return (self.high - self.low) / math.sqrt(12.0) if self.deviation is None else self.deviation


class Uncertain(Description):
    """One entry of the file: a kind of parameter, its lines, and its uncertainty in one of five ways, SI.

    ``factor``: lowest and highest, times the nominal value; ``range``: lowest and highest value; ``plus_minus``:
    largest difference from the nominal value; ``deviation``: standard deviation; ``relative_deviation``: the same, as a
    share of the nominal value. ``lines``: None for every line, each on its own; ``shared``: one number for all lines.
    """

    name: str
    lines: Annotated[tuple[str, ...], Field(max_length=MAX_LINES)] | None = None
    shared: StrictBool = False
    factor: tuple[_Number, _Number] | None = None
    range: tuple[Annotated[_Number, _OR_TEXT], Annotated[_Number, _OR_TEXT]] | None = None
    plus_minus: Annotated[_Width, _OR_TEXT] | None = None
    deviation: Annotated[_Width, _OR_TEXT] | None = None
    relative_deviation: _Width | None = None

    @model_validator(mode="before")
    @classmethod
    def _read_units(cls, data: Any) -> Any:
        """Convert texts with a unit to SI; the entry's name decides which units are allowed."""
        name = data.get("name") if isinstance(data, dict) else None
        if not isinstance(name, str):
            return data
        if name not in _KINDS:
            raise refusal("name", f"unknown parameter; {suggestion(name, _KINDS)}")
        kind = _KINDS[name][0]
        return data | {key: _si(kind, key, data[key]) for key in _WITH_UNIT if key in data}

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        given = [way for way in _WAYS if getattr(self, way) is not None]
        if not given:
            raise refusal("range", f"is missing: give one of {', '.join(_WAYS)}")
        if len(given) > 1:
            raise refusal(given[1], f"give either this or {given[0]}, not both")
        kind = _KINDS[self.name][0]
        fault = misuse(kind, self.lines, self.shared)
        if fault is not None:
            raise refusal(*fault)
        for key, ends in (("factor", self.factor), ("range", self.range)):
            require_rising(key, ends)
            if ends is not None and not kind.allows(ends[0]):  # a factor too: bounds are 0, nominal values above them
                raise refusal(key, kind.bound)
        return self

    @property
    def way(self) -> str:
        """The key of the entry that specifies the uncertainty, as ``plus_minus``."""
        return next(way for way in _WAYS if getattr(self, way) is not None)

    def of(self, robot: Described, coverage: float) -> tuple[Range, ...]:
        """Return the range of each parameter of the entry; `coverage` as in `Uncertainty`.

        Raises `InputError`, which begins with the wrong key, if the entry does not fit the robot.
        """
        found: list[Range] = []
        for kind in _KINDS[self.name]:
            fault = why_not(robot, kind, self.lines, self.shared)
            if fault is not None:
                raise self._refused(*fault)
            if kind.missing is not None:
                self._require_given(robot, kind)
            parameters = parameters_of(robot, kind.name, self.lines, self.shared)
            found += [self._range(robot, parameter, coverage) for parameter in parameters]
        return tuple(found)

    def _require_given(self, robot: Described, kind: Kind) -> None:
        """Raise `InputError` for a line that leaves out a number which the robot's statics leaves out then, too."""
        for line in robot.lines:
            if (self.lines is None or line.name in self.lines) and getattr(line, kind.name) is None:
                why = f"line {line.name!r} gives no {kind.name}: write {kind.missing:g} where the robot has none"
                raise self._refused("name", why)

    def _range(self, robot: Described, parameter: Parameter, coverage: float) -> Range:
        value, way = nominal(robot, parameter), self.way
        if value == 0.0 and way in _RELATIVE:
            why = f"the {parameter.label} of the file is 0, which no factor changes: give {_RELATIVE[way]}"
            raise self._refused(way, why)
        low, high, deviation = _ends(way, getattr(self, way), value, coverage)
        if not math.isfinite(high - low):
            raise self._refused(way, f"the {parameter.label} would not be finite")
        if not 0.5 * (high - low) > 0.0:
            raise self._refused(way, f"too narrow: rounding leaves one number, {value:g} {parameter.unit}")
        limits = _limits(robot, parameter)
        for lower, upper, why in limits:
            if low <= lower or high >= upper:
                raise self._refused(way, f"{parameter.label} from {low:g} to {high:g} {parameter.unit}: {why}")
        lower, upper = max(limit[0] for limit in limits), min(limit[1] for limit in limits)
        return Range(parameter, value, low, high, deviation, lower, upper)

    def _refused(self, key: str, why: str) -> InputError:
        value = getattr(self, key)
        shown = list(value) if isinstance(value, tuple) else value
        return InputError(f"{key} = {shown!r}: {why}")


class Uncertainty(FileDescription):
    """The uncertain parameters of a robot.

    ``coverage``: distance from the nominal value to the ends of the range, in standard deviations, where a deviation
    is given. ``zeroed_at``: position of the nozzle, m, where all lines were taut and the machine's lengths and
    coordinates were set to those of this position; None: they count from elsewhere. ``parameters``: with a
    ``zeroed_at`` by default those of `assumed_uncertainty`.
    """

    name: Annotated[str, Field(max_length=100)] = ""
    coverage: Annotated[float, Strict(), Field(gt=0, le=100)] = 2.0
    zeroed_at: Vec3 | None = None
    parameters: Annotated[tuple[Uncertain, ...], Field(max_length=MAX_ENTRIES)] = ()

    @model_validator(mode="after")
    def _is_not_empty(self) -> Self:
        # not by min_length, which also reports an error where every entry has its own
        if not self.parameters and self.zeroed_at is None:
            raise refusal(
                "parameters", "must have at least 1 entry" if "parameters" in self.model_fields_set else "is missing"
            )
        return self

    def of(self, robot: Described, origin: str = "the uncertainty") -> tuple[Range, ...]:
        """Return the range of every uncertain parameter of ``robot``, in the order of the entries.

        Raises `InputError`, one line with ``origin`` (the file), entry and key, for a parameter that the robot does not
        have or that is given twice, and for a range with invalid values.
        """
        try:
            return self.ranges(robot)
        except InputError as error:
            raise InputError(f"{origin}: {error}") from None

    def ranges(self, robot: Described) -> tuple[Range, ...]:
        """Return the ranges, see `of`, with messages that begin with the entry."""
        ranges: list[Range] = []
        givers: dict[tuple[str, str], int] = {}  # by kind and line
        for index, entry in enumerate(self.parameters or assumed_uncertainty(robot).parameters):
            try:
                found = entry.of(robot, self.coverage)
                for one in found:
                    _claim(givers, robot, one.parameter, index)
            except InputError as error:
                raise InputError(f"parameters[{index}].{error}") from None
            ranges += found
        if self.zeroed_at is None:
            return tuple(ranges)
        return tuple(replace(each, zeroing=_zeroing(robot, each.parameter, self.zeroed_at)) for each in ranges)


def _zeroing(robot: Described, parameter: Parameter, place: Vec3) -> tuple[float, ...]:
    """Return `Range.zeroing`, of straight lines of the unrotated platform with its nozzle at *place*, to first order.

    That is by as much as the parameter lengthens the way of a line there, or makes the cable out there longer.
    """
    if parameter.kind == "length_scale":
        return tuple(-_way(each, robot, place) * parameter.of_line(each.name) for each in robot.lines)
    if parameter.entry.base not in ("exit_point", "platform_point"):
        return (0.0,) * len(robot.lines)
    now = nominal(robot, parameter)
    less, more = (with_value(robot, parameter, now + step).lines for step in (-_STEP, _STEP))
    ways = [[_way(line, robot, place) for line in lines] for lines in (less, more)]
    return tuple((longer - shorter) / (2.0 * _STEP) for shorter, longer in zip(*ways, strict=True))


def _way(line: Line, robot: Described, place: Vec3) -> float:
    """Return the length of a line, m, with the nozzle at *place*: straight after its exit point, and its dead span."""
    ends = zip(place, robot.platform.nozzle, line.platform_point, line.exit_point, strict=True)
    dead = line.dead_length if line.winch_exit is None else line.dead_span().length
    return dead + line.advantage * math.hypot(*(p - q + b - a for p, q, b, a in ends))


def load_uncertainty(path: str | Path) -> Uncertainty:
    """Read an uncertainty from a TOML file.

    Raises `InputError`, one line with file, key, value and the allowed range.
    """
    return load_model(Uncertainty, path)


def assumed_uncertainty(robot: Described) -> Uncertainty:
    """Return the assumed uncertainty of a robot without a file.

    Exit points within 2 mm along each axis, lengths within 0.5 mm, the mass of the platform and of counterweights
    within 2 %, moduli within 10 % for steel and 30 % for fibre. A cable counts as steel if its mass fills its diameter,
    or else its section, with `STEEL_DENSITY` or more; where neither is known, as fibre.
    """
    steel = tuple(line.name for line in robot.lines if _is_steel(line.cable))
    fibre = tuple(line.name for line in robot.lines if line.name not in steel)
    moduli = [
        Uncertain(name="modulus", lines=lines, factor=factor)
        for lines, factor in ((steel, (0.9, 1.1)), (fibre, (0.7, 1.3)))
        if lines
    ]
    hung = tuple(line.name for line in robot.lines if line.counterweight is not None)
    entries = (
        Uncertain(name="exit_point", plus_minus=0.002),
        *moduli,
        Uncertain(name="length_offset", plus_minus=0.0005),
        Uncertain(name="mass", factor=(0.98, 1.02)),
        *([Uncertain(name="counterweight", lines=hung, factor=(0.98, 1.02))] if hung else []),
    )
    return Uncertainty(name=ASSUMED, parameters=entries)


def _is_steel(cable: Cable) -> bool:
    area = cable.load_section if cable.diameter is None else 0.25 * math.pi * cable.diameter**2
    return area is not None and cable.linear_density >= STEEL_DENSITY * area


def modulus_ranges(robot: Described, low: float = 0.7, high: float = 1.3) -> tuple[Range, ...]:
    """Return the range of each line's modulus between two factors. Raises `InputError`."""
    if not (0.0 < low < high and math.isfinite(high)):
        raise InputError(f"modulus range {low:g} to {high:g}: must be two finite factors above 0 that rise")
    if not hasattr(robot, "lines"):
        raise InputError(f"modulus_ranges: robot = {robot!r:.60}: a Robot is expected")
    return tuple(Range(parameter, 1.0, low, high, min_value=0.0) for parameter in parameters_of(robot, "modulus"))


def _si(kind: Kind, key: str, value: Any) -> Any:
    """Return the value of ``key`` with texts converted to SI; other values are left to the field's own check."""
    if isinstance(value, list | tuple):
        return [_si(kind, key, part) for part in value]
    if kind.dimension is None or not isinstance(value, str):
        return value
    try:
        return kind.dimension.read(value)
    except ValueError:
        raise refusal(key, kind.dimension.requirement) from None


def _ends(way: str, given: Any, value: float, coverage: float) -> tuple[float, float, float | None]:
    """Return low, high and the standard deviation (None if uniform) for the nominal ``value``."""
    match way:
        case "range":
            return (*given, None)
        case "factor":
            low, high = sorted(factor * value for factor in given)  # a coordinate may be negative
            return low, high, None
        case "plus_minus":
            return value - given, value + given, None
        case _:
            deviation = given * abs(value) if way == "relative_deviation" else given
            return value - coverage * deviation, value + coverage * deviation, deviation


def _limits(robot: Described, parameter: Parameter) -> list[Room]:
    """Return the ranges that the kind itself and the robot's lines allow, each with its reason."""
    kind, lines = parameter.entry, (line for line in robot.lines if parameter.line in (None, line.name))
    rooms = (kind.room(line, kind.name) for line in lines)
    least = math.nextafter(kind.min_value, -math.inf) if kind.closed else kind.min_value
    return [(least, math.inf, f"it {kind.bound}"), *(room for room in rooms if room is not None)]


def _claim(givers: dict[tuple[str, str], int], robot: Described, parameter: Parameter, index: int) -> None:
    """Record that entry ``index`` gives a parameter. Raises `InputError` if another entry does.

    A number that all lines share counts for each line.
    """
    whole = parameter.entry.per_line and parameter.line is None
    for name in [line.name for line in robot.lines] if whole else [parameter.line or ""]:
        giver = givers.setdefault((parameter.kind, name), index)
        if giver != index:
            label = Parameter(parameter.kind, name or None).label
            raise InputError(f"name: {label} is given by parameters[{giver}] already")
