"""Import and export of Klipper's configuration of cable winches (``kinematics: winch``). Lengths are mm.

Klipper has anchors, a line each from there to the one point that prints, straight and rigid, and a drum without layers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import Point
from cablewright.exchange.firmware_robots import anchored_robot, as_points, spool
from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.millimetres import from_mm, radius_of_turn, to_mm, turn_of_radius
from cablewright.exchange.translation_result import ExportedFile, ImportedRobot, Mapped, Notes
from cablewright.exchange.xml_input import finite, whole
from cablewright.foundation.arrays import Array
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.validation import shown
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot

MAX_BYTES: Final = 1 << 20
LETTERS: Final = "abcdefghijklmnopqrstuvwxyz"
FORCE: Final = 120.0  # N, of winch_max_force in the fork

CARRIED: Final = (
    Mapped("stepper_a to stepper_z: anchor_x, anchor_y, anchor_z", "lines.exit_point", "eyelets of a point platform"),
    Mapped("rotation_distance", "lines.winch.drum_radius", "over 2 pi, times the mechanical advantage"),
    Mapped("winch_mechanical_advantage", "lines.advantage", "this and the next in the fork for Hangprinters"),
    Mapped("winch_mover_weight", "platform.mass"),
    Mapped("winch_min_force, winch_max_force", "lines.tension_limits", "of all spans there, of one here"),
    Mapped("winch_spring_constant", "lines.cable.axial_stiffness"),
    Mapped("winch_buildup_factor", "lines.winch.build_up, drum_length"),
    Mapped("winch_guy_wire_lengths", "lines.dead_length"),
)

_LONGEST: Final = 2000  # characters of a value over several lines
_OPTION = re.compile(r"([A-Za-z0-9_]+)\s*[:=]")
_PRINTER = (
    "kinematics", "winch_mechanical_advantage", "winch_mover_weight", "winch_min_force", "winch_max_force",
    "winch_spring_constant", "winch_buildup_factor", "winch_guy_wire_lengths",
)  # fmt: skip
_WHY: Final = {
    "gear_ratio": "a machine file has it, as winch.ratio",
    "max_velocity": "a job has it, as motion.travel_speed",
    "max_accel": "a job has it, as motion.acceleration",
    "microsteps": "an export has it, as --microsteps",
    "full_steps_per_rotation": "an export has it, as --full-steps",
    "winch_target_force": "tensions are chosen by each study",
    "flex_compensation_algorithm": "tensions are chosen by each study",
}
_KEYS = ("anchor_x", "anchor_y", "anchor_z", "rotation_distance")


def read_klipper(path: Path, cable: str | None = None, below: float = 0.0) -> ImportedRobot:
    """Return the robot of a ``printer.cfg`` with cable winches; *below* as of `anchored_robot`. Raises `InputError`."""
    sections, places = _sections(path)
    lost, assumed = Notes(), Notes()
    kinematics = sections.get("printer", {}).get("kinematics")
    if kinematics != "winch":
        elsewhere = next((name for name in sections if name.startswith("include ")), None)
        beside = f", or in a file that [{elsewhere}] names: give that file" if kinematics is None and elsewhere else ""
        raise InputError(
            f"{path}: [printer] kinematics = {shown(kinematics)}: must be winch{beside}; others have no anchors"
        )
    exits: dict[str, Point] = {}
    radii: list[float] = []
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
        radii.append(radius_of_turn(given[_KEYS[3]], place))
        if radii[-1] <= 0.0:
            raise InputError(f"{place} = {given[_KEYS[3]]}: must be over 0 mm")
    _note_lost(path, sections, exits, lost)
    if len(exits) < 3:
        raise InputError(f"{path}: {len(exits)} winches, [stepper_a] and so on; Klipper needs at least 3")
    printer = _Printer(sections["printer"], places, len(exits))
    mass, stiffness = printer.number("winch_mover_weight"), printer.number("winch_spring_constant")
    is_fork = any(key.startswith("winch_") for key in sections["printer"])
    if is_fork and "winch_max_force" not in sections["printer"]:
        assumed.add(
            f"lines.tension_limits: up to {FORCE:g} N over the spans, what the fork takes without winch_max_force"
        )
    lines = _lines(printer, exits, radii, FORCE if is_fork else None, lost)
    robot = anchored_robot(path, lines, cable, assumed, mass, stiffness, below)
    version = "the fork for Hangprinters, by its winch_ keys" if is_fork else "kinematics: winch, since 2018"
    return ImportedRobot(robot, f"Klipper's cable winches ({version})", lost.all, assumed.all)


def _note_lost(path: Path, sections: Mapping[str, Mapping[str, str]], exits: Mapping[str, Point], lost: Notes) -> None:
    """Note each key that is not read. Raises `InputError` for a winch without those before it."""
    for section, options in sections.items():
        if section.startswith("include "):
            lost.add(f"[{section}]: other files are not read")
        letter = section.removeprefix("stepper_").upper()
        mine = section.startswith("stepper_") and letter in exits
        if section.startswith("stepper_") and not mine:
            raise InputError(f"{path}: [{section}] without the winches before it; they go from stepper_a on")
        for key in options:
            if not (mine and key in _KEYS) and not (section == "printer" and key in _PRINTER):
                why = _WHY.get(key, "a robot file has no such key")
                lost.add(f"{'stepper' if mine else section}.{key}: {why}")


@dataclass(frozen=True)
class _Printer:
    """The options of [printer], those of the fork for Hangprinters among them, for *count* winches."""

    options: Mapping[str, str]
    places: Mapping[Any, str]
    count: int

    def number(self, key: str) -> float | None:
        """Return a positive number of the file; None without the key, and for 0, which the fork takes as not known."""
        if key not in self.options:
            return None
        return finite(self.options[key], f"{self.places['printer', key]}: {key}", least=0.0) or None

    def values(self, key: str, read: Callable[[str, str], Any], default: Any) -> list[Any]:
        """Return the values of an option of [printer], one for each winch; the *default* where the option is absent."""
        if key not in self.options:
            return [default] * self.count
        parts, place = self.options[key].split(","), f"{self.places['printer', key]}: {key}"
        if len(parts) != self.count:
            raise InputError(f"{place} = {shown(self.options[key])}: must be {self.count} values, one for each winch")
        return [read(part, place) for part in parts]


def _lines(
    printer: _Printer, exits: Mapping[str, Point], radii: list[float], most: float | None, lost: Notes
) -> dict[str, dict[str, Any]]:
    spans = printer.values("winch_mechanical_advantage", whole, 1)
    dead = printer.values("winch_guy_wire_lengths", from_mm, 0.0)
    low, high = printer.values("winch_min_force", finite, 0.0), printer.values("winch_max_force", finite, most)
    growth = 1e-3 * (printer.number("winch_buildup_factor") or 0.0)
    lines: dict[str, dict[str, Any]] = {}
    for k, (name, at) in enumerate(exits.items()):
        length = spans[k] * math.dist((0.0, 0.0, 0.0), at) + dead[k]
        line = {"exit_point": at, "advantage": spans[k], "dead_length": dead[k]}
        line["winch"] = spool(spans[k] * radii[k], growth, length)
        if high[k] is not None:
            line["tension_limits"] = (low[k] / spans[k], high[k] / spans[k])
        lines[name] = line
    if high[0] is None and "winch_min_force" in printer.options:
        lost.add("printer.winch_min_force: without winch_max_force no limits are read")
    return lines


def klipper_anchors(robot: Robot) -> ExportedFile:
    """Return the sections of a ``printer.cfg`` that let Klipper compute the lengths. Raises `InputError`."""
    require(robot, Capability.KLIPPER_WINCH)
    carried = "lines.exit_point lines.winch.drum_radius lines.name lines.sheave.kind lines.platform_point"
    lost = tuple(lost_keys(keys_given(robot), carried))
    turns = [turn_of_radius(line.winch.drum_radius or math.nan) for line in robot.lines]
    return ExportedFile(_sections_of(as_points(robot), turns), lost)


def winch_sections(robot: Robot, turns: Array, ratio: float) -> str:
    """Return the sections of a ``printer.cfg`` for lines to one point, without a check of the robot.

    *turns* (m,): m of the nozzle's distance for a turn of each drum; *ratio*: turns of a motor for one of its drum.
    """
    gear = "" if ratio == 1.0 else f"gear_ratio: {ratio!r}:1\n"
    return _sections_of(robot, [to_mm(turn) for turn in turns.tolist()], gear)


def _sections_of(robot: Robot, turns: Sequence[str], more: str = "") -> str:
    text = "# Lines are straight and rigid, drums have one layer. Lengths are mm.\n"
    text += "\n[printer]\nkinematics: winch\n"
    for letter, line, turn in zip(LETTERS, robot.lines, turns, strict=False):
        x, y, z = map(to_mm, line.exit_point)
        text += f"\n# line {line.name!r}\n[stepper_{letter}]\nanchor_x: {x}\nanchor_y: {y}\nanchor_z: {z}\n"
        text += f"rotation_distance: {turn}\n{more}"
    return text


def _sections(path: Path) -> tuple[dict[str, dict[str, str]], dict[Any, str]]:
    """Return options by section, and the places of both. Raises `InputError` for one that is there twice.

    What SAVE_CONFIG wrote at the end, in comments, replaces what stands above it, as in Klipper.
    """
    sections: dict[str, dict[str, str]] = {}
    places: dict[Any, str] = {}
    section = key = ""
    written = ((*each, False) for each in text_lines(path, MAX_BYTES, "printer.cfg", indented=True))
    for number, text, saved in chain(written, _saved(path)):
        place = f"{path}, line {number}"
        bare = text.replace(";", "#").partition("#")[0].strip()
        if text[0] in " \t" and sections.get(section):  # of the option before, as in a macro
            if key in (*_PRINTER, *_KEYS) and len(sections[section][key]) < _LONGEST:
                sections[section][key] += f" {bare}"
            continue
        text = text.strip()
        name, closed, after = text[1:].partition("]")
        if text[0] == "[" and closed and name.strip() and after.lstrip()[:1] in ("", "#", ";"):
            section = name.strip()
            if section in sections and not saved:
                raise InputError(f"{place}: section [{section[:60]}] occurs twice; keep one of them")
            sections.setdefault(section, {})
        elif match := _OPTION.match(bare):
            if not section:
                raise InputError(f"{place}: the option {match[1][:60]} stands before the first [section]")
            key = match[1].lower()
            if key in sections[section] and not saved:
                raise InputError(f"{place}: [{section[:60]}] has the option {match[1][:60]} twice; keep one of them")
            sections[section][key] = bare[match.end() :].lstrip()
            places[section, key] = place
    return sections, places


def _saved(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Yield number and text of the lines that SAVE_CONFIG wrote."""
    for number, raw in enumerate(read_bytes(path, MAX_BYTES, "printer.cfg").splitlines(), 1):
        if raw.startswith(b"#*#") and (text := raw[3:].decode("utf-8", "replace").strip()):
            yield number, text, True
