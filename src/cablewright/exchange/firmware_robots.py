"""Robots from firmware settings: a printing point on straight lines from anchors; other values are assumed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import Point, chosen_cable, frame_of
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import validated
from cablewright.robot import Robot

CABLE: Final = "spectra-1.1mm"
MASS: Final = 2.0  # kg, assumed

ORIGIN: Final = (0.0, 0.0, 0.0)

NEAR: Final = 0.005
"""Distance of an anchor from the origin over that of the farthest, below which it is in another unit."""


def anchored_robot(
    path: Path,
    lines: Mapping[str, Mapping[str, Any]],
    cable: str | None,
    assumed: Notes,
    mass: float | None = None,
    stiffness: float | None = None,
    below: float = 0.0,
) -> Robot:
    """Return a point platform on *lines* by name, from the anchors of a firmware, through eyelets.

    *cable*: a name in the table of cables; *stiffness*: stiffness of the file's cable, N, where none of the table is
    chosen; *below*: distance, m, of the nozzle below the point where lines meet. Firmware has the anchors as that point
    sees them with the nozzle at the origin. Values that the lines do not have are noted in *assumed*. Raises
    `InputError`.
    """
    table = chosen_cable(cable or CABLE)
    if cable is None and stiffness is not None:
        table |= {"axial_stiffness": stiffness}
        assumed.add(f"cable: {CABLE} but for axial_stiffness")
    else:
        assumed.add(f"cable: {cable or CABLE}")
    if below:
        assumed.add(f"platform: a point, whose nozzle is {1e3 * below:g} mm below where the lines meet")
    else:
        deep = -1e3 * min(line["exit_point"][2] for line in lines.values())
        likely = f"; anchors are up to {deep:.0f} mm below the bed, it is likely that much" if deep > 1.0 else ""
        point = "a point; the nozzle is where the lines meet, not below: --nozzle-below gives by how much"
        assumed.add(f"platform: {point}{likely}")
    if mass is None:
        assumed.add(f"platform.mass: {MASS:g} kg")
    limits = (0.01 * 9.81 * (mass or MASS), 0.2 * table["breaking_load"])
    if not all("tension_limits" in line for line in lines.values()):
        assumed.add("tension_limits: a hundredth of the weight to a fifth of the breaking load")
    _require_one_unit(path, {name: math.hypot(*line["exit_point"]) for name, line in lines.items()})
    if below:
        lines = {
            name: dict(line) | {"exit_point": _lifted(line["exit_point"], below), "platform_point": (0.0, 0.0, below)}
            for name, line in lines.items()
        }
    assumed.add("uncertainty.zeroed_at: lines are zeroed with the nozzle at the origin, from where firmware counts")
    exits: list[Point] = [line["exit_point"] for line in lines.values()]
    given = {
        "schema": 1,
        "name": path.stem[:100] or "imported",
        "scene": frame_of(exits, path, assumed),
        "platform": {"kind": "point", "mass": mass or MASS},
        "uncertainty": {"zeroed_at": ORIGIN},
        "lines": [
            {"name": name, "sheave": {"kind": "eyelet"}, "cable": table, "tension_limits": limits} | dict(line)
            for name, line in lines.items()
        ],
    }
    return validated(Robot, given, path)


def _lifted(at: Point, by: float) -> Point:
    return (at[0], at[1], at[2] + by)


def as_points(robot: Robot) -> Robot:
    """Return a robot reduced to its nozzle: each exit point is shifted by its platform point, from the nozzle.

    Of a platform that does not rotate each line is as long as to that point.
    """
    nozzle = robot.platform.nozzle
    lines = tuple(
        line.model_copy(
            update={
                "exit_point": tuple(
                    a - b + c for a, b, c in zip(line.exit_point, line.platform_point, nozzle, strict=True)
                ),
                "platform_point": (0.0, 0.0, 0.0),
            }
        )
        for line in robot.lines
    )
    return robot.model_copy(update={"lines": lines})


def _require_one_unit(path: Path, away: Mapping[str, float]) -> None:
    """Raise `InputError` where one anchor is so near the origin that it is in m and others in mm. *away*: m."""
    far = max(away.values(), default=0.0)
    for name, distance in away.items():
        if distance < far * NEAR:
            raise InputError(
                f"{path}: anchor {name} is {1e3 * distance:g} mm from the origin, where the nozzle is at first, and "
                f"another is {1e3 * far:g} mm: give all anchors in mm"
            )


def spool(radius: float, growth: float, length: float, cables: int = 1) -> dict[str, float]:
    """Return the winch of a line of this total *length* (m) with the nozzle at the origin.

    *radius*: m, of its drum there; *growth*: m, by which its square grows per length of wound cable.
    """
    if growth == 0.0 or radius <= 0.0:  # which the robot rejects
        return {"drum_radius": radius}
    return {"drum_radius": radius, "build_up": 0.5 * growth * cables / radius / radius, "drum_length": length}
