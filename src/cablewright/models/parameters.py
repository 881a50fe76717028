"""Parameters of the registry as columns of arrays: of `Packed`, of paid-out lengths, of the linearisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels import layout
from cablewright.kernels.layout import EXIT, LENGTH, MODULUS, POINT, SHEAVE, WEIGHT_FACTOR, Packed
from cablewright.robot import Line, Robot
from cablewright.robot.parameter_values import AXES
from cablewright.robot.parameters import Parameter


@dataclass(frozen=True)
class OfLine:
    """How a parameter of a line acts on the line.

    ``linear``: column of the linearisation. ``per``: returns the derivative of the column's quantity by the parameter.
    ``become``: returns the new ``columns`` of `Packed.lines` (S, c) for values (S, 1). A parameter of lengths has a
    ``factor`` on the commanded lengths, or is ``added`` to them. Statics is nearly linear in the parameter, or in its
    inverse if ``by_inverse``.
    """

    linear: int
    columns: tuple[int, ...] = ()
    become: Callable[[Array, Array, Line], Array] = lambda _old, values, _line: values
    per: Callable[[Line, Array], Array] = lambda _line, lengths: np.ones_like(lengths)  # lengths (N,) paid out, m
    factor: Callable[[Line, Array], Array] = lambda _line, values: np.ones_like(values)
    added: bool = False
    by_inverse: bool = False


def _height(old: Array, heights: Array, _line: Line) -> Array:
    """Set the height of an exit point; the winch exit keeps its height."""
    return np.hstack([heights, old[:, 1:] + (old[:, :1] - heights)])


def _radius(old: Array, radii: Array, _line: Line) -> Array:
    """Set the radius where the fidelity has a sheave; the centre of a swivel is one radius from its axis."""
    sheave, swivel = old[:, :1] > 0.0, (old[:, 1:2] > 0.0) & (old[:, 2:] < 6.0)
    return np.hstack([np.where(sheave, radii, 0.0), np.where(swivel, radii, old[:, 1:2]), old[:, 2:]])


def _mount(old: Array, compliances: Array, _line: Line) -> Array:
    """Set the compliance of the exit's mount, the same in all directions, where the fidelity lets lines stretch."""
    return np.hstack([old[:, :1], np.where(old[:, :1] > 0.0, compliances, 0.0).repeat(3, axis=1)])


def _held(line: Line) -> float:
    """Return the mass (kg) of the line's counterweight."""
    assert line.counterweight is not None  # checked by `why_not`
    return line.counterweight


def _warmed(line: Line, lengths: Array) -> Array:
    """Return how much longer *lengths* (N,) paid out get per temperature, m/K: of no line with a counterweight."""
    return np.asarray(lengths * (0.0 if line.counterweight is not None else line.cable.thermal_expansion or 0.0))


def _point(axis: int) -> OfLine:
    """Return the parameter of a platform point along *axis*; a retraction is kept."""
    return OfLine(POINT + axis, (layout.POINT_X + axis,), lambda old, to, line: old + (to - line.platform_point[axis]))


OF_LINES: Final[Mapping[str, OfLine]] = {
    "modulus": OfLine(MODULUS, layout.COMPLIANCES, lambda old, factors, _: old / factors, by_inverse=True),
    "creep_compliance": OfLine(
        MODULUS,
        layout.COMPLIANCES,
        lambda old, crept, _: np.where(old > 0.0, old + crept, 0.0),
        per=lambda line, lengths: np.full_like(lengths, -line.cable.stiffness),
    ),
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
    "exit_compliance": OfLine(EXIT, (layout.FREE_COMPLIANCE, *range(layout.MOUNT, layout.MOUNT + 3)), _mount),
    "counterweight": OfLine(
        LENGTH,  # of such a line: by its relative mass
        (layout.COUNTERWEIGHT,),
        lambda old, masses, line: old * (masses / _held(line)),
        per=lambda line, lengths: np.full_like(lengths, 1.0 / _held(line)),
    ),
    "temperature": OfLine(
        LENGTH,
        per=_warmed,
        factor=lambda line, warmer: 1.0 + (line.cable.thermal_expansion or 0.0) * warmer,
    ),
}
"""Parameters of lines by their name in the registry."""

OF_PLATFORM: Final[Mapping[str, int]] = {
    "mass": layout.PLATFORM_WEIGHT,
    **{f"centre_of_mass.{name}": layout.MASS_X + axis for axis, name in enumerate(AXES)},
    **{f"force.{name}": layout.WRENCH + axis for axis, name in enumerate(AXES)},
    **{f"moment.{name}": layout.WRENCH + 3 + axis for axis, name in enumerate(AXES)},
}
"""Indices into `Packed.platform` by name in the registry; in the linearisation they are wrenches on the platform."""


def varied(
    robot: Robot, packed: Packed, parameters: Sequence[Parameter], values: Array, lengths: Array
) -> tuple[Packed, Array]:
    """Return *packed* (S rows or 1, of *robot*) and *lengths* (S, m), m, with *values* (S, k) of *parameters* applied.

    *lengths* are commanded; the returned ones are paid out, after length offsets, scales and temperature. A parameter
    of a sheave or of a cable's weight has no effect where the fidelity omits that.
    """
    rows = len(values)
    lines = np.broadcast_to(packed.lines, (rows, *packed.lines.shape[1:])).copy()
    platform = np.broadcast_to(packed.platform, (rows, packed.platform.shape[1])).copy()
    paid_out, added = lengths.copy(), np.zeros_like(lengths)
    pairs = zip(parameters, values.T, strict=True)
    for parameter, value in sorted(pairs, key=lambda pair: pair[0].kind == "creep_compliance"):  # after the moduli
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
    return packed._replace(lines=lines, platform=platform), paid_out + added


def lines_of(robot: Robot, parameter: Parameter) -> list[int]:
    """Return the indices of the lines that a parameter belongs to."""
    return [i for i, line in enumerate(robot.lines) if parameter.of_line(line.name) and parameter.entry.is_of(line)]
