"""The unknowns of a calibration: which numbers of a robot are estimated, and where each is stored."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.validation import validated
from cablewright.kernels import layout
from cablewright.kernels.fitting import line_over_sheave
from cablewright.models.pack import guided_lines
from cablewright.models.parameters import lines_of
from cablewright.models.plane import directions
from cablewright.robot import Line, Robot, Swivel, UniversalJoint
from cablewright.robot.direction import unit_vector
from cablewright.robot.parameter_values import AXES
from cablewright.robot.parameters import KINDS_OF, Parameter, nominal, parameters_of, why_not, with_value

_COLUMNS: Final = {
    "exit_point": line_over_sheave.EXIT,
    "platform_point": line_over_sheave.POINT,
    "sheave_radius": line_over_sheave.RADIUS,
    "length_offset": line_over_sheave.OFFSET,
    "length_scale": line_over_sheave.SCALE,
    "drum_radius": line_over_sheave.SCALE,
    "build_up": line_over_sheave.BUILD_UP,
    "exit_compliance": line_over_sheave.COMPLIANCE,
    "modulus": -1,  # stiff lines have none
    "centre_of_mass": -1,  # equilibria depend on it, lengths of straight lines do not
    "tension_offset": line_over_sheave.TENSION_OFFSET,
    "tension_scale": line_over_sheave.TENSION_SCALE,
    "swivel_offset": line_over_sheave.SWIVEL_OFFSET,
    "tilt_offset": line_over_sheave.TILT_OFFSET,
    "yaw_offset": line_over_sheave.YAW_OFFSET,
}
NAMES: Final = tuple(_COLUMNS)
"""Names of the numbers that may be unknown, as in the parameter registry."""

COORDINATES: Final = tuple(kind.name for name in NAMES for kind in KINDS_OF[name] if kind.axis is not None)
"""Names of the unknowns that have an axis, such as ``exit_point.z``."""

BOUNDED: Final = tuple(name for name in NAMES if name != "centre_of_mass" and not name.endswith("_point"))
"""Names of the unknowns that are no coordinates of points. A plan may give their range, of a tilt one for both axes."""

DEFAULT: Final = ("exit_point", "length_offset")
"""The default unknowns, those of Wang and Caro 2021."""

_HARDWARE: Final[dict[str, Callable[[Line], object]]] = {
    "build_up": lambda line: (line.winch.drum_radius, line.cable.diameter),
    "modulus": lambda line: line.cable,
}
"""Parts that must be equal for lines that share one such unknown."""

OF_DRUM: Final = ("length_scale", "drum_radius", "build_up")
"""Unknowns of a winch's drum, which lines may share."""

_SIZES: Final = {"exit_compliance": line_over_sheave.PER_NEWTON}
_DIGITS: Final = 12  # decimal places, m, of numbers in a robot file


@dataclass(frozen=True)
class Unknown(Parameter):
    """One parameter to be estimated.

    ``size``: the scale of the number that is solved for: a drum's nominal radius, 1 m/kN, otherwise 1. ``others``: the
    lines that share it with ``line``, in a group.
    """

    size: float = 1.0
    others: tuple[str, ...] = ()

    def of_line(self, name: str) -> bool:
        """Return whether the unknown is a number of the line *name*."""
        return self.line in (None, name) or name in self.others

    @property
    def name(self) -> str:
        """Name of the unknown without an axis: ``exit_point`` for ``exit_point.x``."""
        return self.entry.base

    @property
    def axis(self) -> int | None:
        """Index of the axis, 0 to 2, if the unknown is a coordinate of a point; otherwise None."""
        return self.entry.axis

    @property
    def label(self) -> str:
        """The name for people: "exit point x of south-west", "sheave radius of all lines"."""
        return ", ".join((super().label.replace("length offset", "home length"), *self.others))

    @property
    def in_file(self) -> bool:
        """Whether a robot file contains the number, at least as a default of 1 or 0: not home lengths and sensors."""
        return self.name != "length_offset" and self.entry.role != "sensor"

    @property
    def of_equilibrium(self) -> bool:
        """Whether equilibria depend on the unknown: it belongs to the line or its mount, not to the winch."""
        return self.entry.role == "hardware" or self.name == "exit_compliance"

    @property
    def column(self) -> int:
        """Column of the unknown in the table of a line's numbers, or -1."""
        first = _COLUMNS.get(self.name, -1)
        return first if first < 0 else first + (self.axis or 0)


def unknowns_of(
    robot: Robot,
    names: Sequence[str] = DEFAULT,
    shared: Sequence[str] = (),
    elastic: bool = False,
    groups: Sequence[tuple[str, Sequence[str]]] = (),
) -> tuple[Unknown, ...]:
    """Return the unknowns with these ``names``, line by line; those in ``shared`` are one number for all lines.

    *groups*: names of an unknown, and of the lines that have one number in common. Raises `InputError` for an unknown
    name, one given twice, and a number that this robot does not have.
    """
    for name, _ in groups:
        if name not in names or name in shared:
            why = "is shared by all lines" if name in shared else "is not among the unknowns"
            raise InputError(f"groups: {name!r} {why}")
        if name == "length_offset" or not KINDS_OF[name][0].shareable:
            raise InputError(f"groups: {name!r} cannot be one number for several lines")
    found: list[Unknown] = []
    for name in names:
        if name not in NAMES:
            raise UnknownName("unknown", name, NAMES)
        if name == "modulus" and not elastic:
            raise InputError("unknowns: modulus: rigid lines do not stretch; use elastic or catenary ones")
        if name == "centre_of_mass" and not elastic:
            raise InputError("unknowns: centre_of_mass: only equilibria depend on it; use elastic or catenary lines")
        if names.count(name) > 1:
            raise InputError(f"unknowns: {name!r} is given more than once")
        found += _grouped(robot, _unknowns(robot, name, name in shared), [lines for of, lines in groups if of == name])
    for name in shared:
        if name not in names:
            raise InputError(f"shared: {name!r} is not among the unknowns")
    if "drum_radius" in names and "length_scale" in names:
        raise InputError("unknowns: drum_radius and length_scale are the same number: leave out one")
    return tuple(found)


def _unknowns(robot: Robot, name: str, shared: bool) -> Iterator[Unknown]:
    """Yield the unknowns of one *name*, line by line. Raises `InputError` if this robot does not have them."""
    kinds, lines = KINDS_OF[name], None
    if shared and (name == "length_offset" or not kinds[0].shareable):
        raise InputError(f"shared: {name!r} cannot be one number for all lines")
    if name in ("sheave_radius", "exit_compliance") and not shared:  # with an eyelet or by a matrix lines have none
        lines = [line.name for line in robot.lines if kinds[0].value(line) is not None] or None
    if name in OF_DRUM and robot.sharing and not shared:  # a drum is that of its first line
        lines = list(robot.winch_names)
    stiff = [line.name for line in robot.lines if not line.may_give] if name == "exit_compliance" else []
    if (stiff and shared) or len(stiff) == robot.m:
        why = "comes from aside of its swivel's axis: its mount cannot be compliant; leave it out"
        raise InputError(f"unknowns: exit_compliance: the cable of line {stiff[0]!r} {why}")
    if stiff:
        lines = [line for line in lines or [line.name for line in robot.lines] if line not in stiff]
    fault = why_not(robot, kinds[0], lines, shared)
    if fault is not None:
        raise InputError(f"{'shared' if fault[0] == 'shared' else 'unknowns'}: {name}: {fault[1]}")
    found = [parameters_of(robot, kind.name, lines, shared) for kind in kinds]
    for parameter in chain.from_iterable(zip(*found, strict=True)):
        size = nominal(robot, parameter) if name == "drum_radius" else _SIZES.get(name, 1.0)
        yield Unknown(parameter.kind, parameter.line, size)


def _grouped(robot: Robot, found: Iterator[Unknown], groups: Sequence[Sequence[str]]) -> Iterator[Unknown]:
    """Yield unknowns, those of the lines of a group as one: that of its first line in the robot's order.

    Raises `InputError` for lines that are unknown, in two groups, or of different values in the file.
    """
    group_of: dict[str | None, Sequence[str]] = {}
    for group in groups:
        for name in group:
            line_index(robot, name, "groups")
            if name in group_of:
                raise InputError(f"groups: line {name!r} is in it twice")
            group_of[name] = group
    given = list(found)
    for member in group_of if given and given[0].line is not None else ():
        if not any(each.line == member for each in given):
            raise InputError(
                f"groups: {given[0].name}: line {member!r} does not have this number; leave the line out of the group"
            )
    value_of = {each.line: nominal(robot, each) for each in given} if groups else {}
    for each in given:
        group = [one.line for one in given if one.line is not None and one.line in group_of.get(each.line, ())]
        if len(group) < 2:
            yield each
        elif group[0] == each.line:
            parts = {
                _HARDWARE[each.name](line) for line in robot.lines if each.name in _HARDWARE and line.name in group
            }
            if len({value_of[name] for name in group}) > 1 or len(parts) > 1:
                why = "of different drums or cables" if len(parts) > 1 else "not one number in the robot file"
                raise InputError(f"groups: {each.name} of {', '.join(map(str, group))}: {why}")
            yield replace(each, others=tuple(group[1:]))


def line_index(robot: Robot, name: str, where: str) -> int:
    """Return the index of a line. Raises `InputError` for an unknown one, with the place *where* the plan names it."""
    names = [line.name for line in robot.lines]
    if name not in names:
        raise InputError(f"{where}: {UnknownName('line', name, names)}")
    return names.index(name)


def with_mounts(robot: Robot) -> Robot:
    """Return the robot with a compliance for the mount of each exit point that can have one: that of the file, else 0.

    A swivel whose winch is aside of its axis cannot.
    """
    given = ({"exit_compliance": line.exit_compliance or 0.0} if line.may_give else {} for line in robot.lines)
    rigid = (line.model_copy(update=own) for line, own in zip(robot.lines, given, strict=True))
    return robot.model_copy(update={"lines": tuple(rigid)})


def column_of(name: str) -> int:
    """Return the column of a number without axes in the table of a line's numbers."""
    return _COLUMNS[name]


def numbers_of_lines(robot: Robot, by_drum: Sequence[bool] = (), elastic: bool = False) -> Array:
    """Return the numbers (m, COLUMNS) of a robot's lines for `kernels.fitting.line_over_sheave`.

    Offsets are 0, scales 1. A sheave on a universal joint counts as swivelling: a rigid line has no lever balance.
    Cable before the exit point keeps its length, or of a winch aside of the swivel's axis, that before its last guide.
    *by_drum*: lines whose counts are of a drum with the file's build-up; *elastic*: home lengths are those of the file,
    not from the exit point on.
    """
    lines, guided = np.zeros((robot.m, line_over_sheave.COLUMNS)), guided_lines(robot)
    for at in np.flatnonzero(by_drum):
        winch, dead = robot.lines[at].winch, 0.0 if elastic else _dead_lengths(robot)[at]
        lines[at, line_over_sheave.BUILD_UP] = winch.build_up or 0.0
        lines[at, line_over_sheave.WOUND] = (winch.drum_length or 0.0) - dead
    for row, line in zip(lines, robot.lines, strict=True):
        row[line_over_sheave.EXIT : line_over_sheave.EXIT + 3] = line.exit_point
        row[line_over_sheave.POINT : line_over_sheave.POINT + 3] = line.platform_point
        row[[line_over_sheave.SCALE, line_over_sheave.TENSION_SCALE]] = 1.0
        row[line_over_sheave.SPANS] = line.advantage
        row[line_over_sheave.PULL] = line.advantage * line.cables
        row[line_over_sheave.AXIS : line_over_sheave.AXIS + 3] = line.swivel_axis
        if line.last_guide is not None:
            x, y, z = (there - here for there, here in zip(line.last_guide, line.exit_point, strict=True))
            row[line_over_sheave.FROM : line_over_sheave.FROM + 3] = unit_vector((x, y, z))
        if isinstance(line.sheave, Swivel | UniversalJoint):
            row[line_over_sheave.RADIUS] = line.sheave.radius
            row[line_over_sheave.SIDE] = 1.0 if line.sheave.wrap == "over" else -1.0
        _put_ends(row, line)
    if guided is not None:
        own = guided[:, layout.SPANS] > 0.0
        lines[own, line_over_sheave.RADIUS] = guided[own, layout.RADIUS]
    return lines


def _dead_lengths(robot: Robot) -> Array:
    """Return the length (m,) of each line's cable before that which rigid lines count, m."""
    guided = guided_lines(robot)
    dead = np.array([0.0 if line.winch_exit is None else line.dead_span().length for line in robot.lines])
    if guided is not None:
        dead = np.where(guided[:, layout.SPANS] > 0.0, guided[:, layout.DEAD_SPAN], dead)
    return np.asarray(dead + [line.dead_length for line in robot.lines])


def _put_ends(row: Array, line: Line) -> None:
    """Write the compliances of mount and spring of a *line* to its numbers, *row*."""
    if isinstance(line.exit_compliance, float):
        row[line_over_sheave.COMPLIANCE] = line.exit_compliance / line_over_sheave.PER_NEWTON
    elif line.exit_compliance is not None:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = line.exit_compliance
        row[line_over_sheave.MOUNT : line_over_sheave.SPRING] = (
            np.array([xx, yy, zz, xy, xz, yz]) / line_over_sheave.PER_NEWTON
        )
    row[line_over_sheave.SPRING] = 0.0 if line.spring is None else line.cables / line.spring


def targets(robot: Robot, unknowns: Sequence[Unknown]) -> NDArray[np.int64]:
    """Return the index of the unknown at each number (m, COLUMNS) of the lines, -1 for none."""
    found = np.full((robot.m, line_over_sheave.COLUMNS), -1, dtype=np.int64)
    for at, unknown in enumerate(unknowns):
        if unknown.column >= 0:
            found[lines_of(robot, unknown), unknown.column] = at
    return found


def coordinates_of(robot: Robot, unknowns: Sequence[Unknown], kind: str = "exit_point") -> tuple[Indices, Indices]:
    """Return which unknowns are coordinates of points of a *kind*, and the index of each among all 3 m coordinates."""
    number, axes = [line.name for line in robot.lines].index, {f"{kind}.{name}": axis for axis, name in enumerate(AXES)}
    found = [(at, 3 * number(str(of.line)) + axes[of.kind]) for at, of in enumerate(unknowns) if of.kind in axes]
    which, coordinates = np.ascontiguousarray(np.array(found, dtype=np.intp).reshape(-1, 2).T)
    return which, coordinates


def of_unknown_exits(robot: Robot, unknowns: Sequence[Unknown]) -> Mask:
    """Return which lines (m,) have coordinates of their exit point among the *unknowns*."""
    return np.isin(np.arange(robot.m), coordinates_of(robot, unknowns)[1] // 3)


def by_exits(robot: Robot, unknowns: Sequence[Unknown], by: ArrayLike) -> Array:
    """Return the derivatives (a, k) by the unknowns, from derivatives *by* (a, 3 m) all exit point coordinates.

    Columns of other unknowns are 0.
    """
    which, coordinates = coordinates_of(robot, unknowns)
    every = np.asarray(by)
    rows = np.zeros((len(every), len(unknowns)))
    rows[:, which] = every[:, coordinates]
    return rows


def exit_rows(robot: Robot, unknowns: Sequence[Unknown]) -> tuple[Array, Indices]:
    """Return rows (a, k) that select exit point coordinates from the unknowns, and the line (a,) of each.

    Of a platform in a plane they are those along its axes: what is across hardly matters there.
    """
    ways = directions(robot.platform.plane, 3).T
    rows = by_exits(robot, unknowns, np.kron(np.eye(robot.m), ways))
    kept = np.flatnonzero(rows.any(axis=1))
    return rows[kept], kept // len(ways)


def free_directions(robot: Robot) -> Array:
    """Return a basis (n, p) of the directions in which a pose is free, its columns orthonormal."""
    return directions(robot.platform.plane, robot.n)


def is_in_file(robot: Robot, unknown: Unknown) -> bool:
    """Return whether the robot's file holds an unknown, or can: a build-up only where all its lines have one."""
    has_build_up = all(robot.lines[at].winch.build_up is not None for at in lines_of(robot, unknown))
    return unknown.entry.described and (unknown.name != "build_up" or has_build_up)


def with_values(robot: Robot, unknowns: Sequence[Unknown], values: Array, raised: bool = False) -> Robot:
    """Return the robot with the values (k,) of the unknowns.

    A modelled winch exit follows its exit point horizontally, and vertically too if *raised*. Raises `InputError` for
    values that no robot file can have.
    """
    changed = robot
    for unknown, value in zip(unknowns, values.tolist(), strict=True):
        if is_in_file(robot, unknown):
            changed = with_value(changed, unknown, round(value, _DIGITS))
    placed = [
        _winch_placed(old, line, raised and old.in_plane)  # else it is raised already
        for old, line in zip(robot.lines, changed.lines, strict=True)
    ]
    drums = [line.name if line.shared_winch is None else line.shared_winch.line for line in placed]
    tables = {line.name: line.model_dump() for line in placed}
    lines = [tables[line.name] | {"winch": tables[drum]["winch"]} for line, drum in zip(placed, drums, strict=True)]
    return validated(Robot, changed.model_dump() | {"lines": lines}, f"{robot.name}, as calibrated")


def with_offsets(robot: Robot, unknowns: Sequence[Unknown], values: Array, elastic: bool) -> Robot:
    """Return the robot with the offsets on shared drums by the home lengths among the *values* (k,) of the unknowns.

    Drums with a build-up keep theirs, which is 0. *elastic*: home lengths contain the cable before the exit point.
    """
    homes = {
        each.line: value for each, value in zip(unknowns, values.tolist(), strict=True) if each.name == "length_offset"
    }
    dead = np.zeros(robot.m) if elastic else _dead_lengths(robot)
    whole = {
        line.name: homes.get(line.name, np.nan) + own for line, own in zip(robot.lines, dead.tolist(), strict=True)
    }
    lines = []
    for line in robot.lines:
        shared = line.shared_winch
        offset = np.nan if shared is None else whole[line.name] - shared.sense * whole[shared.line]
        if shared is not None and line.winch.build_up is None and np.isfinite(offset):
            update = {"shared_winch": shared.model_copy(update={"offset": round(offset, _DIGITS)})}
            line = line.model_copy(update=update)
        lines.append(line)
    return robot.model_copy(update={"lines": tuple(lines)})


def _winch_placed(old: Line, line: Line, raised: bool) -> Line:
    """Return the line with its winch exit at its height, and rounded where it moved."""
    if old.winch_exit is None or line.winch_exit is None:
        return line
    x, y, z = line.winch_exit
    moved = x, y, z + raised * (line.exit_point[2] - old.exit_point[2])
    place = (was if now == was else round(now, _DIGITS) for was, now in zip(old.winch_exit, moved, strict=True))
    return line.model_copy(update={"winch_exit": tuple(place)})
