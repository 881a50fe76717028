"""Import of a Maslow 4's anchors from its ``maslow.yaml``. Lengths are mm, x right, y up the board, z out of it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import chosen_cable, frame_of
from cablewright.exchange.millimetres import from_mm
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.xml_input import finite
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import shown, validated
from cablewright.robot import Robot

MAX_BYTES: Final = 1 << 20
MAX_DEPTH: Final = 32
CORNERS: Final = {"tl": "top left", "tr": "top right", "bl": "bottom left", "br": "bottom right"}
BELT: Final = "belt-at5-10mm"
SLED: Final = 10.0  # kg, assumed
TILT: Final = 15.0  # degrees from the vertical of a board that leans on a wall, assumed

CARRIED: Final = (
    Mapped(
        "Maslow_tlX, tlY, tlZ and so on for tr, bl, br", "lines.exit_point",
        "eyelets; z: how far a belt falls from the sled; since 2025 as tlX and so on in kinematics: MaslowKinematics:",
    ),
    Mapped("spoilboardThickness, workThickness", "lines.exit_point", "added to z, as the firmware does"),
    Mapped("Maslow_vertical", "platform.plane, lines.exit_point", "a board that leans 15 degrees, or one that lies"),
    Mapped("axes.a to axes.d: max_rate_mm_per_min", "lines.winch.max_speed", "belts tl, tr, bl, br"),
)  # fmt: skip

SECTION: Final = "kinematics.maslowkinematics."
"""Where firmware since 2025 has the anchors, in small letters."""

_OLD = "maslow_"
_ENTRY = re.compile(r"( *(?:- )?)([A-Za-z_][\w-]*) *:(?!\S)", re.ASCII)
_THICKNESSES: Final = ("spoilboardThickness", "workThickness")
_ARMS: Final = ("beltEndExtension", "armLength")
_WHY: Final = {
    "fixedZ": "whether belts follow the router's height; here the platform stays in the plane of the board",
    "materialThickness": "of a version in between; write it as workThickness to have it in z",
    **{f"{corner}SoftArmExtension": "belts are straight from the anchors to one point here" for corner in CORNERS},
    **{f"Maslow_Scale_{axis}": f"the firmware multiplies {axis} of a job by it" for axis in "XY"},
}
_AXES: Final = dict(zip(CORNERS, "abcd", strict=True))
_UNLIKE: Final = 2.0
_SHORTEST: Final = 300.0  # mm


def read_maslow(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the planar robot of a Maslow's file of settings; *cable*: one of the table, default: a belt.

    Of the YAML only lines ``key: value`` are read: ``Maslow_...`` at any depth, and those in the section
    ``kinematics: MaslowKinematics:``. Raises `InputError`.
    """
    entries = yaml_entries(path)
    if not is_maslow(entries):
        raise InputError(
            f"{path}: {described(entries)}; a Maslow's settings have Maslow_tlX and so on, or kinematics: "
            "MaslowKinematics:"
        )
    lost, assumed = Notes(), Notes()
    settings = _Settings(path, entries, any(key.startswith(SECTION) for key in entries))
    anchors = {corner: settings.anchor(corner, assumed) for corner in CORNERS}
    require_unmirrored(anchors, path)
    _require_one_unit(anchors, path)
    vertical = settings.vertical(assumed)
    arm = sum(settings.length(name) for name in _ARMS)
    if arm > 0.0:
        lost.add(_of_arms(anchors, arm))
    for key, entry in entries.items():
        if key not in settings.used and (_OLD in key or key.startswith(SECTION)):
            replaced = settings.is_new and re.fullmatch(f"{_OLD}(tl|tr|bl|br)[xyz]", key.rsplit(".", 1)[-1])
            why = "the anchors of MaslowKinematics are read" if replaced else "a robot file has no such key"
            lost.add(f"{entry.name}: {_WHY.get(entry.name, why)}")
    lean = math.radians(TILT) if vertical else math.radians(90.0)
    along, out = (0.0, math.sin(lean), math.cos(lean)), (0.0, -math.cos(lean), math.sin(lean))
    top = max(z for _, _, z in anchors.values())  # where belts leave the sled
    exits = {
        corner: (x, *(_tidy(y * along[k] + (top - z) * out[k]) for k in (1, 2)))
        for corner, (x, y, z) in anchors.items()
    }
    feet = [(x, *(_tidy(y * along[k]) for k in (1, 2))) for x, y, _ in anchors.values()]  # in the plane of the board
    assumed.add(f"platform.mass: {SLED:g} kg, the sled with its router")
    assumed.add("platform: a point; belts are straight from the anchors to it, without the arms of the sled")
    if top:
        differ = len({z for _, _, z in anchors.values()}) > 1
        assumed.add(
            f"lines.platform_point: all belts leave the sled {1e3 * top:.4g} mm out of the board"
            + ", and fall to anchors that differ in height; those of a Maslow leave it at heights that differ" * differ
        )
    x, y = middle(anchors)
    zero = (x, *(_tidy(y * along[k]) for k in (1, 2)))
    assumed.add(
        "origin: the bottom left anchor; the firmware has X0 Y0 where the diagonals meet, so that a job's origin is "
        f"[{', '.join(f'{each + 0.0:.4f}' for each in zero)}] m, which platform.plane.gcode_zero has"
    )
    if vertical:
        assumed.add(f"platform.plane: a board that leans by {TILT:g} degrees")
    assumed.add(f"cable: {BELT if cable is None else cable}")
    board = {"normal": tuple(map(_tidy, out)), "distance": 0.0, "one_sided": True, "gcode_zero": zero}
    table = {
        "schema": 1,
        "name": path.stem[:100] or "maslow",
        "description": "A Maslow's sled on a board, on four belts",
        "scene": {"gravity": 9.81} | frame_of([*exits.values(), *feet], path, assumed, normal=None if vertical else 2),
        "platform": {"kind": "point", "mass": SLED, "plane": board},
        "lines": [
            _line(CORNERS[corner], at, chosen_cable(cable or BELT), settings.speed(_AXES[corner]))
            | {"platform_point": tuple(_tidy(top * each) for each in out)}
            for corner, at in exits.items()
        ],
    }
    assumed.add("tension_limits: 10 N to a fifth of the breaking load")
    robot = validated(Robot, table, path)
    version = "anchors in MaslowKinematics, since 2025" if settings.is_new else "anchors as Maslow_ keys, before 2025"
    return ImportedRobot(robot, f"a Maslow's settings ({version})", lost.all, assumed.all)


def _line(name: str, at: tuple[float, ...], cable: dict[str, Any], speed: float | None) -> dict[str, Any]:
    limits = (10.0, 0.2 * cable["breaking_load"])
    given = {"name": name, "exit_point": at, "sheave": {"kind": "eyelet"}, "cable": cable, "tension_limits": limits}
    return given if speed is None else given | {"winch": {"max_speed": speed}}


def middle(anchors: Mapping[str, tuple[float, float, float]]) -> tuple[float, float]:
    """Return the point where the diagonals of the frame meet, m; of anchors that a quadrilateral has."""
    (ax, ay, _), (bx, by, _), (cx, cy, _), (dx, dy, _) = (anchors[corner] for corner in ("bl", "tr", "br", "tl"))
    across = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
    share = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / across
    return ax + share * (bx - ax), ay + share * (by - ay)


def _of_arms(anchors: Mapping[str, tuple[float, float, float]], arm: float) -> str:
    """Return a note on arms of a length (m) that stay level while their belts slope: the lost difference of lengths.

    There a belt is sqrt((d - arm)^2 + z^2) long, of the distance d along the board, and here sqrt(d^2 + z^2) - arm.
    """
    centre = middle(anchors)
    far = {
        corner: abs(math.hypot(math.hypot(x - centre[0], y - centre[1]) - arm, z)
                    - math.hypot(x - centre[0], y - centre[1], z) + arm)
        for corner, (x, y, z) in anchors.items()
    }  # fmt: skip
    worst = max(far, key=lambda corner: far[corner])
    return (
        f"beltEndExtension, armLength: arms of {1e3 * arm:.4g} mm that stay level; belts are straight from the anchors "
        f"to one point here. In the middle of the frame a belt of the firmware is up to {1e3 * far[worst]:.2g} mm "
        f"longer ({CORNERS[worst]}), and more near an anchor"
    )


@dataclass(frozen=True)
class YamlEntry:
    """A line ``name: value`` of a YAML file, and where it is."""

    name: str
    value: str
    place: str


def yaml_entries(path: Path) -> dict[str, YamlEntry]:
    """Return the lines ``key: value`` of a YAML file by their path of keys, dotted, in small letters.

    Raises `InputError` for a ``Maslow_`` key, or one of its section, that is there twice.
    """
    found: dict[str, YamlEntry] = {}
    within: list[tuple[int, str]] = []
    for number, text in text_lines(path, MAX_BYTES, "file in YAML", indented=True):
        bare = text.partition("#")[0]
        match = _ENTRY.match(bare)
        if match is None:
            continue
        depth, name, value, place = len(match[1]), match[2], bare[match.end() :].strip(), f"{path}, line {number}"
        while within and within[-1][0] >= depth:
            within.pop()
        within.append((depth, name.lower()))
        key = name.lower() if name.lower().startswith(_OLD) else ".".join(each for _, each in within[:MAX_DEPTH])
        if key in found and (key.startswith((_OLD, SECTION))):
            raise InputError(f"{place}: {name} is given twice, also in {found[key].place.rsplit(', ', 1)[1]}")
        found[key] = YamlEntry(name, value, place)
    return found


def is_maslow(entries: Mapping[str, YamlEntry]) -> bool:
    """Whether a YAML file has settings of a Maslow."""
    return any(key.startswith((_OLD, SECTION[:-1])) for key in entries)


def described(entries: Mapping[str, YamlEntry]) -> str:
    """Return a description of a YAML file that has no settings of a Maslow."""
    for key, entry in entries.items():
        if key.startswith("kinematics.") and key.count(".") == 1:
            what = ", two belts on a wall" if entry.name.lower() == "wallplotter" else ""
            return f"is a FluidNC configuration with kinematics: {shown(entry.name)}{what}"
    if any(key.rsplit(".", 1)[-1] == "ros__parameters" for key in entries):
        return "is a file of ROS parameters"
    names = [shown(entry.name) for key, entry in entries.items() if "." not in key]
    return f"is YAML with {', '.join(names[:4])}{' and more' if len(names) > 4 else ''}" if names else "has no keys"


@dataclass(frozen=True)
class _Settings:
    """The settings of one of the two layouts; ``used``: keys that were read."""

    path: Path
    entries: Mapping[str, YamlEntry]
    is_new: bool
    used: set[str] = field(default_factory=set)

    def length(self, name: str) -> float:
        """Return the length setting *name*, m, of a file in the new layout; 0 without the key."""
        entry = self.entries.get(SECTION + name.lower())
        if entry is None:
            return 0.0
        self.used.add(SECTION + name.lower())
        return from_mm(entry.value, f"{entry.place}: {name}")

    def speed(self, axis: str) -> float | None:
        """Return the greatest speed of a belt, m/s; mm/min in the file."""
        entry = self.entries.get(f"axes.{axis}.max_rate_mm_per_min")
        return None if entry is None else 1e-3 / 60.0 * finite(entry.value, f"{entry.place}: {entry.name}", least=1e-3)

    def anchor(self, corner: str, assumed: Notes) -> tuple[float, float, float]:
        """Return an anchor, m; mm in the file."""
        found = []
        for axis in "xyz":
            name = f"{'' if self.is_new else 'Maslow_'}{corner}{axis.upper()}"
            key = SECTION + name.lower() if self.is_new else name.lower()
            if key not in self.entries:
                if axis == "z" or corner == "bl":  # the origin by Maslow's convention; files without it are written so
                    found.append(0.0)
                    assumed.add(f"{name}: 0 mm, the file has none")
                    continue
                where = " in kinematics: MaslowKinematics:" if self.is_new else ""
                raise InputError(f"{self.path}: has no {name}, the {CORNERS[corner]} anchor's {axis}, mm{where}")
            self.used.add(key)
            place = f"{self.entries[key].place}: {name}"
            found.append(from_mm(self.entries[key].value, place))
            if axis == "z" and found[-1] < 0.0:
                raise InputError(f"{place} = {1e3 * found[-1]:g}: must be 0 mm or more, over the board")
        x, y, z = found
        z += sum(map(self.length, _THICKNESSES))
        return x, y, z

    def vertical(self, assumed: Notes) -> bool:
        """Whether the board leans on a wall."""
        entry = self.entries.get("maslow_vertical")
        if entry is None:
            assumed.add("Maslow_vertical: false, the board lies flat")
            return False
        self.used.add("maslow_vertical")
        if entry.value.lower() not in ("true", "false"):
            raise InputError(f"{entry.place}: Maslow_vertical = {shown(entry.value)}: must be true or false")
        return entry.value.lower() == "true"


def require_unmirrored(anchors: Mapping[str, tuple[float, float, float]], where: Path | str) -> None:
    """Raise `InputError` where top and bottom or left and right are exchanged: the axes would be left-handed."""
    if not (anchors["tr"][0] > anchors["tl"][0] and anchors["br"][0] > anchors["bl"][0]):
        raise InputError(f"{where}: right anchors are not to the right of the left ones: axes of another handedness")
    if not (anchors["tl"][1] > anchors["bl"][1] and anchors["tr"][1] > anchors["br"][1]):
        raise InputError(f"{where}: the top anchors are not above the bottom ones: axes of another handedness")
    one, other = (
        [b - a for a, b in zip(anchors[low][:2], anchors[high][:2], strict=True)]
        for low, high in (("bl", "tr"), ("br", "tl"))
    )
    if not one[0] * other[1] > one[1] * other[0]:
        raise InputError(f"{where}: the anchors are not the corners of a frame: its diagonals do not cross")


def _require_one_unit(anchors: Mapping[str, tuple[float, float, float]], path: Path) -> None:
    """Raise `InputError` where opposite sides of a frame are so unlike, or all so short, that some are in inches."""
    for a, b, c, d in (("tl", "bl", "tr", "br"), ("tl", "tr", "bl", "br")):
        sides = sorted(1e3 * math.dist(anchors[one][:2], anchors[other][:2]) for one, other in ((a, b), (c, d)))
        if sides[1] > _UNLIKE * sides[0] or sides[1] < _SHORTEST:
            raise InputError(
                f"{path}: the sides {a} to {b} and {c} to {d} are {sides[0]:.4g} and {sides[1]:.4g} mm long: give all "
                f"anchors in mm, opposite sides equal to a factor of {_UNLIKE:g} and over {_SHORTEST:g} mm"
            )


def _tidy(value: float) -> float:
    """Return a number without the last digits that sines leave, so that a level board is level."""
    return round(value, 12) + 0.0
