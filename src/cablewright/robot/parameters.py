"""The registry of a robot's parameters: the name of each, which robots have it, how it is read and set.

Uncertainty files, design variables, calibrations, the simulated machine's tolerances and the linearisation use it. A
new parameter is an entry of `KINDS`, and its columns in `cablewright.models.parameters`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, Protocol, Self, TypeVar

from cablewright.foundation.errors import InputError, UnknownName, suggestion
from cablewright.foundation.units import (
    ANGLE,
    FORCE,
    LENGTH,
    LINEAR_DENSITY,
    MASS,
    TEMPERATURE_DIFFERENCE,
    TORQUE,
    Dimension,
)
from cablewright.robot.line import Line
from cablewright.robot.parameter_values import (
    AXES,
    Kind,
    Owner,
    above_winch,
    up_to_lever,
    with_build_up,
    with_compliance,
    with_exit,
    with_modulus,
)
from cablewright.robot.platform import Platform, PointPlatform


class Described(Protocol):
    """Interface of a robot for its parameters: name, platform and lines."""

    @property
    def name(self) -> str:
        """Name of the robot."""

    @property
    def platform(self) -> Platform:
        """Platform of the robot."""

    @property
    def lines(self) -> tuple[Line, ...]:
        """Lines of the robot."""

    def model_copy(self, *, update: Mapping[str, Any]) -> Self:
        """Return a copy with other parts."""


R = TypeVar("R", bound=Described)


def _of_line(name: str, dimension: Dimension | None, meaning: str, **more: Any) -> Kind:
    return Kind(name, dimension, "line", meaning, shareable=True, **more)


def _vector(name: str, dimension: Dimension, of: Owner, meaning: str, **more: Any) -> tuple[Kind, ...]:
    return tuple(Kind(f"{name}.{axis}", dimension, of, meaning, **more) for axis in AXES)


_ALL: Final = (
    _of_line("modulus", None, "factor on EA", nominal=1.0, min_value=0.0, setter=with_modulus),
    *_vector("exit_point", LENGTH, "line", "exit point, world; a modelled winch exit follows sideways, not in height",
             room=above_winch, setter=with_exit),
    *_vector("platform_point", LENGTH, "line", "where the line is tied to a rigid platform, platform frame", body=True),
    _of_line("sheave_radius", LENGTH, "radius of the sheave", path="sheave.radius", min_value=0.0, room=up_to_lever,
             absent="line {!r} has an eyelet, which has no radius"),
    _of_line("linear_density", LINEAR_DENSITY, "mass of the cable per unstrained length", path="cable.linear_density",
             min_value=0.0, absent="the cable of line {!r} has no weight"),
    _of_line("length_offset", LENGTH, "true unstrained length paid out minus the commanded one", role="command",
             nominal=0.0),
    _of_line("length_scale", None, "true length paid out over the commanded", role="command", nominal=1.0,
             min_value=0.0),
    _of_line("drum_radius", LENGTH, "radius of the winch's drum", role="winch", path="winch.drum_radius", min_value=0.0,
             absent="line {!r} gives no winch.drum_radius to start from: use length_scale"),
    _of_line("build_up", None, "share of its radius that a drum loses per length paid out", role="winch", missing=0.0,
             path="winch.build_up", plain_unit="1/m", setter=with_build_up),
    Kind("counterweight", MASS, "line", "mass that pulls all cables of a line", min_value=0.0,
         absent="line {!r} has no counterweight: name the lines that have one"),
    _of_line("creep_compliance", None, "strain per tension by which the cable has crept, besides its stretch by EA",
             role="load", nominal=0.0, min_value=0.0, closed=True, plain_unit="1/N"),
    _of_line("exit_compliance", None, "how far the mount of the exit point gives along a force on it", role="load",
             missing=0.0, min_value=0.0, closed=True, plain_unit="m/N", setter=with_compliance,
             absent="line {!r} gives exit_compliance as a matrix, which is no single number"),
    Kind("temperature", TEMPERATURE_DIFFERENCE, "all lines",
         "how much warmer all cables are: a strain of thermal_expansion times it on the commanded lengths",
         role="command", path="cable.thermal_expansion", shareable=True, nominal=0.0,
         absent="line {!r} gives no cable.thermal_expansion, which this needs"),
    Kind("mass", MASS, "platform", "mass of the platform", min_value=0.0),
    *_vector("centre_of_mass", LENGTH, "platform", "centre of mass of a rigid platform, platform frame", body=True),
    *_vector("force", FORCE, "platform", "force on the platform besides its weight and the lines, world"),
    *_vector("moment", TORQUE, "platform",
             "moment on a rigid platform about its origin besides that of the force, world", body=True),
    _of_line("tension_offset", FORCE, "true tension less the scaled reading of the load cell", role="sensor",
             nominal=0.0),
    _of_line("tension_scale", None, "change of the true tension over that of the reading", role="sensor", nominal=1.0,
             min_value=0.0),
    _of_line("swivel_offset", ANGLE, "true azimuth of the free cable less the reading", role="sensor", nominal=0.0),
    *(Kind(f"tilt_offset.{axis}", ANGLE, "platform", f"true tilt of a rigid platform about {axis} less the reading",
           role="sensor", body=True, nominal=0.0) for axis in "xy"),
    Kind("yaw_offset", ANGLE, "platform", "true yaw of a rigid platform less the reading", role="sensor", body=True,
         nominal=0.0),
)  # fmt: skip

KINDS: Final[Mapping[str, Kind]] = MappingProxyType({kind.name: kind for kind in _ALL})
"""Every kind by its name, in the order of tables."""

KINDS_OF: Final[Mapping[str, tuple[Kind, ...]]] = MappingProxyType(
    {base: tuple(each for each in _ALL if each.base == base) for base in dict.fromkeys(kind.base for kind in _ALL)}
    | {name: (kind,) for name, kind in KINDS.items()}
)
"""As `KINDS`, and the three axes of a point or a vector by one name: ``exit_point``."""


@dataclass(frozen=True)
class Parameter:
    """One number: its kind, and its line; None: a number of the platform, or one that all lines share.

    Raises `InputError` for an unknown kind, a line for a kind without lines, or None for a kind lines cannot share.
    """

    kind: str
    line: str | None = None

    def __post_init__(self) -> None:
        kind = _kind(self.kind)
        fault = misuse(kind, None if self.line is None else (self.line,), kind.per_line and self.line is None)
        if fault is not None:
            raise InputError(f"{self.kind}: {fault[1]}")

    def of_line(self, name: str) -> bool:
        """Whether the parameter is a number of the line *name*."""
        return self.line in (None, name)

    @property
    def entry(self) -> Kind:
        """Entry of the parameter in the registry."""
        return KINDS[self.kind]

    @property
    def unit(self) -> str:
        """The SI unit, "1" for a factor."""
        return self.entry.unit

    @property
    def label(self) -> str:
        """The name in texts: "modulus of south-west", "exit point x of south-west", "modulus of all lines", "mass"."""
        words = self.kind.replace("_", " ").replace(".", " ")
        if not self.entry.per_line:
            return words
        return f"{words} of {'all lines' if self.line is None else self.line}"


def parameters_of(
    robot: Described, kind: str, lines: Sequence[str] | None = None, shared: bool = False
) -> tuple[Parameter, ...]:
    """Return the parameters of one ``kind``: one per line, in the robot's order, or a single one.

    ``lines``: names of the lines, None for all that can have it; ``shared``: one number that all lines have in common.
    Raises `InputError` for an unknown kind or line, and for a parameter that this robot does not have.
    """
    fault = why_not(robot, _kind(kind), lines, shared)
    if fault is not None:
        raise InputError(f"{kind}: {fault[1]}")
    if shared or not KINDS[kind].per_line:
        return (Parameter(kind),)
    own = (line.name for line in robot.lines if KINDS[kind].is_of(line))
    return tuple(Parameter(kind, name) for name in own if lines is None or name in lines)


def nominal(robot: Described, parameter: Parameter) -> float:
    """Return the value (SI) in the robot file; 1 for a factor, 0 for an offset.

    Raises `InputError` if the robot has no such line or number, or if the lines that share it have different values.
    """
    _require(robot, parameter)
    line = next(line for line in robot.lines if parameter.of_line(line.name))
    value = parameter.entry.value(robot.platform if parameter.entry.of == "platform" else line)
    assert value is not None  # checked by why_not
    return value


def with_value(robot: R, parameter: Parameter, value: float) -> R:
    """Return the robot with another ``value`` (SI) of one parameter; the whole robot is not validated.

    Raises `InputError` as `nominal`, for a value out of the kind's bounds and for a parameter that no robot file has.
    """
    kind = parameter.entry
    _require(robot, parameter)
    if not kind.described:
        raise InputError(f"{kind.name}: is not a number of a robot file")
    if not kind.allows(value):
        raise InputError(f"it {kind.bound}")
    if kind.of == "platform":
        return robot.model_copy(update={"platform": kind.put(robot.platform, value)})
    lines = (kind.put(line, value) if parameter.of_line(line.name) else line for line in robot.lines)
    return robot.model_copy(update={"lines": tuple(lines)})


def _require(robot: Described, parameter: Parameter) -> None:
    """Raise `InputError` if the robot does not have the parameter."""
    shared = parameter.entry.per_line and parameter.line is None
    fault = why_not(robot, parameter.entry, None if parameter.line is None else (parameter.line,), shared)
    if fault is not None:
        raise InputError(f"{parameter.kind}: {fault[1]}")


def misuse(kind: Kind, lines: Sequence[str] | None, shared: bool) -> tuple[str, str] | None:
    """Return which key, "lines" or "shared", is wrong for this ``kind`` in any robot, and why; None if neither."""
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


def why_not(robot: Described, kind: Kind, lines: Sequence[str] | None, shared: bool) -> tuple[str, str] | None:
    """Return which key ("name", "lines", "shared") is wrong for this robot, and why; None if it has the parameters."""
    return misuse(kind, lines, shared) or next(_refusals(robot, kind, lines, shared), None)


def _refusals(robot: Described, kind: Kind, lines: Sequence[str] | None, shared: bool) -> Iterator[tuple[str, str]]:
    names = [line.name for line in robot.lines]
    for name in lines or ():
        if name not in names:
            yield "lines", f"unknown line {name!r}; {suggestion(name, names)}"
    if kind.body and isinstance(robot.platform, PointPlatform):
        yield "name", f"{robot.name!r} is a point platform, which has no {kind.base}"
    where = "name" if lines is None else "lines"
    for line in robot.lines if kind.of != "platform" else ():
        if lines is not None and line.name not in lines:
            continue
        if not kind.is_of(line):
            if lines is not None:
                yield where, f"line {line.name!r} has a counterweight and no winch"
        elif kind.value(line) is None:
            yield where, kind.absent.format(line.name)
    if shared and kind.per_line:
        yield from _differences(robot, kind)


def _differences(robot: Described, kind: Kind) -> Iterator[tuple[str, str]]:
    """Yield the lines whose value differs from the first line's."""
    first, *others = robot.lines
    for other in others:
        one, two = kind.value(first), kind.value(other)
        if one != two:
            unlike = f"{one:g} {kind.unit} of {first.name!r}, {two:g} {kind.unit} of {other.name!r}"
            yield "shared", f"the lines have no {kind.name} in common: {unlike}"


def _kind(name: str) -> Kind:
    if name not in KINDS:
        raise UnknownName("parameter", name, KINDS)
    return KINDS[name]
