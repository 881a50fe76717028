"""Export of WireX files (``.wcrfx``), schema versions 0.31 and 0.32. All numbers are SI, to the last digit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final
from xml.sax.saxutils import quoteattr

from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.translation_result import ExportedFile, Notes
from cablewright.exchange.wirex import MODULUS, VERSIONS, axes_of
from cablewright.foundation.errors import UnknownName, printable
from cablewright.models.support_table import Capability, require
from cablewright.robot import Cable, Line, Robot, Swivel
from cablewright.robot.direction import unit_vector

_CARRIED: Final = (
    "name description source platform.kind platform.mass platform.centre_of_mass lines.name lines.exit_point "
    "lines.platform_point lines.sheave.kind lines.sheave.radius lines.sheave.wrap lines.sheave.axis lines.cables "
    "lines.cable.young_modulus lines.cable.diameter lines.cable.fill_factor lines.cable.section "
    "lines.cable.construction lines.cable.axial_stiffness lines.cable.linear_density lines.cable.breaking_load "
    "lines.tension_limits lines.winch.drum_radius lines.winch.max_speed lines.winch.capacity"
)
_INERTIA: Final = "platform.inertia platform.inertia_products"


def wirex(robot: Robot, version: str = VERSIONS[-1]) -> ExportedFile:
    """Return the file of a robot. Raises `InputError` for a robot that the format cannot describe, by name."""
    if version not in VERSIONS:
        raise UnknownName("version", version, VERSIONS)
    require(robot, Capability.WIREX)
    notes = Notes()
    carried = f"{_CARRIED} {_INERTIA}" if version == "0.32" else _CARRIED
    notes.add_all(lost_keys(keys_given(robot), carried))
    unknown = [] if robot.platform.has_inertia else ["platform.inertia"]
    unknown += [
        f"lines.winch.{key}"
        for key in ("drum_radius", "max_speed", "capacity")
        if any(getattr(line.winch, key) is None for line in robot.lines)
    ]
    if unknown:
        notes.add(f"{', '.join(unknown)}: not known; 0 is written")
    winches = _winches(robot)
    body = "".join(_chain(line, winches[_winch_key(line)]) for line in robot.lines)
    parts = [
        f'<models version="{version}">\n',
        _start("robot", 4, {
            "name": robot.name, "id": "", "author": robot.source, "generator": "cablewright",
            "description": robot.description, "motionpattern": robot.platform.motion_pattern,
        }),
        f"        <geometry>\n{body}        </geometry>\n",
        _platform(robot, version),
        '        <controller ipo_clock="4.0" />\n    </robot>\n',
        _cable(robot, version, notes),
        *(_winch(name, key) for key, name in winches.items()),
        "</models>\n",
    ]  # fmt: skip
    comments = "".join(f"    <!-- lost: {_comment(each)} -->\n" for each in notes.all)
    parts.insert(1, comments)
    return ExportedFile('<?xml version="1.0" encoding="UTF-8"?>\n' + "".join(parts), notes.all)


def _chain(line: Line, winch: str) -> str:
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    if isinstance(line.sheave, Swivel):
        sign = 1.0 if line.sheave.wrap == "over" else -1.0
        given = line.sheave.axis
        is_unit = abs(math.hypot(*given) - 1.0) < 1e-9  # written as it is, so that it comes back the same
        axis = tuple(sign * each + 0.0 for each in (given if is_unit else unit_vector(given)))
    base = {**_xyz(line.exit_point), **_rotation(axis), "radius": repr(getattr(line.sheave, "radius", 0.0))}
    platform = {**_xyz(line.platform_point), **_rotation((0.0, 0.0, 1.0))}
    return (
        _start("chain", 12, {"id": line.name, "winchtype": winch})
        + _empty("base", 16, base)
        + _empty("platform", 16, platform)
        + "            </chain>\n"
    )


def _platform(robot: Robot, version: str) -> str:
    platform, inertia = robot.platform, {"Ixx": "0.0"}
    if platform.inertia is not None:
        xx, yy, zz = platform.inertia
        xy, xz, yz = platform.inertia_products
        full = {"Ixx": xx, "Ixy": xy, "Ixz": xz, "Iyx": xy, "Iyy": yy, "Iyz": yz, "Izx": xz, "Izy": yz, "Izz": zz}
        inertia = {key: repr(each) for key, each in (full if version == "0.32" else {"Ixx": xx}).items()}
    given = {"name": "platform", "description": "", "mass": repr(platform.mass), "swing_angle": "0.0"}
    return (
        _start("platform", 8, given)
        + _empty("inertiatensor", 12, inertia)
        + _empty("centerofgravity", 12, _xyz(platform.centre_of_mass))
        + "        </platform>\n"
    )


def _cable(robot: Robot, version: str, notes: Notes) -> str:
    cable, least = robot.lines[0].cable, robot.lines[0].tension_limits[0]
    modulus, radius = _modulus(cable, notes)
    given = {
        "name": "cable", "elasticity": repr(modulus), "radius": repr(radius),
        "breaking_load": repr(cable.breaking_load), "damping": "0.0", "weight": repr(cable.linear_density),
        "minimum_load": repr(least), "max_length": "0.0", "meter_cost": "0.0", "material": "",
    }  # fmt: skip
    return _empty("cable", 4, given | ({"min_length": "0.0"} if version == "0.32" else {}))


def _modulus(cable: Cable, notes: Notes) -> tuple[float, float]:
    """Return Young's modulus and the radius of a full circle that give the cable's EA."""
    if cable.young_modulus is not None and cable.diameter is not None and cable.fill_factor == 1.0:
        return cable.young_modulus, 0.5 * cable.diameter
    if cable.diameter is not None:
        radius = 0.5 * cable.diameter
    else:
        radius = math.sqrt((cable.load_section or cable.stiffness / MODULUS) / math.pi)
    notes.add("cable section: elasticity is EA over the full circle of radius, not the modulus of the file")
    return cable.stiffness / (math.pi * radius**2), radius


_WinchKey = tuple[float, int, float | None, float | None, float | None]


def _winch_key(line: Line) -> _WinchKey:
    """What one type of winch has in common."""
    winch = line.winch
    return line.tension_limits[1], line.cables, winch.drum_radius, winch.max_speed, winch.capacity


def _winches(robot: Robot) -> dict[_WinchKey, str]:
    """Return the types of winches with their names."""
    return {key: f"winch-{k + 1}" for k, key in enumerate(dict.fromkeys(map(_winch_key, robot.lines)))}


def _winch(name: str, key: _WinchKey) -> str:
    force, count, radius, speed, capacity = key
    cable = {"nr_cables": str(count), "f_max": repr(force), "dl_max": repr(capacity or 0.0)}
    return (
        _start("winch", 4, {"name": name, "description": ""})
        + _empty("cable", 8, cable | {"max_velocity": repr(speed or 0.0)})
        + _empty("drum", 8, {"r_drum": repr(radius or 0.0)})
        + "    </winch>\n"
    )


def _xyz(point: tuple[float, ...]) -> dict[str, str]:
    return {axis: repr(each) for axis, each in zip("xyz", point, strict=True)}


def _rotation(axis: tuple[float, ...]) -> dict[str, str]:
    axes = axes_of(axis)
    return {f"a{row + 1}{column + 1}": repr(axes[column][row]) for column in range(3) for row in range(3)}


def _start(tag: str, indent: int, attributes: Mapping[str, str]) -> str:
    return f"{' ' * indent}<{tag}{_attributes(attributes)}>\n"


def _empty(tag: str, indent: int, attributes: Mapping[str, str]) -> str:
    return f"{' ' * indent}<{tag}{_attributes(attributes)} />\n"


def _attributes(attributes: Mapping[str, str]) -> str:
    return "".join(f" {key}={quoteattr(printable(value))}" for key, value in attributes.items())


def _comment(sentence: str) -> str:
    return printable(sentence).replace("--", "- -")
