"""Table of support: which capability of the program works with which feature of a robot.

Errors, the page `docs/support.md`, `cablewright robots NAME --support` and the notes of exports read it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from cablewright.foundation.errors import InputError
from cablewright.robot import (
    Eyelet,
    GuideSheave,
    Line,
    PlatformPulley,
    PlatformSheave,
    Pulley,
    RigidPlatform,
    Robot,
    Swivel,
    UniversalJoint,
)

if TYPE_CHECKING:
    from cablewright.models.statics import Model


class Coverage(StrEnum):
    """Degree of support of a feature by a capability, from the best to the worst."""

    WORKS = "works"
    NOT_CHECKED = "not checked"
    LOST = "lost"
    REJECTED = "rejected"


class Capability(StrEnum):
    """A function of this program on a robot, by its name in messages."""

    INVERSE = "inverse"
    FORWARD = "forward"
    LINEARISE = "linearise"
    MODES = "modes"
    CERTIFY = "certify"
    TRACKER = "certificates of a Tracker"
    POSE_BOX = "a box of poses"
    EQUILIBRIA = "equilibria"
    EXHAUSTIVE = "exhaustive"
    TENSIONS = "tension distribution"
    WRENCH_CLOSURE = "wrench-closure"
    CAPACITY = "capacity"
    TENSION_CHOICE = "a choice of tensions"
    WORKSPACE = "workspace"
    STRAIGHT_WORKSPACE = "workspace of straight lines"
    BOUNDARY_MODES = "modes on the boundary"
    EXCESS = "excess lengths"
    SLACK = "slack lines"
    SLACK_SETS = "sets of slack lines"
    SHAPE = "the shape of a line"
    LET_OUT = "a line let out alone"
    CHECK = "check"
    PATH = "poses along a path or over a grid"
    BRACKET = "bracket"
    SURVEY = "a survey of exit points"
    CALIBRATION = "calibration"
    ELASTIC_CALIBRATION = "calibration of lines that stretch"
    SIMULATION = "the simulated machine"
    MACHINE_FILE = "machines --for"
    PRINT = "print"
    ESTIMATION = "estimation"
    ROOM_ESTIMATION = "estimation by lidars"
    CONTROL = "velocity control"
    HOMING = "homing"
    DRIVES = "drives"
    SERVE = "serve"
    KLIPPER = "export klipper"
    KLIPPER_WINCH = "Klipper's winch kinematics"
    REPRAPFIRMWARE = "export reprapfirmware"
    LINUXCNC = "export linuxcnc"
    WIREX = "export wirex"
    MJCF = "export mjcf"
    URDF = "export urdf"


@dataclass(frozen=True)
class Feature:
    """A feature of robots.

    ``key``: key of the feature in the robot file; ``holder``: name of the part that has the feature; empty: none.
    """

    name: str
    words: str
    key: str
    holder: Callable[[Robot], str]


@dataclass(frozen=True)
class Cell:
    """One cell of the table of support.

    ``instead``: the alternative to use; of `Coverage.LOST` and NOT_CHECKED the part that is left out. ``because``: the
    property of the robot that decides the answer of `support`.
    """

    verdict: Coverage = Coverage.WORKS
    instead: str = ""
    because: str = ""


def _of_line(name: str, words: str, key: str, has: Callable[[Line], bool]) -> Feature:
    """Return a feature of lines, of which the first that has it is named."""
    return Feature(
        name, words, f"lines.{key}", lambda robot: next((f"line {x.name!r}" for x in robot.lines if has(x)), "")
    )


def _of_robot(name: str, words: str, key: str, has: Callable[[Robot], bool]) -> Feature:
    return Feature(name, words, key, lambda robot: f"robot {robot.name!r}" if has(robot) else "")


def _over(most: int) -> Feature:
    return _of_robot(f"over-{most}-lines", f"more than {most} lines", "lines", lambda robot: robot.m > most)


def _has_tilted_plane(robot: Robot) -> bool:
    return robot.platform.plane is not None and robot.platform.plane.axis is None


def _has_few_shared_winches(robot: Robot) -> bool:
    """Whether winches that lines share are too few for the pose, and hold not just the position."""
    position = 3 if robot.platform.plane is None else 2
    return bool(robot.sharing) and robot.winches < robot.freedoms and robot.winches != position


FEATURES: Final = (
    _of_robot("lines", "lines", "lines, their cables, sheaves and winches", lambda robot: bool(robot.lines)),
    _of_line("eyelet", "an eyelet as its sheave", "sheave.kind", lambda x: isinstance(x.sheave, Eyelet)),
    _of_line("swivel", "a swivel as its sheave", "sheave.kind", lambda x: isinstance(x.sheave, Swivel)),
    _of_line("universal-joint", "a universal joint", "sheave.kind", lambda x: isinstance(x.sheave, UniversalJoint)),
    _of_line("pulley", "a pulley in a fixed plane", "sheave.kind", lambda x: isinstance(x.sheave, Pulley)),
    _of_line("tilted-swivel", "a swivel whose axis is not vertical", "sheave.axis",
             lambda x: isinstance(x.sheave, Swivel) and not x.sheave.upright),
    _of_line("winch-aside", "a winch that is not on the axis of its swivel", "winch_exit", lambda x: x.is_aside),
    _of_line("guides", "guides", "guides", lambda x: bool(x.guides)),
    _of_line("guide-wheels", "guides that are wheels", "guides",
             lambda x: any(isinstance(guide, GuideSheave) for guide in x.guides)),
    _of_line("platform-sheave", "a sheave on the platform", "platform_sheave",
             lambda x: isinstance(x.platform_sheave, PlatformSheave)),
    _of_line("sheave-to-sheave", "a sheave on the platform and one that turns on the frame", "platform_sheave",
             lambda x: isinstance(x.platform_sheave, PlatformSheave) and not isinstance(x.sheave, Eyelet)),
    _of_line("platform-pulley", "a pulley on the platform", "platform_sheave",
             lambda x: isinstance(x.platform_sheave, PlatformPulley)),
    _of_line("advantage", "an advantage over 1", "advantage", lambda x: x.advantage > 1),
    _of_line("cables", "several cables side by side", "cables", lambda x: x.cables > 1),
    _of_line("mount", "exit_compliance", "exit_compliance", lambda x: x.mount_gives),
    _of_line("spatial-mount", "an exit_compliance that leaves its vertical plane", "exit_compliance",
             lambda x: bool(x.mount_out_of_plane_by)),
    _of_line("spring", "a spring", "spring", lambda x: x.spring is not None),
    _of_line("counterweight", "a counterweight", "counterweight", lambda x: x.counterweight is not None),
    _of_line("shared-winch", "shared_winch", "shared_winch", lambda x: x.shared_winch is not None),
    _of_line("weightless", "a cable without weight", "cable.linear_density", lambda x: x.cable.linear_density == 0.0),
    _of_line("no-diameter", "no cable.diameter", "cable.diameter", lambda x: x.cable.diameter is None),
    _of_line("no-drum-radius", "no winch.drum_radius", "winch.drum_radius",
             lambda x: x.winch.drum_radius is None and x.counterweight is None),
    _of_robot("unlike-cables", "lines with different cables", "lines.cable",
              lambda robot: len({x.cable for x in robot.lines}) > 1),
    _of_robot("unlike-min-tensions", "lines with different minimum tensions", "lines.tension_limits",
              lambda robot: len({x.tension_limits[0] for x in robot.lines}) > 1),
    _of_robot("no-gravity", "gravity = 0", "scene.gravity", lambda robot: robot.scene.gravity == 0.0),
    _of_robot("offset-point", "lines that meet away from the platform's origin", "lines.platform_point",
              lambda robot: robot.n == 3 and any(robot.lines[0].platform_point)),
    _of_robot("plane", "platform.plane", "platform.plane", lambda robot: robot.platform.plane is not None),
    _of_robot("tilted-plane", "a tilted platform.plane", "platform.plane", _has_tilted_plane),
    _of_robot("body", "a rigid platform", "platform.kind", lambda robot: isinstance(robot.platform, RigidPlatform)),
    _of_robot("retraction", "platform.retraction", "platform.retraction", lambda robot: robot.retraction is not None),
    *map(_over, (6, 8, 17, 26)),
    _of_robot("few-winches", "fewer winches than degrees of freedom", "lines",
              lambda robot: robot.winches < robot.freedoms),
    _of_robot("few-shared-winches", "shared winches that hold neither its pose nor its position alone",
              "lines.shared_winch", _has_few_shared_winches),
    _of_robot("free-position", "fewer winches than hold its position", "lines",
              lambda robot: robot.winches < min(robot.freedoms, 2 if robot.platform.plane else 3)),
    _of_robot("few-lines-in-plane", "fewer lines than degrees of freedom in its plane", "lines",
              lambda robot: robot.platform.plane is not None and robot.m < robot.freedoms),
)  # fmt: skip
"""What robots may have, by which capabilities differ."""

SPATIAL: Final = "counterweight pulley winch-aside platform-sheave platform-pulley tilted-swivel guides spatial-mount"
"""Features of lines that are more than a winch and a cable in one vertical plane."""

_TURNING: Final = "swivel universal-joint pulley platform-sheave platform-pulley"
_OWN_WINCH: Final = "Give each line a winch of its own"
_WINCH_OR_URDF: Final = f"{_OWN_WINCH}, or export urdf, which has no lines"
_BY_ANGLE: Final = "Export klipper, which moves winches by their angle"
_NOTHING: Final = "the format has nothing like it"
_IN_FILE: Final = "Give the number in the robot file"
_C, _LOST, _REJECTED = Capability, Coverage.LOST, Coverage.REJECTED

_ROWS: Final = (
    (_C.EXHAUSTIVE, _REJECTED,
     f"{SPATIAL} mount spring plane advantage cables body weightless no-gravity",
     "Search from many starts: leave out exhaustive"),
    (_C.TENSION_CHOICE, _REJECTED, "few-winches", "The balance leaves no tension to choose: use inverse"),
    (_C.BOUNDARY_MODES, _REJECTED, "few-winches tilted-plane", "Use modes at a pose"),
    (_C.SLACK, _REJECTED, "few-winches", "Each line is needed at a given pose: use forward with longer lengths"),
    (_C.SLACK_SETS, _REJECTED, "few-winches", "Each line is needed at a given pose: use forward with longer lengths"),
    (_C.CHECK, Coverage.NOT_CHECKED, "mount",
     "coupled mounts, as two exit points on one post: each mount deflects under its own line only"),
    (_C.CHECK, Coverage.NOT_CHECKED, "shared-winch",
     "lengths without compensation take each line to have a winch of its own"),
    (_C.CHECK, Coverage.NOT_CHECKED, "counterweight",
     "counterweights against what is around them, and the room they move in"),
    (_C.CHECK, _REJECTED, "few-shared-winches", "Use inverse with free coordinates (nan)"),
    (_C.PATH, _REJECTED, "few-shared-winches", "Use a pose with free coordinates (nan)"),
    (_C.BRACKET, _REJECTED, "eyelet swivel pulley", "Give all lines universal joints, whose lever the bracket holds"),
    (_C.BRACKET, _REJECTED, "mount", "Leave out exit_compliance: the bracket deflects by itself"),
    (_C.SURVEY, _REJECTED, SPATIAL, "Write the surveyed points into the robot file"),
    (_C.SIMULATION, _REJECTED, "weightless no-gravity no-diameter no-drum-radius", _IN_FILE),
    (_C.MACHINE_FILE, _REJECTED, "weightless no-diameter no-drum-radius no-gravity", _IN_FILE),
    (_C.PRINT, _REJECTED, "free-position few-shared-winches", "Use check, or inverse at poses"),
    (_C.CONTROL, _REJECTED, "free-position few-shared-winches", "Use check, or inverse at poses"),
    (_C.ESTIMATION, _REJECTED, "free-position", "Use forward with the measured lengths"),
    (_C.ROOM_ESTIMATION, _REJECTED, "body", "Use the estimator encoders"),
    (_C.ROOM_ESTIMATION, _REJECTED, "weightless no-drum-radius", _IN_FILE),
    (_C.ESTIMATION, _REJECTED, "no-diameter no-drum-radius", _IN_FILE),
    (_C.HOMING, _REJECTED, "free-position few-shared-winches", "Use forward with the measured lengths"),
    (_C.DRIVES, _REJECTED, "no-diameter no-drum-radius", _IN_FILE),
    (_C.SERVE, _REJECTED, "free-position few-shared-winches", "Use inverse at poses"),
    (_C.KLIPPER, _REJECTED, "free-position few-shared-winches few-lines-in-plane", _WINCH_OR_URDF),
    (_C.LINUXCNC, _REJECTED, "free-position few-shared-winches few-lines-in-plane", _WINCH_OR_URDF),
    (_C.REPRAPFIRMWARE, _REJECTED, "counterweight shared-winch", _BY_ANGLE),
    (_C.REPRAPFIRMWARE, _REJECTED, "few-winches", _WINCH_OR_URDF),
    (_C.REPRAPFIRMWARE, _REJECTED, f"{_TURNING} body plane", _BY_ANGLE),
    (_C.KLIPPER_WINCH, _REJECTED, f"{_TURNING} advantage body plane", _BY_ANGLE),
    (_C.KLIPPER_WINCH, _REJECTED, "counterweight shared-winch", _BY_ANGLE),
    (_C.KLIPPER_WINCH, _REJECTED, "few-winches", _WINCH_OR_URDF),
    (_C.KLIPPER_WINCH, _REJECTED, "no-drum-radius", _IN_FILE),
    (_C.KLIPPER, _REJECTED, "no-drum-radius", _IN_FILE),
    (_C.LINUXCNC, _REJECTED, "no-drum-radius", _IN_FILE),
    (_C.REPRAPFIRMWARE, _REJECTED, "no-drum-radius", _IN_FILE),
    (_C.KLIPPER, _REJECTED, "over-17-lines", "Leave out some of them"),
    (_C.LINUXCNC, _REJECTED, "over-6-lines", "Export klipper"),
    (_C.REPRAPFIRMWARE, _REJECTED, "over-8-lines", _BY_ANGLE),
    (_C.KLIPPER_WINCH, _REJECTED, "over-26-lines", _BY_ANGLE),
    (_C.REPRAPFIRMWARE, _LOST, "guides mount spring", _NOTHING),
    (_C.KLIPPER_WINCH, _LOST, "cables guides mount spring", _NOTHING),
    (_C.WIREX, _REJECTED, "universal-joint advantage plane", "Export mjcf"),
    (_C.WIREX, _REJECTED, "platform-sheave", "Export mjcf, which has it over eyelets"),
    (_C.WIREX, _REJECTED, "pulley platform-pulley", "Export urdf, which has no lines"),
    (_C.WIREX, _REJECTED, "unlike-cables unlike-min-tensions", "Give all lines the same"),
    (_C.WIREX, _REJECTED, "winch-aside", "Leave out its winch_exit"),
    (_C.WIREX, _REJECTED, "counterweight", _WINCH_OR_URDF),
    (_C.WIREX, _LOST, "guides mount spring shared-winch retraction", _NOTHING),
    (_C.MJCF, _REJECTED, "pulley winch-aside platform-pulley sheave-to-sheave", "Export urdf, which has no lines"),
    (_C.MJCF, _LOST, "cables", "one tendon pulls for all cables side by side"),
    (_C.MJCF, _LOST, "guide-wheels",
     "wheels are sites on their rims, which hold the cable there; their arcs keep their lengths"),
    (_C.MJCF, _LOST, "mount spring shared-winch retraction", _NOTHING),
    (_C.URDF, _LOST, "lines", "URDF has no cables"),
)  # fmt: skip

SUPPORT: Final[Mapping[tuple[Capability, str], Cell]] = MappingProxyType(
    {
        (capability, name): Cell(verdict, instead)
        for capability, verdict, names, instead in _ROWS
        for name in names.split()
    }
)
"""The cells by capability and name of a feature; what is absent works."""

_BY_NAME: Final = {feature.name: feature for feature in FEATURES}
_CELLS: Final = {
    capability: tuple((_BY_NAME[name], cell) for (own, name), cell in SUPPORT.items() if own is capability)
    for capability in Capability
}
_ORDER: Final = tuple(Coverage)


def features(robot: Robot) -> Iterator[tuple[Feature, str]]:
    """Yield each of `FEATURES` that a robot has, and the part of the robot that has it, in words."""
    yield from ((feature, holder) for feature in FEATURES if (holder := feature.holder(robot)))


def cells(robot: Robot, capability: Capability) -> Iterator[tuple[Feature, Cell]]:
    """Yield the cells of a capability that apply to features of the robot, each with the deciding object."""
    for feature, cell in _CELLS[capability]:
        if holder := feature.holder(robot):
            yield feature, replace(cell, because=f"{holder} has {feature.words}")


def support(robot: Robot, capability: Capability) -> Cell:
    """Return how well a capability supports a robot: the worst cell of its features decides."""
    met = (cell for _, cell in cells(robot, capability))
    return max(met, key=lambda cell: _ORDER.index(cell.verdict), default=Cell())


def require(robot: Robot | Model, capability: Capability) -> None:
    """Raise `InputError` for a robot that a capability does not cover: the feature, its part, and the alternative."""
    found = support(robot if isinstance(robot, Robot) else robot.robot, capability)
    if found.verdict is Coverage.REJECTED:
        raise InputError(f"{capability}: {found.because}; not supported. {found.instead}")


def losses(robot: Robot, capability: Capability) -> Iterator[str]:
    """Yield a sentence for each feature of a robot that an export loses."""
    for feature, cell in cells(robot, capability):
        if cell.verdict is Coverage.LOST:
            yield f"{feature.key}: {cell.instead}"
