"""The numbers of a robot that a calibration may look for, and where each stands among the numbers of a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError, UnknownName
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Eyelet, Robot
from cablewright.robot.parameters import AXES, Parameter

__all__ = ["DEFAULT", "NAMES", "Unknown", "numbers_of_lines", "targets", "unknowns_of", "with_values"]

Array = NDArray[np.float64]

NAMES: Final = {
    "exit_point": "m",
    "platform_point": "m",
    "sheave_radius": "m",
    "length_offset": "m",
    "length_scale": "1",
    "drum_radius": "m",
    "build_up": "1/m",
    "modulus": "1",
}
"""What may be unknown, and the unit of its sigma."""

DEFAULT: Final = ("exit_point", "length_offset")
"""What is unknown where nobody says: as in Wang and Caro 2021."""

_COLUMNS: Final = {
    "exit_point": calibration_residuals.EXIT,
    "platform_point": calibration_residuals.POINT,
    "sheave_radius": calibration_residuals.RADIUS,
    "length_offset": calibration_residuals.OFFSET,
    "length_scale": calibration_residuals.SCALE,
    "drum_radius": calibration_residuals.SCALE,
    "build_up": calibration_residuals.BUILD_UP,
}
_DIGITS: Final = 12  # after the point, m, of what is written to a robot file
_OF_HARDWARE: Final = ("exit_point", "platform_point", "sheave_radius", "modulus")
_POINTS: Final = ("exit_point", "platform_point")


@dataclass(frozen=True)
class Unknown:
    """One number that is looked for: of one line, or one that all lines have in common (line None).

    ``size`` is what one unit of the number that is solved for stands for: a drum's nominal radius, else 1.
    """

    name: str
    line: str | None
    axis: int | None = None
    size: float = 1.0

    @property
    def label(self) -> str:
        """What people read: "exit point x of south-west", "sheave radius of all lines"."""
        words = self.name.replace("_", " ") if self.name != "length_offset" else "home length"
        axis = "" if self.axis is None else f" {AXES[self.axis]}"
        return f"{words}{axis} of {'all lines' if self.line is None else self.line}"

    @property
    def nominal(self) -> float | None:
        """The value that stands for the robot as its file describes it; None where the file gives one."""
        return {"length_offset": 0.0, "length_scale": 1.0, "drum_radius": 1.0, "build_up": 0.0, "modulus": 1.0}.get(
            self.name
        )

    @property
    def parameter(self) -> Parameter | None:
        """The robot's parameter that it is; None where it speaks of the winch and not of the line."""
        if self.name not in _OF_HARDWARE:
            return None
        axis = "" if self.axis is None else f".{AXES[self.axis]}"
        return Parameter(f"{self.name}{axis}", self.line)

    @property
    def column(self) -> int:
        """Its column among the numbers of a line, or -1: stiff lines have no modulus."""
        return _COLUMNS[self.name] + (self.axis or 0) if self.name in _COLUMNS else -1

    @property
    def unit(self) -> str:
        """The SI unit."""
        return NAMES[self.name]


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
        _check_has(robot, name)
        sizes = [line.winch.drum_radius or 1.0 if name == "drum_radius" else 1.0 for line in robot.lines]
        if name in shared:
            _check_shared(robot, name)
            found.append(Unknown(name, None, None, sizes[0]))
            continue
        axes = range(3) if name in _POINTS else (None,)
        found += [
            Unknown(name, line.name, axis, size)
            for line, size in zip(robot.lines, sizes, strict=True)
            for axis in axes
            if not (name == "sheave_radius" and isinstance(line.sheave, Eyelet))
        ]
    for name in shared:
        if name not in names:
            raise InputError(f"shared: {name!r} is not among the unknowns")
    if "drum_radius" in names and "length_scale" in names:
        raise InputError("unknowns: drum_radius and length_scale are one number, said twice: leave out one")
    return tuple(found)


def _check_has(robot: Robot, name: str) -> None:
    if name == "platform_point" and robot.n == 3:
        raise InputError(f"unknowns: {robot.name!r} is a point platform: its lines have no platform points")
    if name == "sheave_radius" and all(isinstance(line.sheave, Eyelet) for line in robot.lines):
        raise InputError(f"unknowns: {robot.name!r} has no sheaves, and so no sheave_radius")
    if name == "drum_radius":
        for line in robot.lines:
            if line.winch.drum_radius is None:
                why = "the file gives no winch.drum_radius to start from: use length_scale"
                raise InputError(f"unknowns: drum_radius of line {line.name!r}: {why}")


def _check_shared(robot: Robot, name: str) -> None:
    if name in (*_POINTS, "length_offset"):
        raise InputError(f"shared: {name!r} cannot be one number for all lines")
    if name == "sheave_radius":
        radii = {None if isinstance(line.sheave, Eyelet) else line.sheave.radius for line in robot.lines}
        if len(radii) > 1:
            raise InputError("shared: the lines have different sheave radii")
    if name == "drum_radius" and len({line.winch.drum_radius for line in robot.lines}) > 1:
        raise InputError("shared: the lines have different drum radii")


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
    document: dict[str, Any] = robot.model_dump()
    lines = [dict(line) for line in document["lines"]]
    names = [line.name for line in robot.lines]
    for unknown, value in zip(unknowns, values.tolist(), strict=True):
        for i in range(robot.m) if unknown.line is None else [names.index(unknown.line)]:
            _put(lines[i], unknown, round(value, _DIGITS), 3 if raised else 2)
    return Robot.model_validate(document | {"lines": lines})


def _put(line: dict[str, Any], unknown: Unknown, value: float, axes: int) -> None:
    if unknown.name == "modulus":
        key = "axial_stiffness" if line["cable"].get("axial_stiffness") is not None else "young_modulus"
        line["cable"] = line["cable"] | {key: line["cable"][key] * value}
    elif unknown.name == "sheave_radius":
        if line["sheave"]["kind"] != "eyelet":
            line["sheave"] = line["sheave"] | {"radius": value}
    elif unknown.name == "drum_radius":
        line["winch"] = line["winch"] | {"drum_radius": value}
    elif unknown.axis is not None:
        point = list(line[unknown.name])
        change, point[unknown.axis] = value - point[unknown.axis], value
        line[unknown.name] = tuple(point)
        if unknown.name == "exit_point" and line.get("winch_exit") is not None and unknown.axis < axes:
            winch = list(line["winch_exit"])
            winch[unknown.axis] = round(winch[unknown.axis] + change, _DIGITS)
            line["winch_exit"] = tuple(winch)
