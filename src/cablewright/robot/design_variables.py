"""Design variables: single numbers that change a robot, such as the distance of exit points or the platform's width.

A name is one of `NAMED`, a kind of `KINDS` for all lines or the platform, or a kind for one line, as in
``exit_point.z@south``. Names joined by + take the same value: ``width-top-x+width-bottom-y``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from types import MappingProxyType
from typing import Final

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import Vec3
from cablewright.foundation.validation import validated
from cablewright.robot.line import Line
from cablewright.robot.parameter_values import AXES, with_exit_point
from cablewright.robot.parameters import KINDS, KINDS_OF, Parameter, parameters_of, with_value
from cablewright.robot.platform import RigidPlatform
from cablewright.robot.robot import Robot

SAME = 1e-9
"""Lengths that differ by less, as a share of the frame's diagonal, count as equal."""

_Setter = Callable[[Robot, float], Robot]


@dataclass(frozen=True)
class Change:
    """A design variable; ``name`` as in this module's docstring. Raises `InputError` for an unknown part of it."""

    name: str

    def __post_init__(self) -> None:
        for kind, line in self.parts:
            if kind in NAMED:
                if line is not None:
                    raise InputError(f"{kind} belongs to the whole robot, not to line {line!r}; leave @{line} out")
                continue
            if kind not in _OF_A_ROBOT:
                raise UnknownName("parameter", kind, [*NAMED, *_OF_A_ROBOT])
            if line is not None:
                Parameter(kind, line)

    @property
    def parts(self) -> tuple[tuple[str, str | None], ...]:
        """The names joined by +, each with its line or None."""
        split = [part.strip().partition("@") for part in self.name.split("+")]
        return tuple((kind.strip(), line.strip() or None) for kind, _, line in split)

    @property
    def unit(self) -> str:
        """SI unit of the changed number; "1" for a factor."""
        kind = self.parts[0][0]
        return UNITS.get(kind, "m") if kind in NAMED else KINDS[kind].unit

    def on(self, robot: Robot, value: float) -> Robot:
        """Return the robot with the variable at ``value`` (SI). Raises `InputError` if the robot cannot have it."""
        if not math.isfinite(value):
            raise InputError(f"{self.name} = {value}: must be a finite number")
        try:
            for kind, line in self.parts:
                if kind in NAMED:
                    robot = NAMED[kind](robot, value)
                    continue
                for parameter in parameters_of(robot, kind, line and (line,)):
                    robot = with_value(robot, parameter, value)
        except InputError as reason:
            raise InputError(f"{self.name} = {value:g}: {reason}") from None
        return validated(Robot, robot.model_dump(), f"{self.name} = {value:g}")


def changed(robot: Robot, values: Mapping[Change, float] | Mapping[str, float]) -> Robot:
    """Return the robot with each change made, in their order; a text is the name of a `Change`. Raises `InputError`."""
    for change, value in values.items():
        robot = (Change(change) if isinstance(change, str) else change).on(robot, value)
    return robot


def require_different(changes: Iterable[Change]) -> None:
    """Raise `InputError` where two changes set the same number."""
    names = [part for change in changes for part in change.parts]
    for kind, line in names:
        if names.count((kind, line)) > 1:
            raise InputError(f"{kind}: is varied more than once; give it once")


def with_box_inertia(robot: Robot) -> Robot:
    """Return the robot with the inertia of a uniform box around its platform points (Jung 2020, Eq. 6).

    Mass and centre of mass stay. Raises `InputError` for a point platform, or platform points on one line.
    """
    platform = robot.platform
    if not isinstance(platform, RigidPlatform):
        raise InputError(f"robot {robot.name!r}: a point platform has no inertia")
    xx, yy, zz = (_extent(line.platform_point[axis] for line in robot.lines) ** 2 for axis in range(3))
    moments = tuple(platform.mass / 12.0 * (one + other) for one, other in ((yy, zz), (xx, zz), (xx, yy)))
    if min(moments) <= 0.0:
        raise InputError(f"robot {robot.name!r}: its platform points are on one line, and a box of them has no inertia")
    return robot.with_platform(inertia=moments, inertia_products=(0.0, 0.0, 0.0))


def nearest_exits(robot: Robot) -> tuple[float, tuple[str, str]] | None:
    """Return the smallest distance between two exit points, m, and their lines; None for a single line."""
    pairs = [(math.dist(a.exit_point, b.exit_point), (a.name, b.name)) for a, b in combinations(robot.lines, 2)]
    return min(pairs, default=None)


def _set_exit_distance(robot: Robot, value: float) -> Robot:
    """Set the distance between exit points that are each other's nearest.

    Two at a corner of the frame, each on one of its walls, move along the walls; others along the line between them.
    """
    _require(value >= 0.0, "must be a length of 0 or more")
    exits = [line.exit_point for line in robot.lines]
    for i, j in _nearest_pairs(robot):
        now = math.dist(exits[i], exits[j])
        if now <= _tolerance(robot):
            names = f"lines {robot.lines[i].name!r} and {robot.lines[j].name!r}"
            raise InputError(f"the exit points of {names} coincide: the direction of their motion is undefined")
        middle = [0.5 * (a + b) for a, b in zip(exits[i], exits[j], strict=True)]
        fixed = _corner(robot, exits[i], exits[j]) or middle
        for k in (i, j):
            x, y, z = (f + (a - f) * value / now for f, a in zip(fixed, exits[k], strict=True))
            exits[k] = (x, y, z)
    return _with_lines(robot, [with_exit_point(line, at) for line, at in zip(robot.lines, exits, strict=True)])


def _nearest_pairs(robot: Robot) -> list[tuple[int, int]]:
    """Return pairs of lines whose exit points are nearest to each other. Raises `InputError` for a tie."""
    exits, nearest = [line.exit_point for line in robot.lines], []
    for i, own in enumerate(exits):
        order = sorted((math.dist(own, other), j) for j, other in enumerate(exits) if j != i)
        if len(order) > 1 and order[1][0] - order[0][0] <= _tolerance(robot):
            one, other = (repr(robot.lines[j].name) for _, j in order[:2])
            why = f"that of line {robot.lines[i].name!r} is as near to {one} as to {other}"
            raise InputError(f"the exit points of {robot.name!r} do not come in pairs: {why}")
        nearest.append(order[0][1] if order else i)
    return [(i, j) for i, j in enumerate(nearest) if i < j and nearest[j] == i]


def _corner(robot: Robot, one: Vec3, other: Vec3) -> Vec3 | None:
    """Return the corner of two walls, each with one of two exit points of equal height; None without one."""
    same, scene = _tolerance(robot), robot.scene
    if abs(one[2] - other[2]) > same:
        return None
    for x, y in product(*((scene.frame_min[axis], scene.frame_max[axis]) for axis in (0, 1))):
        on_x, on_y = ([abs(each[axis] - wall) <= same for each in (one, other)] for axis, wall in ((0, x), (1, y)))
        if sorted(zip(on_x, on_y, strict=True)) == [(False, True), (True, False)]:
            return x, y, one[2]
    return None


def _tolerance(robot: Robot) -> float:
    return SAME * math.dist(robot.scene.frame_min, robot.scene.frame_max)


def _width_setter(axis: int, upper: bool | None) -> _Setter:
    """Return the setter of the width of the platform's points along an axis: all, or the upper or lower half."""

    def set_width(robot: Robot, value: float) -> Robot:
        _require(value >= 0.0, "must be a length of 0 or more")
        chosen = _half(robot, upper)
        along = [robot.lines[i].platform_point[axis] for i in chosen]
        now, middle = _extent(along), 0.5 * (min(along) + max(along))
        where = "" if upper is None else f" of its {'top' if upper else 'bottom'}"
        _require(now > 0.0, f"the platform points{where} all have one {AXES[axis]}: there is no width to change")
        lines = list(robot.lines)
        for i in chosen:
            at = middle + (lines[i].platform_point[axis] - middle) * (value / now)
            lines[i] = KINDS_OF["platform_point"][axis].put(lines[i], at)
        return _with_lines(robot, lines)

    return set_width


def _spread_setter(axis: int) -> _Setter:
    """Return the setter of the extent of all exit points along an axis: they move in proportion, about their middle."""

    def set_spread(robot: Robot, value: float) -> Robot:
        _require(value >= 0.0, "must be a length of 0 or more")
        along = [line.exit_point[axis] for line in robot.lines]
        now, middle = _extent(along), 0.5 * (min(along) + max(along))
        _require(now > 0.0, f"the exit points all have one {AXES[axis]}: there is no extent to change")
        lines = []
        for line in robot.lines:
            x, y, z = (
                middle + (at - middle) * (value / now) if k == axis else at for k, at in enumerate(line.exit_point)
            )
            lines.append(with_exit_point(line, (x, y, z)))
        return _with_lines(robot, lines)

    return set_spread


def _limit_setter(end: int) -> _Setter:
    """Return the setter of the min (0) or max (1) tension of all lines."""

    def set_limit(robot: Robot, value: float) -> Robot:
        _require(value >= 0.0, "must be a tension of 0 or more")
        lines = []
        for line in robot.lines:
            low, high = (value if k == end else at for k, at in enumerate(line.tension_limits))
            _require(low < high, f"the tension limits of line {line.name!r} would be {low:g} to {high:g} N")
            lines.append(line.model_copy(update={"tension_limits": (low, high)}))
        return _with_lines(robot, lines)

    return set_limit


def _half(robot: Robot, upper: bool | None) -> list[int]:
    """Return the lines whose platform points are in the upper half, or the lower half; all for None."""
    _require(isinstance(robot.platform, RigidPlatform), f"{robot.name!r} is a point platform, which has no width")
    heights = [line.platform_point[2] for line in robot.lines]
    if upper is None:
        return list(range(robot.m))
    _require(_extent(heights) > 0.0, "the platform points are all at one height: it has no top and bottom")
    middle = 0.5 * (min(heights) + max(heights))
    return [i for i, height in enumerate(heights) if (height > middle) == upper]


def _with_lines(robot: Robot, lines: Sequence[Line]) -> Robot:
    return robot.model_copy(update={"lines": tuple(lines)})


def _extent(values: Iterable[float]) -> float:
    known = list(values)
    return max(known) - min(known)


def _require(fine: bool, why: str) -> None:
    if not fine:
        raise InputError(why)


NAMED: Final[Mapping[str, _Setter]] = MappingProxyType(
    {
        "exit-distance": _set_exit_distance,
        "width-x": _width_setter(0, None),
        "width-y": _width_setter(1, None),
        "width-top-x": _width_setter(0, True),
        "width-top-y": _width_setter(1, True),
        "width-bottom-x": _width_setter(0, False),
        "width-bottom-y": _width_setter(1, False),
        "exits-x": _spread_setter(0),
        "exits-y": _spread_setter(1),
        "retraction": Robot.retracted,
        "tension-min": _limit_setter(0),
        "tension-max": _limit_setter(1),
    }
)
"""Design variables with a setter of their own, each a length in m where `UNITS` says nothing else."""

UNITS: Final[Mapping[str, str]] = MappingProxyType({"tension-min": "N", "tension-max": "N"})

_OF_A_ROBOT: Final = tuple(kind.name for kind in KINDS.values() if kind.role == "hardware")
