"""What the registry's numbers are in arrays: columns of `Packed`, lengths paid out, columns of the linearisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics.linearise import EXIT, LENGTH, MODULUS, POINT, SHEAVE, WEIGHT_FACTOR
from cablewright.robot import Line, Robot
from cablewright.robot.parameter_values import AXES
from cablewright.robot.parameters import Parameter


@dataclass(frozen=True)
class OfLine:
    """A number of a line: ``linear`` is its parameter of the linearisation, one of it is ``per`` of that parameter.

    In ``columns`` of `Packed.lines` (S, c) its values (S, 1) ``become`` what is to stand there. One that acts on
    lengths gives the ``factor`` on the commanded ones, or is ``added`` to them. Statics is nearly linear in the number,
    or ``by_inverse`` in 1 over it.
    """

    linear: int
    columns: tuple[int, ...] = ()
    become: Callable[[Array, Array, Line], Array] = lambda _old, values, _line: values
    per: Callable[[Line, Array], Array] = lambda _line, lengths: np.ones_like(lengths)  # lengths (N,) paid out, m
    factor: Callable[[Line, Array], Array] = lambda _line, values: np.ones_like(values)
    added: bool = False
    by_inverse: bool = False


def _height(old: Array, heights: Array, _line: Line) -> Array:
    """Of an exit point; the winch exit stays where it is in height, and follows sideways."""
    return np.hstack([heights, old[:, 1:] + (old[:, :1] - heights)])


def _radius(old: Array, radii: Array, _line: Line) -> Array:
    """Where the fidelity has a sheave; a swivel's centre lies one radius from its axis."""
    sheave, swivel = old[:, :1] > 0.0, old[:, 2:] < 6.0
    return np.hstack([np.where(sheave, radii, 0.0), np.where(sheave & swivel, radii, old[:, 1:2]), old[:, 2:]])


def _point(axis: int) -> OfLine:
    """Of the platform; a retracted one stays so."""
    return OfLine(POINT + axis, (layout.POINT_X + axis,), lambda old, to, line: old + (to - line.platform_point[axis]))


OF_LINES: Final[Mapping[str, OfLine]] = {
    "modulus": OfLine(MODULUS, layout.COMPLIANCES, lambda old, factors, _: old / factors, by_inverse=True),
    "exit_point.x": OfLine(EXIT, (layout.EXIT_X,)),
    "exit_point.y": OfLine(EXIT + 1, (layout.EXIT_Y,)),
    "exit_point.z": OfLine(EXIT + 2, (layout.EXIT_Z, layout.WINCH_Z), _height),
    **{f"platform_point.{name}": _point(axis) for axis, name in enumerate(AXES)},
    "sheave_radius": OfLine(SHEAVE, (layout.RADIUS, layout.LEVER, layout.UNKNOWNS), _radius),
    "linear_density": OfLine(
        WEIGHT_FACTOR,
        (layout.WEIGHT,),
        lambda old, densities, line: old * (densities / line.cable.linear_density),
        per=lambda line, lengths: np.ones_like(lengths) / line.cable.linear_density,
    ),
    "length_offset": OfLine(LENGTH, added=True),
    "length_scale": OfLine(LENGTH, per=lambda _, lengths: lengths, factor=lambda _, scales: scales),
    "temperature": OfLine(
        LENGTH,
        per=lambda line, lengths: lengths * (line.cable.thermal_expansion or 0.0),
        factor=lambda line, warmer: 1.0 + (line.cable.thermal_expansion or 0.0) * warmer,
    ),
}
"""Numbers of lines by their name in the registry."""

OF_PLATFORM: Final[Mapping[str, int]] = {
    "mass": layout.PLATFORM_WEIGHT,
    **{f"centre_of_mass.{name}": layout.MASS_X + axis for axis, name in enumerate(AXES)},
    **{f"force.{name}": layout.WRENCH + axis for axis, name in enumerate(AXES)},
    **{f"moment.{name}": layout.WRENCH + 3 + axis for axis, name in enumerate(AXES)},
}
"""Entries of `Packed.platform` by name in the registry. In the linearisation they are wrenches on the platform."""


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
    paid_out, added = lengths.copy(), np.zeros_like(lengths)
    for parameter, value in zip(parameters, values.T, strict=True):
        if parameter.kind in OF_PLATFORM:
            size = robot.scene.gravity if parameter.kind == "mass" else 1.0
            platform[:, OF_PLATFORM[parameter.kind]] = value * size
            continue
        number = OF_LINES[parameter.kind]
        for i in lines_of(robot, parameter):
            line, columns = robot.lines[i], list(number.columns)
            lines[:, i, columns] = number.become(lines[:, i, columns], value[:, None], line)
            paid_out[:, i] *= number.factor(line, value)
            added[:, i] += value * number.added
    return Packed(packed.freedoms, lines, platform), paid_out + added


def lines_of(robot: Robot, parameter: Parameter) -> list[int]:
    """Indices of the lines that a parameter is of."""
    return [i for i, line in enumerate(robot.lines) if parameter.line in (None, line.name)]
