"""One kind of changeable number: where it stands in a robot, ``cable.linear_density``, and how it is read and set."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple, TypeVar

from cablewright.robot.line import Line
from cablewright.robot.platform import Platform
from cablewright.robot.sheave import Eyelet, UniversalJoint
from cablewright.units import Dimension, Vec3

__all__ = [
    "AXES",
    "Kind",
    "Owner",
    "Room",
    "above_winch",
    "up_to_lever",
    "value_at",
    "with_exit_coordinate",
    "with_exit_point",
    "with_modulus",
    "with_value_at",
]

AXES: Final = "xyz"

Owner = Literal["line", "all lines", "platform"]

_Part = TypeVar("_Part")


class Room(NamedTuple):
    """What another part of a line leaves a number: values above ``least`` and below ``most``, and ``why``."""

    least: float
    most: float
    why: str


@dataclass(frozen=True)
class Kind:
    """One kind of number that can be changed: an entry of the registry.

    ``of``: each "line" has its own, or all have one together, or the platform. ``dimension`` is None for what is told
    in ``plain_unit``. ``role``: "hardware" is a number of the robot's description; "command" says how true lengths
    differ from commanded ones; "winch" what its counts stand for, of which only a calibration knows. ``path``: where it
    is in a line or the platform (its name, where not given), or what it acts by; a line without that is told
    ``absent``. ``body``: only rigid platforms have it. ``shareable``: lines may have one value in common. ``nominal``:
    the value that stands for the robot as its file describes it, None where the file gives the value itself. Values
    above ``least``, and in the ``room`` that a line leaves, have a physical meaning. ``setter``: makes a line with
    another value, where more changes than what is at ``path``.
    """

    name: str
    dimension: Dimension | None
    of: Owner
    meaning: str
    role: Literal["hardware", "command", "winch"] = "hardware"
    path: str = ""
    absent: str = ""
    body: bool = False
    shareable: bool = False
    nominal: float | None = None
    least: float = -math.inf
    plain_unit: str = "1"
    setter: Callable[[Line, float], Line] | None = None
    room: Callable[[Line], Room | None] | None = None

    @property
    def per_line(self) -> bool:
        """Whether each line has a value of its own."""
        return self.of == "line"

    @property
    def unit(self) -> str:
        """The SI unit, "1" for a factor."""
        return self.plain_unit if self.dimension is None else self.dimension.si

    @property
    def base(self) -> str:
        """The name without its axis."""
        return self.name.partition(".")[0]

    @property
    def axis(self) -> int | None:
        """0 to 2 for x, y and z; None without an axis."""
        axis = self.name.partition(".")[2]
        return AXES.index(axis) if axis else None

    @property
    def described(self) -> bool:
        """Whether it is in a robot's description, and so can be set there."""
        return self.nominal is None or self.setter is not None

    def allows(self, value: float) -> bool:
        """Whether a ``value`` (SI) has a physical meaning."""
        return value > self.least

    def value(self, part: Line | Platform) -> float | None:
        """Return the value (SI) of a line or the platform, None where it has no such number."""
        if self.nominal is not None and not self.path:
            return self.nominal
        found = value_at(part, self.path or self.name)
        if found is None or not self.allows(found):
            return None
        return found if self.nominal is None else self.nominal

    def put(self, line: Line, value: float) -> Line:
        """Return the line with another value (SI); nothing is validated."""
        return self.setter(line, value) if self.setter else with_value_at(line, self.path or self.name, value)


def value_at(part: object, path: str) -> float | None:
    """Return the number that a line or a platform has at ``path`` (SI); None where it has none."""
    found: Any = part
    for key in path.split("."):
        found = found[AXES.index(key)] if isinstance(found, tuple) else getattr(found, key, None)
    number: float | None = found
    return number


def with_value_at(part: _Part, path: str, value: float) -> _Part:
    """Return the line or platform with the number at ``path`` set to ``value`` (SI); nothing is validated."""
    made: Any = part
    key, _, rest = path.partition(".")
    if isinstance(part, tuple):
        made = tuple(value if axis == key else old for axis, old in zip(AXES, part, strict=True))
    else:
        made = made.model_copy(update={key: with_value_at(getattr(part, key), rest, value) if rest else value})
    changed: _Part = made
    return changed


def with_exit_point(line: Line, point: Vec3, rise: float = 0.0) -> Line:
    """Return the line with another exit point; a modelled winch exit follows sideways and goes up by ``rise`` (m)."""
    update: dict[str, Vec3] = {"exit_point": point}
    if line.winch_exit is not None:
        (x, y, z), was = line.winch_exit, line.exit_point
        update["winch_exit"] = (x + (point[0] - was[0]), y + (point[1] - was[1]), z + rise)
    return line.model_copy(update=update)


def with_exit_coordinate(axis: str, line: Line, value: float) -> Line:
    """Return the line with another coordinate of its exit point, m."""
    return with_exit_point(line, with_value_at(line.exit_point, axis, value))


def with_modulus(line: Line, factor: float) -> Line:
    """Return the line with a cable ``factor`` times as stiff."""
    given = {key: getattr(line.cable, key) for key in ("young_modulus", "axial_stiffness")}
    scaled = {key: factor * value for key, value in given.items() if value is not None}
    return line.model_copy(update={"cable": line.cable.model_copy(update=scaled)})


def up_to_lever(line: Line) -> Room | None:
    """Return what a universal joint leaves the radius of its sheave: as long as the lever is allowed."""
    if not isinstance(line.sheave, UniversalJoint):
        return None
    why = f"the lever of {line.name!r} is shorter, {line.sheave.lever:g} m"
    return Room(-math.inf, math.nextafter(line.sheave.lever, math.inf), why)


def above_winch(line: Line) -> Room | None:
    """Return what a modelled winch exit, which does not follow in height, leaves the height of an exit point."""
    if line.winch_exit is None or isinstance(line.sheave, Eyelet):
        return None
    height = line.winch_exit[2]
    why = f"it reaches the winch exit of {line.name!r}, at {height:g} m"
    return Room(height, math.inf, why) if line.sheave.wrap == "over" else Room(-math.inf, height, why)
