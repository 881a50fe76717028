"""The numbers of a robot that may be uncertain: what each is called, which robots have it, what the file says it is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from cablewright.errors import InputError, UnknownName, suggestion
from cablewright.robot.line import Line
from cablewright.robot.platform import PointPlatform
from cablewright.robot.robot import Robot
from cablewright.robot.sheave import Eyelet
from cablewright.units import FORCE, LENGTH, LINEAR_DENSITY, MASS, TEMPERATURE_DIFFERENCE, TORQUE, Dimension, Vec3

__all__ = ["AXES", "KINDS", "Kind", "Parameter", "misuse", "nominal", "parameters_of", "why_not"]

AXES: Final = "xyz"


@dataclass(frozen=True)
class Kind:
    """One kind of number that may be uncertain.

    ``dimension`` is None for a plain factor, whose unit is "1". A kind that is ``per_line`` has a value for each line;
    one that is ``shareable`` may have one value for all lines. ``nominal`` is the value that stands for the robot as
    its file describes it, None where the file itself gives the value. Only values above ``least`` have a physical
    meaning.
    """

    name: str
    dimension: Dimension | None
    per_line: bool
    meaning: str
    shareable: bool = False
    nominal: float | None = None
    least: float = -math.inf

    @property
    def unit(self) -> str:
        """The SI unit, "1" for a factor."""
        return "1" if self.dimension is None else self.dimension.si

    def allows(self, value: float) -> bool:
        """Whether a ``value`` (SI) has a physical meaning."""
        return value > self.least


def _axes(name: str, dimension: Dimension, meaning: str, per_line: bool = False) -> tuple[Kind, ...]:
    return tuple(Kind(f"{name}.{axis}", dimension, per_line, meaning) for axis in AXES)


_ALL = (
    Kind("modulus", None, True, "factor on EA", shareable=True, nominal=1.0, least=0.0),
    *_axes(
        "exit_point", LENGTH, "exit point, world; a modelled winch exit follows sideways, not in height", per_line=True
    ),
    *_axes("platform_point", LENGTH, "where the line is tied to a rigid platform, platform frame", per_line=True),
    Kind("sheave_radius", LENGTH, True, "radius of the sheave", shareable=True, least=0.0),
    Kind(
        "linear_density",
        LINEAR_DENSITY,
        True,
        "mass of the cable per unstrained length",
        shareable=True,
        least=0.0,
    ),
    Kind(
        "length_offset",
        LENGTH,
        True,
        "true unstrained length paid out minus the commanded one",
        shareable=True,
        nominal=0.0,
    ),
    Kind("length_scale", None, True, "true length paid out over the commanded", shareable=True, nominal=1.0, least=0.0),
    Kind(
        "temperature",
        TEMPERATURE_DIFFERENCE,
        False,
        "how much warmer all cables are: a strain of thermal_expansion times it on the commanded lengths",
        shareable=True,
        nominal=0.0,
    ),
    Kind("mass", MASS, False, "mass of the platform", least=0.0),
    *_axes("centre_of_mass", LENGTH, "centre of mass of a rigid platform, platform frame"),
    *_axes("force", FORCE, "force on the platform besides its weight and the lines, world"),
    *_axes("moment", TORQUE, "moment on a rigid platform about its origin besides that of the force, world"),
)

KINDS: Final[Mapping[str, Kind]] = MappingProxyType({kind.name: kind for kind in _ALL})
"""Every kind by its name, in the order in which tables list them."""

_OF_A_BODY = ("platform_point", "centre_of_mass", "moment")


@dataclass(frozen=True)
class Parameter:
    """One uncertain number: its kind, and the line it is of; None: of the platform, or one number all lines share.

    Raises `InputError` for an unknown kind, a line of a kind that has none, or None for a kind lines cannot share.
    """

    kind: str
    line: str | None = None

    def __post_init__(self) -> None:
        kind = _kind(self.kind)
        fault = misuse(kind, None if self.line is None else (self.line,), kind.per_line and self.line is None)
        if fault is not None:
            raise InputError(f"{self.kind}: {fault[1]}")

    @property
    def unit(self) -> str:
        """The SI unit, "1" for a factor."""
        return KINDS[self.kind].unit

    @property
    def label(self) -> str:
        """What people read: "modulus of south-west", "exit point x of south-west", "modulus of all lines", "mass"."""
        words = self.kind.replace("_", " ").replace(".", " ")
        if not KINDS[self.kind].per_line:
            return words
        return f"{words} of {'all lines' if self.line is None else self.line}"


def parameters_of(
    robot: Robot, kind: str, lines: Sequence[str] | None = None, shared: bool = False
) -> tuple[Parameter, ...]:
    """Return the parameters of one ``kind``: one per line, in the robot's order, or one alone.

    ``lines`` names the lines, None means all; ``shared`` asks for one number that all lines have in common. Raises
    `InputError` for an unknown kind or line, and for what this robot does not have or no robot can.
    """
    fault = why_not(robot, _kind(kind), lines, shared)
    if fault is not None:
        raise InputError(f"{kind}: {fault[1]}")
    if shared or not KINDS[kind].per_line:
        return (Parameter(kind),)
    return tuple(Parameter(kind, line.name) for line in robot.lines if lines is None or line.name in lines)


def nominal(robot: Robot, parameter: Parameter) -> float:
    """Return the value (SI) that the robot file gives; 1 for a factor, 0 for an offset.

    Raises `InputError` if the robot has no such line or number, or if lines that should share a number differ in it.
    """
    kind = KINDS[parameter.kind]
    lines = None if parameter.line is None else (parameter.line,)
    fault = why_not(robot, kind, lines, shared=kind.per_line and lines is None)
    if fault is not None:
        raise InputError(f"{kind.name}: {fault[1]}")
    if kind.per_line:
        line = next(line for line in robot.lines if parameter.line in (None, line.name))
        return _of_line(line, kind)
    return _of_platform(robot, kind)


def misuse(kind: Kind, lines: Sequence[str] | None, shared: bool) -> tuple[str, str] | None:
    """Return which of "lines" and "shared" no robot can give this ``kind``, and why; None where some can."""
    if lines is not None:
        if shared:
            return "shared", "is one number for all lines: leave out this or lines"
        if not kind.per_line:
            whose = "one number for all lines" if kind.shareable else "a number of the platform"
            return "lines", f"{kind.name} is {whose}, not of a line"
        if not lines:
            return "lines", "must name at least one line"
        for name in lines:
            if lines.count(name) > 1:
                return "lines", f"names {name!r} more than once"
    if shared and not kind.shareable:
        why = "each line has its own" if kind.per_line else "it is a number of the platform"
        return "shared", f"{kind.name} cannot be shared by lines: {why}"
    return None


def why_not(robot: Robot, kind: Kind, lines: Sequence[str] | None, shared: bool) -> tuple[str, str] | None:
    """Return which of "name", "lines" and "shared" this robot refuses, and why; None where it has the parameters."""
    return misuse(kind, lines, shared) or next(_refusals(robot, kind, lines, shared), None)


def _refusals(robot: Robot, kind: Kind, lines: Sequence[str] | None, shared: bool) -> Iterator[tuple[str, str]]:
    names = [line.name for line in robot.lines]
    for name in lines or ():
        if name not in names:
            yield "lines", f"unknown line {name!r}; {suggestion(name, names)}"
    base = kind.name.partition(".")[0]
    if base in _OF_A_BODY and isinstance(robot.platform, PointPlatform):
        yield "name", f"{robot.name!r} is a point platform, which has no {base}"
    for line in robot.lines:
        if lines is not None and line.name not in lines:
            continue
        if base == "sheave_radius" and isinstance(line.sheave, Eyelet):
            yield "name" if lines is None else "lines", f"line {line.name!r} has an eyelet, which has no radius"
        if base == "linear_density" and line.cable.linear_density == 0.0:
            yield "name" if lines is None else "lines", f"the cable of line {line.name!r} has no weight"
        if base == "temperature" and line.cable.thermal_expansion is None:
            yield "name", f"line {line.name!r} gives no cable.thermal_expansion, which this needs"
    if shared and kind.per_line:
        yield from _differences(robot, kind)


def _differences(robot: Robot, kind: Kind) -> Iterator[tuple[str, str]]:
    """Yield where lines that should share one number have different ones."""
    first, *others = robot.lines
    for other in others:
        one, two = _of_line(first, kind), _of_line(other, kind)
        if one != two:
            unlike = f"{one:g} {kind.unit} of {first.name!r}, {two:g} {kind.unit} of {other.name!r}"
            yield "shared", f"the lines have no {kind.name} in common: {unlike}"


def _of_line(line: Line, kind: Kind) -> float:
    if kind.nominal is not None:
        return kind.nominal
    if kind.name == "linear_density":
        return line.cable.linear_density
    if kind.name == "sheave_radius":
        assert not isinstance(line.sheave, Eyelet)  # why_not saw to it
        return line.sheave.radius
    return _component(line, kind)


def _of_platform(robot: Robot, kind: Kind) -> float:
    if kind.nominal is not None:
        return kind.nominal
    return robot.platform.mass if kind.name == "mass" else _component(robot.platform, kind)


def _component(part: object, kind: Kind) -> float:
    """Return the coordinate of a part that ``exit_point.x`` and its like name."""
    key, _, axis = kind.name.partition(".")
    vector: Vec3 = getattr(part, key)
    return vector[AXES.index(axis)]


def _kind(name: str) -> Kind:
    if name not in KINDS:
        raise UnknownName("parameter", name, KINDS)
    return KINDS[name]
