"""Ratio of each sheave's radius to that of its cable, compared with the recommended minimum."""

from __future__ import annotations

from dataclasses import dataclass

from cablewright.robot import Robot

SHEAVE_RATIO = 20.0  # smallest ratio of the radii of a sheave and its cable: Paty 2021, section 3.1.1


@dataclass(frozen=True)
class SheaveRule:
    """Check of a line: whether its sheave is large enough to spare the cable."""

    line: str
    value: float  # radius of the sheave over radius of the cable
    required: float
    holds: bool


def sheave_rules(robot: Robot) -> tuple[SheaveRule, ...]:
    """Return the ratio of each line's smallest sheave to its cable, which should exceed 20, where both are known."""
    found = []
    for line in robot.lines:
        if line.radii and line.cable.diameter is not None:
            ratio = 2.0 * min(line.radii) / line.cable.diameter
            found.append(SheaveRule(line.name, ratio, SHEAVE_RATIO, ratio > SHEAVE_RATIO))
    return tuple(found)
