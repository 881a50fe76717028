"""Kinds of parameters: where each is stored in a line or a platform, and how it is read and set."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeVar

from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Dimension, Vec3
from cablewright.robot.dead_span import Guide
from cablewright.robot.line import Line
from cablewright.robot.platform import Platform
from cablewright.robot.sheave import Swivel, UniversalJoint

AXES: Final = "xyz"
Owner = Literal["line", "all lines", "platform"]
Room = tuple[float, float, str]
"""Range that another part of a line allows a number: above the first value, below the second; and the reason."""

_Part = TypeVar("_Part", bound=Line | Platform)


@dataclass(frozen=True)
class Kind:
    """An entry of the registry of parameters.

    ``of``: owner of the value: each line, all lines together, or the platform. ``dimension``: None for a number in
    ``plain_unit``. ``role``: "hardware" is in a robot's description; "command" is a difference between true and
    commanded lengths; "load" is an effect of loads that no encoder counts; "winch" and "sensor" are known from a
    calibration only. ``path``: keys and axes of the value in the line or platform, by default the name, or of a value
    that the parameter needs. ``absent``: the message for a line without this value. ``body``: only rigid platforms have
    the parameter. ``shareable``: lines may have one value in common. ``nominal``: the value of a robot as its file
    describes it; None: the value in the file, or ``missing`` if the file leaves it out. Valid values are above
    ``min_value``, or also at it if ``closed``, and in the range ``room`` that the line allows. ``setter``: sets a value
    at a path, with all values that depend on it.
    """

    name: str
    dimension: Dimension | None
    of: Owner
    meaning: str
    role: Literal["hardware", "command", "winch", "load", "sensor"] = "hardware"
    path: str = ""
    absent: str = ""
    body: bool = False
    shareable: bool = False
    nominal: float | None = None
    missing: float | None = None
    min_value: float = -math.inf
    closed: bool = False
    plain_unit: str = "1"
    room: Callable[[Line, str], Room | None] = lambda _line, _name: None
    setter: Callable[[Any, str, float], Any] | None = None

    @property
    def per_line(self) -> bool:
        """Whether each line has a value of the parameter."""
        return self.of == "line"

    def is_of(self, line: Line) -> bool:
        """Return whether a line can have the parameter: with a counterweight it has none of a winch."""
        return line.counterweight is None or not (self.per_line and self.role in ("command", "winch"))

    @property
    def unit(self) -> str:
        """SI unit of the parameter, "1" for a factor."""
        return self.plain_unit if self.dimension is None else self.dimension.si

    @property
    def base(self) -> str:
        """Name of the parameter without its axis: exit_point of exit_point.x."""
        return self.name.partition(".")[0]

    @property
    def axis(self) -> int | None:
        """0 to 2 for x, y and z; None without an axis."""
        axis = self.name.partition(".")[2]
        return AXES.index(axis) if axis else None

    @property
    def described(self) -> bool:
        """Whether a robot's description always has it, or accepts it, so that it can be set."""
        return (self.nominal is None and self.missing is None) or self.setter is not None

    @property
    def bound(self) -> str:
        """Valid values of the parameter, as the end of a sentence."""
        return f"must be {'at least' if self.closed else 'above'} {self.min_value:g}"

    def allows(self, value: float) -> bool:
        """Return whether a ``value`` (SI) of the parameter is valid: above its minimum, or equal if that is allowed."""
        return value > self.min_value or (self.closed and value == self.min_value)

    def value(self, part: Line | Platform) -> float | None:
        """Return the parameter's value (SI) of a line or the platform; None if it has none."""
        if self.nominal is not None and not self.path:
            return self.nominal
        found: Any = part
        for key in (self.path or self.name).split("."):
            found = found[AXES.index(key)] if isinstance(found, tuple) else getattr(found, key, None)
        if found is None:
            return self.missing
        if isinstance(found, tuple) or not self.allows(found):
            return None
        return float(found) if self.nominal is None else self.nominal

    def put(self, part: _Part, value: float) -> _Part:
        """Return the line or the platform with another value (SI), not validated."""
        changed: _Part = (self.setter or _with)(part, self.path or self.name, value)
        return changed


def _with(part: Any, path: str, value: float) -> Any:
    """Return a part of a robot with another value at ``path``."""
    key, _, rest = path.partition(".")
    if isinstance(part, tuple):
        return tuple(value if axis == key else old for axis, old in zip(AXES, part, strict=True))
    return part.model_copy(update={key: _with(getattr(part, key), rest, value) if rest else value})


def with_compliance(line: Line, path: str, value: float) -> Line:
    """Return the line with another compliance of its mount; 0 leaves a line without a mount unchanged."""
    changed: Line = line if value == 0.0 and line.exit_compliance is None else _with(line, path, value)
    return changed


def with_build_up(line: Line, _path: str, value: float) -> Line:
    """Return the line with another build-up of its drum; none where that is 0 or less.

    Raises `InputError` for a line whose file has no build-up, and so no length at which its drum has its radius.
    """
    if line.winch.build_up is None:
        raise InputError(f"build_up: line {line.name!r} has no winch.build_up")
    winch = line.winch.model_copy(update={"build_up": value if value > 0.0 else None})
    return line.model_copy(update={"winch": winch})


def with_exit(line: Line, path: str, value: float) -> Line:
    """Return the line with another coordinate of its exit point; see `with_exit_point`."""
    return with_exit_point(line, _with(line, path, value).exit_point)


def with_exit_point(line: Line, point: Vec3, rise: float = 0.0) -> Line:
    """Return the line with another exit point (m); a modelled winch exit moves along in x and y, and up by ``rise``.

    Of a line out of the plane the winch exit, and eyelets and wheels between it and the sheave, move by the same
    vector.
    """
    x, y, z = (new - old for new, old in zip(point, line.exit_point, strict=True))
    if line.in_plane:
        z = rise
    update: dict[str, Any] = {"exit_point": point}
    if line.winch_exit is not None:
        way = (x, y, z)
        update |= {"winch_exit": _beside(line.winch_exit, way)}
        update |= {"guides": tuple(_guide_beside(guide, way) for guide in line.guides)}
    return line.model_copy(update=update)


def _beside(point: Vec3, way: Vec3) -> Vec3:
    return point[0] + way[0], point[1] + way[1], point[2] + way[2]


def _guide_beside(guide: Guide, way: Vec3) -> Guide:
    if isinstance(guide, tuple):
        return _beside(guide, way)
    return guide.model_copy(update={"centre": _beside(guide.centre, way)})


def with_modulus(line: Line, _path: str, factor: float) -> Line:
    """Return the line with ``factor`` times the axial stiffness, in the key that its file has."""
    key = "young_modulus" if line.cable.axial_stiffness is None else "axial_stiffness"
    return line.model_copy(update={"cable": _with(line.cable, key, factor * getattr(line.cable, key))})


def up_to_lever(line: Line, _name: str) -> Room | None:
    """Return the range of the sheave radius on a universal joint: up to the length of the lever."""
    if not isinstance(line.sheave, UniversalJoint):
        return None
    why = f"the lever of {line.name!r} is shorter, {line.sheave.lever:g} m"
    return -math.inf, math.nextafter(line.sheave.lever, math.inf), why


def above_winch(line: Line, name: str) -> Room | None:
    """Return the range of an exit point's height, which a modelled winch exit does not follow."""
    sheave = line.sheave
    if not name.endswith(".z") or line.winch_exit is None or not line.in_plane:
        return None
    if not isinstance(sheave, Swivel | UniversalJoint):
        return None
    height = line.winch_exit[2]
    why = f"it reaches the winch exit of {line.name!r}, at {height:g} m"
    return (height, math.inf, why) if sheave.wrap == "over" else (-math.inf, height, why)
