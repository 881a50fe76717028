"""Symmetric design variables: a value set for one line is also set, mirrored, for its mirror images."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import Vec3
from cablewright.robot.design_variables import SAME, Change
from cablewright.robot.line import Line
from cablewright.robot.parameter_values import AXES
from cablewright.robot.robot import Robot

PLANES: Final = ("x", "y")
"""Names of mirrors: vertical planes through the middle of the frame, across that axis."""


@dataclass(frozen=True)
class SymmetricChange:
    """A design variable that lines share with their mirror images.

    A variable of the platform, or of all lines equally, is applied as it is.

    ``mirrors``: which of `PLANES`. Coordinates across a mirror are mirrored, all other numbers the same. Raises
    `UnknownName` for another mirror.
    """

    change: Change
    mirrors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for mirror in self.mirrors:
            if mirror not in PLANES:
                raise UnknownName("mirror", mirror, PLANES)

    @property
    def name(self) -> str:
        """Name of the design variable, applied to both sides of a plane."""
        return self.change.name

    @property
    def unit(self) -> str:
        """SI unit of the design variable."""
        return self.change.unit

    def on(self, robot: Robot, value: float) -> Robot:
        """Return the robot with the variable at ``value`` (SI), and its images mirrored.

        Raises `InputError` if the robot cannot have it, or a line has no mirror image.
        """
        for single, own in self._images(robot, value):
            robot = single.on(robot, own)
        return robot

    def _images(self, robot: Robot, value: float) -> Iterator[tuple[Change, float]]:
        for kind, line in self.change.parts:
            if line is None:
                yield Change(kind), value
                continue
            done = set[str]()
            for count in range(len(self.mirrors) + 1):
                for across in combinations(self.mirrors, count):
                    image = _image(robot, line, across)
                    if image not in done:
                        done.add(image)
                        yield Change(f"{kind}@{image}"), _mirrored(robot, kind, value, across)


def _image(robot: Robot, name: str, across: Sequence[str]) -> str:
    """Return the name of the line that is the mirror image of another. Raises `InputError` where there is none."""
    lines = {line.name: line for line in robot.lines}
    if name not in lines:
        raise UnknownName("line", name, lines)
    exit_point, platform_point = _ends(robot, lines[name], across)
    for other in robot.lines:
        near = SAME * math.dist(robot.scene.frame_min, robot.scene.frame_max)
        if math.dist(other.exit_point, exit_point) <= near and math.dist(other.platform_point, platform_point) <= near:
            return other.name
    raise InputError(f"symmetry {','.join(across)}: line {name!r} of {robot.name!r} has no mirror image")


def _ends(robot: Robot, line: Line, across: Sequence[str]) -> tuple[Vec3, Vec3]:
    """Return the ends of a line, mirrored."""
    ends = []
    for kind, point in (("exit_point", line.exit_point), ("platform_point", line.platform_point)):
        x, y, z = (_mirrored(robot, f"{kind}.{axis}", value, across) for axis, value in zip(AXES, point, strict=True))
        ends.append((x, y, z))
    return ends[0], ends[1]


def _mirrored(robot: Robot, kind: str, value: float, across: Sequence[str]) -> float:
    """Return a value as the mirror image has it."""
    base, _, axis = kind.partition(".")
    if axis not in across:
        return value
    if base == "exit_point":
        k = AXES.index(axis)
        return robot.scene.frame_min[k] + robot.scene.frame_max[k] - value
    return -value if base == "platform_point" else value
