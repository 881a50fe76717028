"""Import of a FluidNC wall plotter (``kinematics: WallPlotter``). Lengths are mm, x to the right, y up the wall."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from cablewright.exchange.maslow import YamlEntry, described, yaml_entries
from cablewright.exchange.millimetres import from_mm
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.walls.two_belts import Wall, wall_robot
from cablewright.exchange.xml_input import finite
from cablewright.foundation.errors import InputError

CARRIED: Final = (
    Mapped("left_anchor_x, left_anchor_y, right_anchor_x, right_anchor_y", "lines.exit_point", "eyelets"),
    Mapped("axes.x to axes.c: max_rate_mm_per_min", "lines.winch.max_speed", "of left_axis and right_axis"),
)

_SECTION = "kinematics.wallplotter."
_AXES = "xyzabc"
_WHY: Final = {
    "segment_length": "the firmware cuts its path by it; an export has points of its own",
    "left_axis": "which motor is that of a belt",
    "right_axis": "which motor is that of a belt",
}


def read_wall_plotter(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a FluidNC configuration with ``kinematics: WallPlotter``. Raises `InputError`."""
    entries = yaml_entries(path)
    if not any(key.startswith(_SECTION[:-1]) for key in entries):
        raise InputError(f"{path}: {described(entries)}; a wall plotter's has kinematics: WallPlotter:")
    lost, assumed = Notes(), Notes()
    left, right = (
        (_number(path, entries, f"{side}_anchor_x"), _number(path, entries, f"{side}_anchor_y"))
        for side in ("left", "right")
    )
    winches = (_winch(entries, "left_axis", 0), _winch(entries, "right_axis", 1))
    for key, entry in entries.items():
        if key.startswith(_SECTION) and "anchor" not in key:
            lost.add(f"{entry.name}: {_WHY.get(entry.name.lower(), 'a robot file has no such key')}")
        elif key.endswith(".steps_per_mm"):
            lost.add("axes: steps_per_mm and drivers: an export has --microsteps, --full-steps and --gear")
    assumed.add("origin: where the firmware starts, X0 Y0")
    wall = Wall(left, right, winches=winches, is_zeroed=True)
    robot = wall_robot(path, wall, "A wall plotter on two belts", cable, assumed)
    return ImportedRobot(robot, "FluidNC's WallPlotter", lost.all, assumed.all)


def _number(path: Path, entries: Mapping[str, YamlEntry], name: str) -> float:
    entry = entries.get(_SECTION + name)
    if entry is None:
        raise InputError(f"{path}: kinematics: WallPlotter: has no {name}, mm")
    return from_mm(entry.value, f"{entry.place}: {name}")


def _winch(entries: Mapping[str, YamlEntry], key: str, axis: int) -> dict[str, float]:
    """Return the winch of a belt: its greatest speed, of the *axis* that moves it unless *key* names another."""
    entry = entries.get(_SECTION + key)
    if entry is not None:
        number = finite(entry.value, f"{entry.place}: {key}", least=0.0)
        if number not in range(len(_AXES)):
            raise InputError(f"{entry.place}: {key} = {entry.value}: must be 0 to {len(_AXES) - 1}, for x to c")
        axis = int(number)
    rate = entries.get(f"axes.{_AXES[axis]}.max_rate_mm_per_min")
    if rate is None:
        return {}
    return {"max_speed": 1e-3 / 60.0 * finite(rate.value, f"{rate.place}: {rate.name}", least=1e-3)}
