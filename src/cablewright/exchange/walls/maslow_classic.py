"""Import of a classic Maslow (before 2023, two chains) from GroundControl's or its firmware's settings. Lengths are mm.

The origin is the middle of the sheet; x is to the right, y up the board. Chains pull along lines through the bit, as
where they end on a ring or a linkage about it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from cablewright.exchange.millimetres import from_mm
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.walls.two_belts import Wall, wall_robot
from cablewright.exchange.xml_input import finite
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError

MAX_BYTES: Final = 1 << 20
LEAN: Final = math.radians(15.0)  # of the frame from the vertical, assumed
SLED: Final = 10.0  # kg, assumed
CHAIN: Final = {"linear_density": 0.14, "breaking_load": 3500.0, "diameter": 0.006, "thermal_expansion": 12e-6}
"""A roller chain of 1/4 inch (04C, ANSI 25): its mass and breaking load by ISO 606, and the height of its plates."""

_STRETCH = "5.1685e-6"  # 1/N, the firmware's own elongation of a chain
_NUMBERS: Final = {
    "0": "bedwidth", "1": "bedheight", "2": "motorspacingx", "3": "motoroffsety", "7": "kinematicstype",
    "8": "rotationradius", "10": "chainlength", "13": "distperrot",
}  # fmt: skip
"""Settings by the number of the firmware, and the name that GroundControl gives them, in small letters."""

_READ: Final = {*_NUMBERS.values(), "sledweight", "chainelongationfactor"}

CARRIED: Final = (
    Mapped("motorSpacingX, motorOffsetY, bedHeight; $2, $3, $1", "lines.exit_point", "eyelets in the motors' axes"),
    Mapped("bedHeight; $1", "scene.frame_min", "from the lower edge of the sheet"),
    Mapped("sledWeight", "platform.mass", "N there"),
    Mapped("chainLength; $10", "lines.winch.capacity"),
    Mapped("distPerRot; $13", "lines.winch.drum_radius", "of the sprocket: over 2 pi"),
    Mapped("chainElongationFactor", "lines.cable.axial_stiffness", "its inverse"),
)

_INI = re.compile(r"(\w+)\s*[=:]([^#;]*)")
_REPORT = re.compile(r"\$([0-9]+)\s*=([^(]*)(?:\(.*)?")


def read_maslow_classic(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of GroundControl's ``groundcontrol.ini``, or of the firmware's list for ``$$``.

    Raises `InputError`.
    """
    settings, places = _settings(path)
    lost, assumed = Notes(), Notes()

    def metres(name: str, default: str) -> float:
        if name not in settings:
            assumed.add(f"{name}: {default} mm, the firmware's own")
        return from_mm(settings.get(name, default), f"{places.get(name, path)}: {name}")

    if "motorspacingx" not in settings:
        raise InputError(f"{path}: has no motorSpacingX ($2), the distance between the motors, mm")
    apart, above, height = metres("motorspacingx", ""), metres("motoroffsety", "463"), metres("bedheight", "1219.2")
    kind = settings.get("kinematicstype", "Triangular").strip().lower()
    if kind in ("quadrilateral", "1", "1.0"):
        lost.add("kinematicsType: Quadrilateral: a sled on two points that tilts; here the chains meet in one point")
    winch = {"drum_radius": metres("distperrot", "63.5") / math.tau}
    if "chainlength" in settings:
        winch["capacity"] = metres("chainlength", "")
    weight = settings.get("sledweight")
    if weight is None:
        assumed.add(f"platform.mass: {SLED:g} kg, the sled with its router")
    mass = SLED if weight is None else finite(weight, f"{places['sledweight']}: sledWeight", least=0.1) / 9.81
    stretch = settings.get("chainelongationfactor", _STRETCH)
    chain = CHAIN | {
        "axial_stiffness": 1.0
        / finite(stretch, f"{places.get('chainelongationfactor', path)}: chainElongationFactor", least=1e-9)
    }
    if cable is None:
        assumed.add("cable: a roller chain of 1/4 inch; of its elongation the firmware's own unless the file has one")
    if "rotationradius" in settings:
        lost.add("rotationRadius: chains end on a ring about the bit; here each chain is longer by that radius")
    for name in settings:
        if name not in _READ:
            lost.add(f"{name}: a robot file has no such key")
    assumed.add(f"platform.plane: a board that leans by {math.degrees(LEAN):g} degrees")
    lost.add("chains wrap around their sprockets; here they leave from the motors' axes")
    y = 0.5 * height + above
    wall = Wall((-0.5 * apart, y), (0.5 * apart, y), -0.5 * height, LEAN, mass, chain, (winch, winch))
    robot = wall_robot(path, wall, "A Maslow's sled on a board, on two chains", cable, assumed)
    version = "the firmware's $$" if places["motorspacingx"].endswith("$2") else "GroundControl's settings"
    return ImportedRobot(robot, f"a classic Maslow ({version})", lost.all, assumed.all)


def _settings(path: Path) -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Return the settings by name in small letters, those without a name by number, and their places."""
    settings, places = {}, {}
    for number, text in text_lines(path, MAX_BYTES, "Maslow's settings"):
        place = f"{path}, line {number}"
        if report := _REPORT.fullmatch(text):
            name = _NUMBERS.get(report[1], f"${report[1]}")
            settings[name], places[name] = report[2].strip(), f"{place}, ${report[1]}"
        elif entry := _INI.fullmatch(text):
            settings[entry[1].lower()], places[entry[1].lower()] = entry[2].strip(), place
    return settings, places
