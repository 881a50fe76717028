"""Configuration of Klipper's cable winches (``kinematics: winch``): read, and written. Lengths are mm.

Klipper has anchors, a line each from there to the one point that prints, straight and rigid, and a drum without layers.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

from cablewright.csv_input import text_lines
from cablewright.errors import InputError
from cablewright.exchange.anchors import anchored_robot, require_anchors
from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.millimetres import from_mm, radius_of_turn, to_mm, turn_of_radius
from cablewright.exchange.translation import ExportedFile, Feature, ImportedRobot, Notes
from cablewright.robot import Robot
from cablewright.validation import shown

MAX_BYTES: Final = 1 << 20
LETTERS: Final = "abcdefghijklmnopqrstuvwxyz"

CARRIED: Final = (
    Feature("stepper_a to stepper_z: anchor_x, anchor_y, anchor_z", "lines.exit_point", "eyelets of a point platform"),
    Feature("rotation_distance", "lines.winch.drum_radius", "over 2 pi; gear_ratio is of the motor, and lost"),
)

_SECTION = re.compile(r"\[\s*([^\]]+?)\s*\]\s*(?:[#;].*)?")
_OPTION = re.compile(r"([A-Za-z0-9_]+)\s*[:=]\s*([^#;]*?)\s*(?:[#;].*)?")
_KEYS = ("anchor_x", "anchor_y", "anchor_z", "rotation_distance")


def read_klipper(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a ``printer.cfg`` with cable winches. Raises `InputError`."""
    sections, places = _sections(path)
    lost, assumed = Notes(), Notes()
    kinematics = sections.get("printer", {}).get("kinematics")
    if kinematics != "winch":
        raise InputError(f"{path}: [printer] kinematics = {shown(kinematics)}: must be winch; others have no anchors")
    exits, radii = {}, {}
    for letter in LETTERS:
        name = f"stepper_{letter}"
        if name not in sections:
            break
        given = sections[name]
        for key in _KEYS:
            if key not in given:
                raise InputError(f"{path}: [{name}] has no {key}, mm")
        exits[letter.upper()] = tuple(from_mm(given[key], f"{places[name, key]}: {name}.{key}") for key in _KEYS[:3])
        place = f"{places[name, _KEYS[3]]}: {name}.{_KEYS[3]}"
        radii[letter.upper()] = radius_of_turn(given[_KEYS[3]], place)
        if radii[letter.upper()] <= 0.0:
            raise InputError(f"{place} = {given[_KEYS[3]]}: must be over 0 mm")
    for section, options in sections.items():
        letter = section.removeprefix("stepper_").upper()
        mine = section.startswith("stepper_") and letter in exits
        if section.startswith("stepper_") and not mine:
            raise InputError(f"{path}: [{section}] without the winches before it; they go from stepper_a on")
        for key in options:
            if not (mine and key in _KEYS) and (section, key) != ("printer", "kinematics"):
                lost.add(f"{'stepper' if mine else section}.{key}: a robot file has no such key")
    if len(exits) < 3:
        raise InputError(f"{path}: {len(exits)} winches, [stepper_a] and so on; Klipper needs at least 3")
    lines = {name: {"exit_point": at, "winch": {"drum_radius": radii[name]}} for name, at in exits.items()}
    robot = anchored_robot(path, lines, cable, assumed)
    return ImportedRobot(robot, "Klipper's cable winches", lost.all, assumed.all)


def klipper_anchors(robot: Robot) -> ExportedFile:
    """Return the sections of a ``printer.cfg`` that let Klipper compute the lengths. Raises `InputError`."""
    require_anchors(robot, "Klipper's winch kinematics", len(LETTERS))
    if any(line.advantage > 1 for line in robot.lines):
        raise InputError(f"robot {robot.name!r} has an advantage over 1, which Klipper's winch kinematics lacks")
    carried = "lines.exit_point lines.winch.drum_radius lines.name lines.sheave.kind"
    lost = tuple(lost_keys(keys_given(robot), carried))
    text = "# Lines are straight and rigid, drums have one layer. Lengths are mm.\n"
    text += "\n[printer]\nkinematics: winch\n"
    for letter, line in zip(LETTERS, robot.lines, strict=False):
        x, y, z = map(to_mm, line.exit_point)
        radius = line.winch.drum_radius
        if radius is None:
            raise InputError(f"line {line.name!r} gives no winch.drum_radius, which rotation_distance needs")
        text += f"\n# line {line.name!r}\n[stepper_{letter}]\nanchor_x: {x}\nanchor_y: {y}\nanchor_z: {z}\n"
        text += f"rotation_distance: {turn_of_radius(radius)}\n"
    return ExportedFile(text, lost)


def _sections(path: Path) -> tuple[dict[str, dict[str, str]], dict[Any, str]]:
    """Return options by section, and the places of both. Raises `InputError` for one that is there twice."""
    sections: dict[str, dict[str, str]] = {}
    places: dict[Any, str] = {}
    section = ""
    for number, text in text_lines(path, MAX_BYTES, "printer.cfg"):
        place = f"{path}, line {number}"
        if text.startswith(";"):
            continue
        if match := _SECTION.fullmatch(text):
            section = match[1]
            if section in sections:
                raise InputError(f"{place}: section [{section[:60]}] is there twice")
            sections[section] = {}
        elif match := _OPTION.fullmatch(text):
            if not section:
                raise InputError(f"{place}: {match[1][:60]} before any [section]")
            if match[1] in sections[section]:
                raise InputError(f"{place}: [{section[:60]}] has {match[1][:60]} twice")
            sections[section][match[1]] = match[2]
            places[section, match[1]] = place
    return sections, places
