"""Whether sheaves are large enough to spare their cables."""

from __future__ import annotations

from dataclasses import dataclass

from cablewright.robot import Robot

SHEAVE_RATIO = 20.0  # least radius of a sheave over that of its cable, Paty 2021, section 3.1.1


@dataclass(frozen=True)
class SheaveRule:
    """A rule of thumb that a line keeps or breaks wherever the platform is."""

    line: str
    value: float  # radius of the sheave over radius of the cable
    required: float
    holds: bool


def sheave_rules(robot: Robot) -> tuple[SheaveRule, ...]:
    """Ratio of each sheave's radius to its cable's, which should be over 20; lines without either are left out."""
    found = []
    for line in robot.lines:
        radius = getattr(line.sheave, "radius", None)
        if radius is not None and line.cable.diameter is not None:
            ratio = 2.0 * radius / line.cable.diameter
            found.append(SheaveRule(line.name, ratio, SHEAVE_RATIO, ratio > SHEAVE_RATIO))
    return tuple(found)
