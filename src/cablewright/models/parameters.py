"""Uncertain numbers in the arrays that kernels take: one row for each set of values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.robot import Robot
from cablewright.robot.parameters import AXES, Parameter

__all__ = ["lines_of", "varied"]

Array = NDArray[np.float64]


def varied(
    robot: Robot, packed: Packed, parameters: Sequence[Parameter], values: Array, lengths: Array
) -> tuple[Packed, Array]:
    """The rows of *packed* (S or 1 of them, of *robot*) and *lengths* (S, m), m, with *values* (S, k) in their place.

    Lengths are those commanded on entry and those paid out on return: length offsets, scales and temperature act on
    them. Where a fidelity leaves out what a parameter speaks of, a sheave or a cable's weight, it has no effect.
    """
    rows = len(values)
    lines = np.broadcast_to(packed.lines, (rows, *packed.lines.shape[1:])).copy()
    platform = np.broadcast_to(packed.platform, (rows, packed.platform.shape[1])).copy()
    paid_out = lengths.copy()
    added = np.zeros_like(lengths)
    for parameter, value in zip(parameters, values.T, strict=True):
        kind, axis = parameter.kind.partition(".")[::2]
        if kind in _OF_PLATFORM:
            _set_platform(platform, kind, axis, value, robot.scene.gravity)
            continue
        for i in lines_of(robot, parameter):
            if kind == "length_scale":
                paid_out[:, i] *= value
            elif kind == "length_offset":
                added[:, i] += value
            elif kind == "temperature":
                paid_out[:, i] *= 1.0 + _expansion(robot, i) * value
            else:
                _set_line(robot, i, lines[:, i], kind, axis, value)
    return Packed(packed.freedoms, lines, platform), paid_out + added


def lines_of(robot: Robot, parameter: Parameter) -> list[int]:
    """Indices of the lines that a parameter is of."""
    return [i for i, line in enumerate(robot.lines) if parameter.line in (None, line.name)]


def _expansion(robot: Robot, i: int) -> float:
    """Thermal expansion of line *i*'s cable, 1/K."""
    expansion = robot.lines[i].cable.thermal_expansion
    assert expansion is not None  # there is no such parameter of a robot that does not say it
    return expansion


_OF_PLATFORM = {
    "mass": layout.PLATFORM_WEIGHT,
    "centre_of_mass": layout.MASS_X,
    "force": layout.WRENCH,
    "moment": layout.WRENCH + 3,
}
_POINTS = {"exit_point": layout.EXIT_X, "platform_point": layout.POINT_X}


def _set_platform(platform: Array, kind: str, axis: str, value: Array, gravity: float) -> None:
    if kind == "mass":
        platform[:, layout.PLATFORM_WEIGHT] = value * gravity
    else:
        platform[:, _OF_PLATFORM[kind] + AXES.index(axis)] = value


def _set_line(robot: Robot, i: int, row: Array, kind: str, axis: str, value: Array) -> None:
    """Set a number of line *i*, (S, COLUMNS)."""
    if kind == "modulus":
        row[:, list(layout.COMPLIANCES)] /= value[:, None]
    elif kind == "linear_density":
        row[:, layout.WEIGHT] = np.where(row[:, layout.WEIGHT] > 0.0, value * robot.scene.gravity, 0.0)
    elif kind == "sheave_radius":
        _set_radius(row, value)
    else:
        column = _POINTS[kind] + AXES.index(axis)
        if kind == "platform_point":  # a retracted one stays so
            value = row[:, column] + (value - robot.lines[i].platform_point[AXES.index(axis)])
        if column == layout.EXIT_Z:  # the winch exit stays where it is in height
            row[:, layout.WINCH_Z] += row[:, column] - value
        row[:, column] = value


def _set_radius(row: Array, value: Array) -> None:
    """Set a sheave's radius, where the fidelity has a sheave; a swivel's centre lies one radius from its axis."""
    sheave = row[:, layout.RADIUS] > 0.0
    swivel = sheave & (row[:, layout.UNKNOWNS] < 6)
    row[:, layout.RADIUS] = np.where(sheave, value, 0.0)
    row[:, layout.LEVER] = np.where(swivel, value, row[:, layout.LEVER])
