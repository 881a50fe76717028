"""The numbers of a robot that a calibration may look for, and where each stands among the numbers of a line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import InputError, UnknownName
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Eyelet, Line, Robot
from cablewright.robot.parameters import KINDS_OF, Parameter, nominal, parameters_of, why_not, with_value

_COLUMNS: Final = {
    "exit_point": calibration_residuals.EXIT,
    "platform_point": calibration_residuals.POINT,
    "sheave_radius": calibration_residuals.RADIUS,
    "length_offset": calibration_residuals.OFFSET,
    "length_scale": calibration_residuals.SCALE,
    "drum_radius": calibration_residuals.SCALE,
    "build_up": calibration_residuals.BUILD_UP,
    "modulus": -1,  # stiff lines have none
}
NAMES: Final = tuple(_COLUMNS)
"""What may be unknown, as the registry names it."""

DEFAULT: Final = ("exit_point", "length_offset")
"""What is unknown where nobody says: as in Wang and Caro 2021."""

_DIGITS: Final = 12  # after the point, m, of what is written to a robot file


@dataclass(frozen=True)
class Unknown(Parameter):
    """One parameter that is looked for.

    ``size`` is what one unit of the number that is solved for stands for: a drum's nominal radius, else 1.
    """

    size: float = 1.0

    @property
    def name(self) -> str:
        """The name without an axis: exit_point."""
        return self.entry.base

    @property
    def axis(self) -> int | None:
        """0 to 2 of a coordinate."""
        return self.entry.axis

    @property
    def label(self) -> str:
        """What people read: "exit point x of south-west", "sheave radius of all lines"."""
        return super().label.replace("length offset", "home length")

    @property
    def of_equilibrium(self) -> bool:
        """Whether equilibria depend on it: it speaks of the line, and not of the winch."""
        return self.entry.role == "hardware"

    @property
    def column(self) -> int:
        """Its column among the numbers of a line, or -1."""
        return _COLUMNS[self.name] + (self.axis or 0)


def unknowns_of(
    robot: Robot, names: Sequence[str] = DEFAULT, shared: Sequence[str] = (), elastic: bool = False
) -> tuple[Unknown, ...]:
    """The unknowns of those ``names``, line by line; of ``shared`` names one for all lines.

    Raises `InputError` for an unknown name, one given twice, and what this robot does not have.
    """
    found: list[Unknown] = []
    for index, name in enumerate(names):
        if name not in NAMES:
            raise UnknownName("unknown", name, NAMES)
        if name == "modulus" and not elastic:
            raise InputError("unknowns: modulus: rigid lines do not stretch; take elastic or catenary ones")
        if name in names[:index]:
            raise InputError(f"unknowns: {name!r} is given more than once")
        found += _unknowns(robot, name, name in shared)
    for name in shared:
        if name not in names:
            raise InputError(f"shared: {name!r} is not among the unknowns")
    if "drum_radius" in names and "length_scale" in names:
        raise InputError("unknowns: drum_radius and length_scale are one number, said twice: leave out one")
    return tuple(found)


def _unknowns(robot: Robot, name: str, shared: bool) -> Iterator[Unknown]:
    """Yield those of one *name*, line by line. Raises `InputError` for what this robot does not have."""
    kinds, lines = KINDS_OF[name], None
    if shared and (name == "length_offset" or not kinds[0].shareable):
        raise InputError(f"shared: {name!r} cannot be one number for all lines")
    if name == "sheave_radius" and not shared:  # lines with an eyelet have none
        lines = [line.name for line in robot.lines if kinds[0].value(line) is not None] or None
    fault = why_not(robot, kinds[0], lines, shared)
    if fault is not None:
        raise InputError(f"{'shared' if fault[0] == 'shared' else 'unknowns'}: {name}: {fault[1]}")
    found = [parameters_of(robot, kind.name, lines, shared) for kind in kinds]
    for of_line in zip(*found, strict=True):
        for parameter in of_line:
            size = nominal(robot, parameter) if name == "drum_radius" else 1.0
            yield Unknown(parameter.kind, parameter.line, size)


def numbers_of_lines(robot: Robot) -> Array:
    """The numbers (m, COLUMNS) of a robot's lines as `kernels.sensors` takes them; offsets are 0, scales 1.

    Sheaves on a universal joint are taken as if they swivelled: a rigid line says nothing of a lever's balance.
    """
    lines = np.zeros((robot.m, calibration_residuals.COLUMNS))
    for row, line in zip(lines, robot.lines, strict=True):
        row[calibration_residuals.EXIT : calibration_residuals.EXIT + 3] = line.exit_point
        row[calibration_residuals.POINT : calibration_residuals.POINT + 3] = line.platform_point
        row[calibration_residuals.SCALE] = 1.0
        if not isinstance(line.sheave, Eyelet):
            row[calibration_residuals.RADIUS] = line.sheave.radius
            row[calibration_residuals.SIDE] = 1.0 if line.sheave.wrap == "over" else -1.0
    return lines


def targets(robot: Robot, unknowns: Sequence[Unknown]) -> NDArray[np.int64]:
    """Which unknown stands at each number (m, COLUMNS) of the lines, -1 for none."""
    found = np.full((robot.m, calibration_residuals.COLUMNS), -1, dtype=np.int64)
    for at, unknown in enumerate(unknowns):
        for i, line in enumerate(robot.lines):
            if unknown.line in (None, line.name) and unknown.column >= 0:
                found[i, unknown.column] = at
    return found


def with_values(robot: Robot, unknowns: Sequence[Unknown], values: Array, raised: bool = False) -> Robot:
    """The robot with the values in their places.

    A modelled winch exit follows its exit point sideways, and in height too where both are *raised*.
    """
    changed = robot
    for unknown, value in zip(unknowns, values.tolist(), strict=True):
        if unknown.entry.described:
            changed = with_value(changed, unknown, round(value, _DIGITS))
    lines = [_winch_placed(*pair, raised) for pair in zip(robot.lines, changed.lines, strict=True)]
    return Robot.model_validate(changed.model_dump() | {"lines": [line.model_dump() for line in lines]})


def _winch_placed(was: Line, line: Line, raised: bool) -> Line:
    """The line with its winch exit in height, and rounded where it moved."""
    if was.winch_exit is None or line.winch_exit is None:
        return line
    x, y, z = line.winch_exit
    moved = x, y, z + raised * (line.exit_point[2] - was.exit_point[2])
    place = (old if new == old else round(new, _DIGITS) for old, new in zip(was.winch_exit, moved, strict=True))
    return line.model_copy(update={"winch_exit": tuple(place)})
