"""Import of WireX files (``.wcrfx``), schema versions 0.31 and 0.32. All numbers are SI."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import (
    as_point,
    assumed_cable,
    chosen_cable,
    frame_of,
    name_of,
    require_right_handed,
)
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.xml_input import Element, read_xml
from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import shown, validated
from cablewright.robot import Robot

VERSIONS: Final = ("0.31", "0.32")
MODULUS: Final = 1.1e11  # Pa: WireLib's default

CARRIED: Final = (
    Mapped("robot.name, description, author", "name, description, source"),
    Mapped("robot.motionpattern", "platform.kind", "3R3T a body, 3T a point; others are rejected"),
    Mapped("chain.id", "lines.name"),
    Mapped("chain.base x, y, z", "lines.exit_point"),
    Mapped("chain.base a13, a23, a33, radius", "lines.sheave", "a swivel about that axis; an eyelet where radius is 0"),
    Mapped("chain.platform x, y, z", "lines.platform_point"),
    Mapped("platform mass, centerofgravity", "platform.mass, centre_of_mass"),
    Mapped("platform inertiatensor", "platform.inertia, inertia_products", "0.32; 0.31 has only Ixx, which is lost"),
    Mapped("cable elasticity, radius", "cable.young_modulus, diameter", "of the full circle: fill_factor = 1"),
    Mapped("cable weight, breaking_load, minimum_load", "cable.linear_density, breaking_load; tension_limits"),
    Mapped("winch.cable f_max, nr_cables", "lines.tension_limits, cables"),
    Mapped("winch.cable max_velocity, dl_max; winch.drum r_drum", "winch.max_speed, capacity, drum_radius"),
)

Axes = tuple[tuple[float, ...], ...]

_DOWN: Axes = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
_WHY: Final = {
    "inertiatensor": "not all moments of a body",
    "l_drum": "a machine file has it, as winch.width",
    "motor": "a machine file has the motor's values",
}
_ROTATION = tuple(f"a{row}{column}" for column in (1, 2, 3) for row in (1, 2, 3))
_WIRELIB_DEFAULTS = (25.0, (0.0, 1.0, 0.2))  # mass and centre of mass WireLib's defaults


def read_wirex(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a ``.wcrfx`` file; *cable*: one of the table of cables, instead of the file's.

    Raises `InputError` for a file that is not well-formed, of another version, or of a robot that cannot be described.
    """
    return _Reader(path, read_xml(path, ("models",)), cable).robot()


class _Reader:
    """One file, and the notes made while it is read."""

    def __init__(self, path: Path, models: Element, cable: str | None) -> None:
        self.path, self.models, self.chosen = path, models, cable
        self.lost, self.assumed = Notes(), Notes()
        self.version = models.attribute("version")
        if self.version not in VERSIONS:
            raise InputError(f"{models.place}: version = {shown(self.version)}: must be {' or '.join(VERSIONS)}")
        self.given = models.one("robot")

    def robot(self) -> ImportedRobot:
        """Return the robot of the WireX file."""
        is_point = self._is_point()
        chains = list(self.given.one("geometry").all("chain"))
        if not chains:
            raise InputError(f"{self.given.place}: <geometry> has no <chain>: a robot without lines")
        lines = [self._line(each) for each in chains]
        if is_point and not as_point(lines):
            raise InputError(f"{self.given.place}: motionpattern 3T with several platform points: it would not rotate")
        if not is_point and as_point(lines) and len(lines) > 1:
            self.lost.add("robot.motionpattern 3R3T: all lines meet in one point, about which nothing holds a body")
            is_point = True
        table = {
            "schema": 1,
            "name": name_of(self.given.attributes.get("name", ""), self.path),
            "description": self.given.attributes.get("description", ""),
            "source": self.given.attributes.get("author", ""),
            "scene": frame_of([line["exit_point"] for line in lines], self.path, self.assumed),
            "platform": self._platform(is_point),
            "lines": lines,
        }
        self.given.skip("name", "description", "author", "generator", "id")
        for each in self.models.unread():
            name = each.removeprefix("models.").removeprefix("robot.")
            why = next((why for part, why in _WHY.items() if part in name), "a robot file has no such key")
            self.lost.add(f"{name}: {why}")
        robot = validated(Robot, table, self.path)
        return ImportedRobot(robot, f"WireX {self.version}", self.lost.all, self.assumed.all)

    def _is_point(self) -> bool:
        if "motionpattern" not in self.given.attributes:
            self.assumed.add("platform.kind: a body; the file has no motionpattern, and WireLib takes 3R3T")
            return False
        pattern = self.given.attribute("motionpattern")
        if pattern not in ("3R3T", "3T"):
            why = "must be 3R3T or 3T; of planar ones the file does not say which way gravity acts"
            raise InputError(f"{self.given.place}: motionpattern = {shown(pattern)}: {why}")
        return pattern == "3T"

    def _line(self, given: Element) -> dict[str, Any]:
        base, platform = given.one("base"), given.one("platform")
        name = given.attribute("id")
        self._check_platform(platform)
        winch = self._winch(given)
        low, high, cable = self._cable(winch)
        return {
            "name": name,
            "exit_point": _point(base),
            "platform_point": _point(platform),
            "sheave": self._sheave(base),
            "cable": cable,
            "tension_limits": (low, high),
            "cables": self._count(winch),
            "winch": self._drum(winch),
        }

    def _sheave(self, base: Element) -> dict[str, Any]:
        axes = _rotation(base)
        radius = base.number("radius", 0.1, least=0.0)
        if "radius" not in base.attributes:
            self.assumed.add("sheave.radius 0.1 m: the file has none, and WireLib takes this")
        if radius == 0.0:
            return {"kind": "eyelet"}
        x, y, z = axes[2]
        if max(abs(a - b) for a, b in zip(chain(*axes), chain(*axes_of(axes[2])), strict=True)) > 1e-6:
            self.lost.add("chain.base a11 to a32: which way the mounting of a sheave faces")
        if x == y == 0.0:
            return {"kind": "swivel", "radius": radius, "wrap": "over" if z > 0.0 else "under"}
        return {"kind": "swivel", "radius": radius, "axis": axes[2]}

    def _check_platform(self, platform: Element) -> None:
        if _rotation(platform) != axes_of((0.0, 0.0, 1.0)):
            self.lost.add("chain.platform a11 to a33: the orientation of a platform point, of which nothing is known")

    def _platform(self, is_point: bool) -> dict[str, Any]:
        given = self.given.one("platform")
        mass, centre = given.number("mass", least=1e-9), _point(given.one("centerofgravity"))
        if (mass, centre) == _WIRELIB_DEFAULTS:
            self.assumed.add("platform.mass and centre_of_mass: defaults of WireLib")
        if is_point:
            if any(centre):
                self.lost.add("platform.centerofgravity: a point platform has none")
            return {"kind": "point", "mass": mass}
        return {"kind": "rigid", "mass": mass, "centre_of_mass": centre} | self._inertia(given.one("inertiatensor"))

    def _inertia(self, tensor: Element) -> dict[str, Any]:
        if not {"Ixx", "Iyy", "Izz"} <= set(tensor.attributes):
            return {}
        moments = tuple(tensor.number(key) for key in ("Ixx", "Iyy", "Izz"))
        products = tuple(tensor.number(key, 0.0) for key in ("Ixy", "Ixz", "Iyz"))
        for key, value in zip(("Iyx", "Izx", "Izy"), products, strict=True):
            if tensor.number(key, value) != value:
                raise InputError(f"{tensor.place}: {key} = {tensor.attributes[key]}: a tensor is symmetric, {value:g}")
        return {"inertia": moments} | ({"inertia_products": products} if any(products) else {})

    def _winch(self, given: Element) -> Element | None:
        """The winch of a line: that of its type, or the only one."""
        winches = {each.attribute("name"): each for each in self.models.all("winch")}
        if len(winches) < sum(1 for _ in self.models.all("winch")):
            raise InputError(f"{self.path}: two <winch> have the same name; give each a name of its own")
        wanted = given.attribute("winchtype") if "winchtype" in given.attributes else ""
        if wanted in winches:
            return winches[wanted]
        if len(winches) == 1:
            self.assumed.add(f"winch of type {shown(wanted)}: the file has no such; its only <winch> is taken")
            return next(iter(winches.values()))
        if winches:
            raise InputError(f"{given.place}: winchtype = {shown(wanted)}: no <winch> has that name")
        return None

    def _cable(self, winch: Element | None) -> tuple[float, float, dict[str, Any]]:
        """Return min and max tension, N, and the cable."""
        given, table = self.models.maybe("cable"), None
        if self.chosen is not None:
            table = chosen_cable(self.chosen)
            self.assumed.add(f"cable: {self.chosen}, as requested")
        elif given is not None:
            radius = given.number("radius", least=1e-6)
            given.skip("name")
            if "elasticity" not in given.attributes:
                self.assumed.add(f"cable.young_modulus {MODULUS:g} Pa: the file has none, and WireLib takes this")
            table = {
                "young_modulus": given.number("elasticity", MODULUS, least=1e-9),
                "diameter": 2.0 * radius,
                "fill_factor": 1.0,
                "linear_density": given.number("weight", least=0.0),
                "breaking_load": given.number("breaking_load", least=1e-9),
            }
        low = 0.0 if given is None else given.number("minimum_load", 0.0, least=0.0)
        low, high = self._limits(winch, low)
        if table is None and not high:
            raise InputError(f"{self.path}: has no <cable>, and no load that one could be chosen for; give --cable")
        table = table or assumed_cable(high, self.assumed)
        if not high:
            high = table["breaking_load"]
            self.assumed.add("tension_limits: up to the breaking load; the file has no f_max")
        return low, high, table

    def _limits(self, winch: Element | None, low: float) -> tuple[float, float]:
        """Return min and max tension, N, of the winch, or else of the application; 0 where none is given."""
        high = 0.0 if winch is None else winch.one("cable").number("f_max", 0.0, least=0.0)
        application = self.given.maybe("application")
        if application is None or high:
            return low, high
        application.skip("name", "id", "description")
        low = application.number("min_cable_load", low, least=0.0)
        return low, application.number("max_cable_load", 0.0, least=0.0)

    def _count(self, winch: Element | None) -> int:
        count = 1.0 if winch is None else winch.one("cable").number("nr_cables", 1.0, least=1.0)
        if count != int(count) and winch is not None:
            raise InputError(f"{winch.place}: nr_cables = {count:g}: must be a whole number of cables")
        return int(count)

    def _drum(self, winch: Element | None) -> dict[str, float]:
        """Return the winch; 0 means not set."""
        if winch is None:
            return {}
        winch.skip("name", "description")
        cable, drum = winch.one("cable"), winch.maybe("drum")
        found: Mapping[str, float] = {
            "drum_radius": 0.0 if drum is None else drum.number("r_drum", 0.0, least=0.0),
            "max_speed": cable.number("max_velocity", 0.0, least=0.0),
            "capacity": cable.number("dl_max", 0.0, least=0.0),
        }
        return {key: value for key, value in found.items() if value}


def _point(element: Element) -> tuple[float, ...]:
    return tuple(element.number(axis) for axis in "xyz")


def _rotation(element: Element) -> tuple[tuple[float, ...], ...]:
    """Return the columns of the rotation; without any of it, the axes of the world. Raises `InputError`."""
    if not set(_ROTATION) & set(element.attributes):
        return axes_of((0.0, 0.0, 1.0))
    entries = [element.number(key) + 0.0 for key in _ROTATION]  # + 0.0: no -0.0
    axes = tuple(tuple(entries[3 * k : 3 * k + 3]) for k in range(3))
    require_right_handed(axes, element.place)
    return axes


def axes_of(axis: Sequence[float]) -> Axes:
    """Return right-handed axes (columns x, y, z) of a sheave's mounting; z is *axis*, a unit vector.

    The sheave swivels about z, along which the cable arrives. The axes of an upright sheave are those of the world. The
    directions of x and y have no meaning here.
    """
    a, b, c = axis
    if a == b == 0.0:
        return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) if c > 0.0 else _DOWN
    level = math.hypot(a, b)
    x = (-b / level, a / level, 0.0)
    y = (-c * x[1], c * x[0], a * x[1] - b * x[0])
    return x, tuple(each + 0.0 for each in y), (a, b, c)
