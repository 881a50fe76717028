"""A platform on two belts in the plane of a wall or board, from the settings of a firmware: x right, y up, m."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import BOX, chosen_cable, frame_of
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import validated
from cablewright.robot import Robot

BELT: Final = "belt-at5-10mm"
PEN: Final = 0.3  # kg, assumed
ORIGIN: Final = (0.0, 0.0, 0.0)
_SIDES: Final = ("left", "right")

Place = tuple[float, float]


@dataclass(frozen=True)
class Wall:
    """A platform that hangs on two belts from two exit points.

    ``left``, ``right``: m, where the belts leave; ``low``: m, the lowest y of the platform; None: unknown. ``lean``:
    rad, of the wall from the vertical. ``mass``: kg, ``cable``: its table; None: assumed. ``winches``: table of the
    left and the right winch. ``is_zeroed``: whether belts are zeroed with the platform at the origin.
    """

    left: Place
    right: Place
    low: float | None = None
    lean: float = 0.0
    mass: float | None = None
    cable: Mapping[str, Any] | None = None
    winches: tuple[Mapping[str, float], Mapping[str, float]] = field(default=({}, {}))
    is_zeroed: bool = False


def wall_robot(path: Path, wall: Wall, title: str, cable: str | None, assumed: Notes) -> Robot:
    """Return the robot of a *wall*, a point on two belts; *cable*: one of the table instead of the file's.

    Raises `InputError` for exit points that are exchanged, or one below what hangs on it.
    """
    (x0, y0), (x1, y1) = wall.left, wall.right
    if not x1 > x0:
        raise InputError(f"{path}: the right exit point is not to the right of the left one: x {x0:g} and {x1:g} m")
    low = wall.low
    if low is None:
        low = min(y0, y1) - (x1 - x0)
        assumed.add(f"lowest place of the platform: y = {low:g} m, as far below the exit points as they are apart")
    if not low < min(y0, y1):
        raise InputError(f"{path}: the lowest place of the platform, y = {low:g} m, is not below its exit points")
    table = chosen_cable(cable or BELT) if wall.cable is None or cable is not None else dict(wall.cable)
    if wall.cable is None or cable is not None:
        assumed.add(f"cable: {cable or BELT}")
    mass = wall.mass or PEN
    if wall.mass is None:
        assumed.add(f"platform.mass: {PEN:g} kg")
    assumed.add("platform: a point; the belts meet in it")
    up, out = (0.0, math.sin(wall.lean), math.cos(wall.lean)), (0.0, -math.cos(wall.lean), math.sin(wall.lean))
    exits = [_on_wall(place, up) for place in (wall.left, wall.right)]
    corners = [_on_wall(place, up) for place in ((x0, low), (x1, low))]
    box = frame_of([*exits, *corners], path, assumed, normal=None if wall.lean else 1)
    assumed.drop(BOX)
    if not wall.lean:
        assumed.add("platform.plane: a vertical wall, in which its guides hold the platform")
    limits = (0.01 * 9.81 * mass, 0.2 * table["breaking_load"])
    assumed.add("tension_limits: a hundredth of the weight to a fifth of the breaking load")
    given = {
        "schema": 1,
        "name": path.stem[:100] or "imported",
        "description": title,
        "scene": box,
        "platform": {
            "kind": "point",
            "mass": mass,
            "plane": {"normal": out, "distance": 0.0, "one_sided": bool(wall.lean), "gcode_zero": ORIGIN},
        },
        "lines": [
            {"name": side, "exit_point": at, "sheave": {"kind": "eyelet"}, "cable": table, "tension_limits": limits}
            | ({"winch": dict(winch)} if winch else {})
            for side, at, winch in zip(_SIDES, exits, wall.winches, strict=True)
        ],
    }
    if wall.is_zeroed:
        assumed.add("uncertainty.zeroed_at: belts are zeroed with the pen at the origin")
        given["uncertainty"] = {"zeroed_at": ORIGIN}
    return validated(Robot, given, path)


def _on_wall(place: Place, up: tuple[float, float, float]) -> tuple[float, ...]:
    x, y = place
    return (x, round(y * up[1], 12) + 0.0, round(y * up[2], 12) + 0.0)
