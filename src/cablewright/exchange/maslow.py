"""Anchors of a Maslow 4 from its ``maslow.yaml``: read. Lengths are mm, x to the right, y up the board, z out of it."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Final

from cablewright.csv_input import text_lines
from cablewright.errors import InputError
from cablewright.exchange.completion import chosen_cable, frame_of
from cablewright.exchange.millimetres import from_mm
from cablewright.exchange.translation import Feature, ImportedRobot, Notes
from cablewright.robot import Robot
from cablewright.validation import shown, validated

MAX_BYTES: Final = 1 << 20
CORNERS: Final = {"tl": "top left", "tr": "top right", "bl": "bottom left", "br": "bottom right"}
BELT: Final = "belt-at5-10mm"
SLED: Final = 10.0  # kg, assumed
TILT: Final = 15.0  # degrees from the vertical of a board that leans on a wall, assumed

CARRIED: Final = (
    Feature("Maslow_tlX, tlY, tlZ and so on for tr, bl, br", "lines.exit_point", "eyelets; z is out of the board"),
    Feature("Maslow_vertical", "platform.plane, lines.exit_point", "a board that leans 15 degrees, or one that lies"),
)

_ENTRY = re.compile(r"\s*(maslow_[a-z_]+)\s*:\s*([^#]*?)\s*(?:#.*)?", re.IGNORECASE | re.ASCII)


def read_maslow(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the planar robot of a Maslow's file of settings; *cable*: one of the table, default: a belt.

    Of the YAML only lines ``maslow_...: value`` are read, at any depth. Raises `InputError`.
    """
    values, places = _entries(path)
    lost, assumed = Notes(), Notes()
    anchors = {corner: _anchor(values, places, corner, path) for corner in CORNERS}
    vertical = _vertical(values, places, assumed)
    used = {f"maslow_{corner}{axis}" for corner in CORNERS for axis in "xyz"} | {"maslow_vertical"}
    for key in values:
        if key not in used:
            lost.add(f"{key}: a robot file has no such key")
    lean = math.radians(TILT) if vertical else math.radians(90.0)
    along, out = (0.0, math.sin(lean), math.cos(lean)), (0.0, -math.cos(lean), math.sin(lean))
    _require_unmirrored(anchors, path)
    exits = {corner: (x, *(_tidy(y * along[k] + z * out[k]) for k in (1, 2))) for corner, (x, y, z) in anchors.items()}
    feet = [(x, *(_tidy(y * along[k]) for k in (1, 2))) for x, y, _ in anchors.values()]  # in the plane of the board
    assumed.add(f"platform.mass: {SLED:g} kg, the sled with its router")
    if vertical:
        assumed.add(f"platform.plane: a board that leans by {TILT:g} degrees")
    assumed.add(f"cable: {BELT if cable is None else cable}")
    board = {"normal": tuple(map(_tidy, out)), "distance": 0.0, "one_sided": True}
    table = {
        "schema": 1,
        "name": path.stem[:100] or "maslow",
        "description": "A Maslow's sled on a board, on four belts",
        "scene": {"gravity": 9.81} | frame_of([*exits.values(), *feet], path, assumed, normal=None if vertical else 2),
        "platform": {"kind": "point", "mass": SLED, "plane": board},
        "lines": [_line(CORNERS[corner], at, chosen_cable(cable or BELT)) for corner, at in exits.items()],
    }
    assumed.add("tension_limits: 10 N to a fifth of the breaking load")
    robot = validated(Robot, table, path)
    return ImportedRobot(robot, "a Maslow's settings", lost.all, assumed.all)


def _line(name: str, at: tuple[float, ...], cable: dict[str, Any]) -> dict[str, Any]:
    limits = (10.0, 0.2 * cable["breaking_load"])
    return {"name": name, "exit_point": at, "sheave": {"kind": "eyelet"}, "cable": cable, "tension_limits": limits}


def _entries(path: Path) -> tuple[dict[str, str], dict[str, str]]:
    """Return values by key in small letters, and where each is. Raises `InputError` for a key that is there twice."""
    values: dict[str, str] = {}
    places: dict[str, str] = {}
    for number, text in text_lines(path, MAX_BYTES, "Maslow's file of settings"):
        match = _ENTRY.fullmatch(text)
        if match is None:
            continue
        key, place = match[1].lower(), f"{path}, line {number}"
        if key in values:
            raise InputError(f"{place}: {match[1]} is given twice, also in {places[key].rsplit(', ', 1)[1]}")
        values[key], places[key] = match[2], place
    return values, places


def _anchor(values: dict[str, str], places: dict[str, str], corner: str, path: Path) -> tuple[float, float, float]:
    """Return an anchor, m; mm in the file."""
    found = []
    for axis in "xyz":
        key = f"maslow_{corner}{axis}"
        if key not in values:
            if axis == "z" or corner == "bl":  # the origin by Maslow's convention; files without it are written so
                found.append(0.0)
                continue
            raise InputError(f"{path}: has no Maslow_{corner}{axis.upper()}, the {CORNERS[corner]} anchor's {axis}, mm")
        found.append(from_mm(values[key], f"{places[key]}: Maslow_{corner}{axis.upper()}"))
    x, y, z = found
    return x, y, z


def _vertical(values: dict[str, str], places: dict[str, str], assumed: Notes) -> bool:
    key = "maslow_vertical"
    if key not in values:
        assumed.add("Maslow_vertical: false, the board lies flat")
        return False
    if values[key].lower() not in ("true", "false"):
        raise InputError(f"{places[key]}: Maslow_vertical = {shown(values[key])}: must be true or false")
    return values[key].lower() == "true"


def _require_unmirrored(anchors: dict[str, tuple[float, float, float]], path: Path) -> None:
    """Raise `InputError` where top and bottom or left and right are exchanged: the axes would be left-handed."""
    if not (anchors["tr"][0] > anchors["tl"][0] and anchors["br"][0] > anchors["bl"][0]):
        raise InputError(f"{path}: the right anchors are not to the right of the left ones: axes of another handedness")
    if not (anchors["tl"][1] > anchors["bl"][1] and anchors["tr"][1] > anchors["br"][1]):
        raise InputError(f"{path}: the top anchors are not above the bottom ones: axes of another handedness")


def _tidy(value: float) -> float:
    """Return a number without the last digits that sines leave, so that a level board is level."""
    return round(value, 12) + 0.0
