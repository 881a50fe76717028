"""Import and export of RepRapFirmware's Hangprinter settings (M669 K6, M666). Lengths are mm.

RepRapFirmware has up to five anchors, from 3.7 on eight, and a point that prints on straight lines from there. It knows
advantage, cables side by side, one rate of build-up, and how a line stretches.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.firmware_robots import anchored_robot, as_points, spool
from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.millimetres import from_mm, to_mm
from cablewright.exchange.rrf_spool import SpoolLaw, dead_length, spool_law
from cablewright.exchange.translation_result import ExportedFile, ImportedRobot, Mapped, Notes
from cablewright.exchange.xml_input import finite, whole
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import RrfVersionName
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError
from cablewright.machine.settings import MachineSettings
from cablewright.models.drum import WinchDrum, drum_of
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot

MAX_BYTES: Final = 1 << 20
LETTERS: Final = "ABCDIJLO"
"""Of anchors; 3.5 and 3.6 name others after I, but write past their arrays with more than `FEW`."""

FEW: Final = 5
"""Most anchors of RepRapFirmware 3.5 and 3.6; 3.7 has one for each of `LETTERS`."""

KINEMATICS: Final = {
    "0": "Cartesian", "1": "CoreXY", "2": "CoreXZ", "3": "a linear delta", "4": "a serial SCARA", "5": "CoreXYU",
    "7": "polar", "8": "CoreXYUV", "9": "a five-bar SCARA", "10": "a rotary delta", "11": "Markforged",
}  # fmt: skip
"""What M669 K says instead of 6, a Hangprinter's."""

CARRIED: Final = (
    Mapped("M669 A B C D I", "lines.exit_point", "eyelets of a point platform"),
    Mapped("M666 R", "lines.winch.drum_radius", "of the cable as it leaves the drum at the origin"),
    Mapped("M666 Q", "lines.winch.build_up, drum_length", "one Q; with a machine file, that of its [winch]"),
    Mapped("M666 U, O", "lines.advantage, cables"),
    Mapped("M666 I, X", "lines.tension_limits", "of all spans there, of one here"),
    Mapped("M666 S", "lines.cable.axial_stiffness"),
    Mapped("M666 Y", "lines.dead_length", "a guy wire"),
    Mapped("M666 W", "platform.mass"),
)

_BLOCKS = ("if", "elif", "else", "while")
_ELSEWHERE: Final = {
    "M98": "commands of other files are not read",
    "M501": "config-override.g is not read; its M666 and M669 replace this file's",
}
_WITH_TEXT: Final = ("M23", "M28", "M30", "M32", "M36", "M37", "M38", "M98", "M117", "M118", "M550", "M551")
"""Commands whose text may stand without quotes: it is the rest of the line."""

_LINE_NUMBER = re.compile(r"^N[0-9]+\s*", re.IGNORECASE | re.ASCII)
_CHECKSUM = re.compile(r"\*[0-9]{1,5}(?=\s*(?:;|$))", re.ASCII)
_META = re.compile(r"(?:if|elif|else|while|var|global|set|echo|skip|break|continue|abort)(?![^\s{\"(])")
_HEAD = re.compile(r"([GMT](?:-?[0-9]+(?:\.[0-9]+)?)?)\s*(.*)", re.IGNORECASE | re.ASCII)
_WORD = re.compile(r"([A-Z])\s*([^\sA-Z]*)", re.IGNORECASE | re.ASCII)
_MOVED = "RQUOLHJ"  # letters of M666 that were of M669 before 2020, where M666 had others
_Words = dict[str, tuple[str, str]]


@dataclass(frozen=True)
class _Defaults:
    """What a version takes for letters that are not given: M666 R, mm, Q, mm, U and O."""

    version: str
    radius: str
    advantage: tuple[int, ...]
    cables: tuple[int, ...] = (1,) * FEW
    growth: str = "0.007"


_NEW = _Defaults("RepRapFirmware", "75", (2, 2, 2, 2, 4))
_OLD = _Defaults("RepRapFirmware of 2019", "55", (1,) * FEW, (2, 2, 2, 3, 3))
_STIFFNESS, _MOST_FORCE = "20000", "70"  # of M666 S, N, and X, N, where W turns on the compensation of stretch


def read_rrf(path: Path, cable: str | None = None, below: float = 0.0) -> ImportedRobot:
    """Return the robot of a ``config.g`` of a Hangprinter; *below* as of `anchored_robot`. Raises `InputError`."""
    lost, assumed = Notes(), Notes()
    commands = _commands(path, lost)
    geometry, machine = commands["M669"], commands["M666"]
    kind = geometry.get("K", ("", ""))[0]
    if kind != "6":
        named = f": K{kind} is {KINEMATICS[kind]}" if kind in KINEMATICS else ""
        if not geometry and commands["M665"]:
            named = ": M665 is of a linear delta"
        raise InputError(f"{path}: no M669 K6{named}: only the Hangprinter kinematics has anchors")
    moved = {letter: geometry.pop(letter) for letter in _MOVED if letter in geometry and letter not in LETTERS}
    is_old = bool(moved) and not set(machine) & set(_MOVED)
    if is_old:
        moved |= {letter: geometry.pop(letter) for letter in _MOVED if letter in geometry}
        lost.add_all(
            f"M666 {letter}: the end switch of an axis, in a version with M669 {min(moved)}" for letter in machine
        )
        machine = moved
    else:
        lost.add_all(f"M669 {letter}: M666 {letter} is read, its place since 2020" for letter in moved)
    count = int(_number(geometry, "N", 4.0))
    if not 3 <= count <= len(LETTERS):
        raise InputError(
            f"{geometry['N'][1]}: N = {count}: must be 3 to {FEW} anchors before RepRapFirmware 3.7, and 3 to "
            f"{len(LETTERS)} since"
        )
    names = LETTERS[:count]
    lines = _lines(path, geometry, machine, names, _OLD if is_old else _NEW, assumed)
    mass = _number(machine, "W", 0.0) or None
    robot = anchored_robot(path, lines, cable, assumed, mass, _stiffness(machine, assumed), below)
    limits = "IX" if "X" in machine or mass else ""
    for words, code, known in ((geometry, "M669", {*"KN", *names}), (machine, "M666", {*"RQUOSWY", *limits})):
        for letter in words:
            if letter not in known:
                beyond = f"N = {count} anchors are read" if words is geometry and letter in LETTERS else ""
                why = beyond or _WHY.get((code, letter), "a robot file has no such key")
                lost.add(f"{code} {letter}: {why}")
    return ImportedRobot(
        robot, f"RepRapFirmware's Hangprinter ({_version(geometry, machine, is_old)})", lost.all, assumed.all
    )


def _version(geometry: _Words, machine: _Words, is_old: bool) -> str:
    """Return which versions have these letters."""
    if is_old:
        return "as of 2019: M669 has what M666 has since 2020"
    if _number(geometry, "N", 4.0) > FEW or set(machine) & set("FBP"):
        return "3.7 or newer, by its anchors or M666 F, B, P"
    if "N" in geometry or set(machine) & set("AC"):
        return "3.5 or newer, by M669 N or M666 A, C"
    return "2020 to 3.4, or newer with its defaults"


_WHY: Final = {
    **{
        ("M666", letter): "teeth of the gear; an export has it, as --gear, a machine file as winch.ratio"
        for letter in "LH"
    },
    ("M666", "J"): "an export has it, as --full-steps",
    ("M666", "A"): "which places the firmware takes as reachable",
    ("M666", "C"): "torque constants of the motors",
    ("M666", "F"): "whether the firmware compensates stretch: an export says",
    ("M666", "B"): "of the compensation of stretch",
    ("M666", "P"): "of the compensation of stretch",
    ("M669", "P"): "the radius within which the firmware moves",
    ("M669", "S"): "segments of a second",
    ("M669", "T"): "the shortest segment",
    ("M666", "I"): "without X no limits are read",
    ("M669", "W"): "lengths of the mounted lines, of the file's version; a robot file has no such key",
}


def _lines(
    path: Path, geometry: _Words, machine: _Words, names: str, defaults: _Defaults, assumed: Notes
) -> dict[str, dict[str, Any]]:
    count = len(names)
    exits = {name: _anchor(path, geometry, name, k == count - 1) for k, name in enumerate(names)}
    for letter, key, what in (
        ("R", "winch.drum_radius", f"{defaults.radius} mm"),
        ("Q", "winch.build_up", f"by Q = {defaults.growth} mm"),
        ("U", "advantage", ", ".join(map(str, defaults.advantage[:count]))),
        ("O", "cables", ", ".join(map(str, defaults.cables[:count]))),
    ):
        if letter not in machine:
            assumed.add(f"lines.{key}: {what}, what {defaults.version} takes without {letter}")
        if letter in "RUO" and letter not in machine and count > FEW:
            raise InputError(f"{path}: M666 has no {letter}; with over {FEW} anchors the firmware has no default")
    radii = _list(machine, "R", count, from_mm) or [from_mm(defaults.radius, "R")] * count
    growth = _growth(machine, defaults)
    spans = _list(machine, "U", count, whole) or defaults.advantage
    cables = _list(machine, "O", count, whole) or defaults.cables
    dead = _list(machine, "Y", count, from_mm) or [0.0] * count
    low, high = _list(machine, "I", count, finite), _list(machine, "X", count, finite)
    if not high and _number(machine, "W", 0.0) > 0.0:
        high = [float(_MOST_FORCE)] * count
        assumed.add(
            f"lines.tension_limits: up to {_MOST_FORCE} N over the spans, what {defaults.version} takes without X"
        )
    lines: dict[str, dict[str, Any]] = {}
    for k, (name, at) in enumerate(exits.items()):
        length = spans[k] * math.dist((0.0, 0.0, 0.0), at) + dead[k]
        line: dict[str, Any] = {"exit_point": at, "advantage": spans[k], "cables": cables[k], "dead_length": dead[k]}
        line["winch"] = spool(radii[k], growth, length, cables[k])
        if high:
            line["tension_limits"] = ((low[k] if low else 0.0) / spans[k], high[k] / spans[k])
        lines[name] = line
    return lines


def _stiffness(machine: _Words, assumed: Notes) -> float | None:
    if "S" not in machine:
        if _number(machine, "W", 0.0) <= 0.0:
            return None
        assumed.add(f"lines.cable.axial_stiffness: {_STIFFNESS} N, what RepRapFirmware takes without S")
        return float(_STIFFNESS)
    stiffness = _number(machine, "S", 0.0)
    if stiffness <= 0.0:
        raise InputError(f"{machine['S'][1]}: S = {stiffness:g}: the stiffness of a metre of line must be over 0 N")
    return stiffness


def _growth(machine: _Words, defaults: _Defaults) -> float:
    """Return by how much the square of a spool's radius grows per length of wound cable, m."""
    text, place = machine.get("Q", (defaults.growth, ""))
    growth = from_mm(text, f"{place}: Q")
    if growth < 0.0:
        raise InputError(f"{place}: Q = {text[:60]!r}: must be 0 mm or more")
    return growth


def _anchor(path: Path, words: _Words, name: str, last: bool) -> tuple[float, ...]:
    """Return an anchor, m. The last may be its height alone, as before RepRapFirmware 3.5."""
    if name not in words:
        raise InputError(f"{path}: M669 has no {name}, an anchor as X:Y:Z in mm")
    text, place = words[name]
    parts = text.split(":")
    if len(parts) not in ((1, 3) if last else (3,)):
        raise InputError(f"{place}: {name} = {text[:60]!r}: must be X:Y:Z in mm")
    numbers = [from_mm(part, f"{place}: {name}") for part in parts]
    return (0.0, 0.0, numbers[0]) if len(numbers) == 1 else tuple(numbers)


@dataclass(frozen=True)
class RrfTarget:
    """The version of RepRapFirmware to write for.

    ``gear``: teeth of motor and spool; None: by the machine file, or none.
    """

    version: RrfVersionName
    gear: tuple[int, int] | None = None

    @property
    def anchors(self) -> str:
        """Letters of the anchors that the firmware has."""
        return LETTERS if self.is_new else LETTERS[:FEW]

    @property
    def is_new(self) -> bool:
        """Whether the firmware is 3.7 or newer: spools may have no build-up, and stretch is compensated on request."""
        return self.version == "3.7"

    def require(self, robot: Robot) -> None:
        """Raise `InputError` for more lines than it has anchors."""
        if robot.m > len(self.anchors):
            raise InputError(
                f"robot {robot.name!r} has {robot.m} lines; RepRapFirmware {self.version} has up to "
                f"{len(self.anchors)} anchors: give --firmware-version 3.7, which has {len(LETTERS)}"
            )


def rrf_config(
    robot: Robot,
    drums: Sequence[WinchDrum],
    machine: MachineSettings | None,
    full_steps: int,
    positions: Array,
    target: RrfTarget = RrfTarget("3.6"),
) -> ExportedFile:
    """Return the lines of a ``config.g``.

    *full_steps*: number of full steps in a turn of a motor; *positions* (k, 3): positions of the nozzle along the job,
    m, for which Q and R are chosen. Raises `InputError`.
    """
    require(robot, Capability.REPRAPFIRMWARE)
    target.require(robot)
    carried = (
        "name lines.name lines.exit_point lines.sheave.kind lines.advantage lines.cables lines.winch.drum_radius "
        "lines.winch.build_up lines.winch.drum_length lines.dead_length lines.winch_exit platform.mass "
        "lines.tension_limits lines.cable lines.platform_point"
    )
    notes = Notes()
    notes.add_all(lost_keys(keys_given(robot), carried))
    robot = as_points(robot)
    notes.add("lines.cable: weight, sag and creep; of all lines the least stiffness is written")
    law = law_of(robot, drums, machine, positions, target)
    fitted = "" if law.own else "; they fit the lengths of this job alone, they are no measured spools"
    notes.add(f"lines.winch: by M666 Q and R in float32 the nozzle is up to {law.error:.2g} mm off on this job{fitted}")
    text, assumed = geometry_words(robot, machine, full_steps, law, target)
    lines = robot.lines
    stiffness = min(line.cable.stiffness for line in lines)
    dead = _joined(to_mm(dead_length(line)) for line in lines)
    text += f"M666 W{_joined([robot.platform.mass])} S{_joined([stiffness])} Y{dead}\n"
    forces = [[line.tension_limits[k] * line.advantage for line in lines] for k in (0, 1)]
    text += f"M666 I{_joined(forces[0])} X{_joined(forces[1])}{' F1' if target.is_new else ''}\n"
    return ExportedFile(text, notes.all, assumed)


def law_of(
    robot: Robot, drums: Sequence[WinchDrum], machine: MachineSettings | None, positions: Array, target: RrfTarget
) -> SpoolLaw:
    """Return the spool parameters Q and R (M666) for a job's *positions* (k, 3), m. Raises `InputError`."""
    return spool_law(robot, drums, positions, _build_up(robot, drums, machine), may_be_zero=target.is_new)


def geometry_words(
    robot: Robot, machine: MachineSettings | None, full_steps: int, law: SpoolLaw, target: RrfTarget
) -> tuple[str, tuple[str, ...]]:
    """Return M669 and the spool settings of M666, and the assumed values."""
    names, lines = target.anchors[: robot.m], robot.lines
    anchors = " ".join(f"{n}{_joined(map(to_mm, line.exit_point))}" for n, line in zip(names, lines, strict=True))
    teeth, assumed = _teeth(machine) if target.gear is None else (target.gear, ())
    text = "".join(f"; {name} is line {line.name!r}\n" for name, line in zip(names, lines, strict=True))
    text += f"M669 K6 N{robot.m}\nM669 {anchors} P{1e3 * _reach(robot):.0f}\n"
    text += f"M666 Q{_joined([law.growth])} R{_joined(_shortest(radius) for radius in law.radii)}\n"
    text += f"M666 U{_joined(line.advantage for line in lines)} O{_joined(line.cables for line in lines)}\n"
    text += (
        f"M666 L{_joined([teeth[0]] * robot.m)} H{_joined([teeth[1]] * robot.m)} J{_joined([full_steps] * robot.m)}\n"
    )
    return text, assumed


def _shortest(millimetres: float) -> str:
    """Return a radius as it was read, without the last digits of a product."""
    return to_mm(float(f"{1e-3 * millimetres:.15g}"))


def _build_up(robot: Robot, drums: Sequence[WinchDrum], machine: MachineSettings | None) -> float | None:
    """Return by how much the square of the radius grows per length of wound cable, mm; None where lines differ."""
    own = [drum_of(line) or drum for drum, line in zip(drums, robot.lines, strict=True)]
    if machine is None or all(drum.build_up > 0.0 for drum in own):
        pairs = zip(own, robot.lines, strict=True)
        squares = [2.0 * drum.build_up * drum.radius**2 / line.cables for drum, line in pairs]
        if max(squares) - min(squares) > 1e-6 * max(squares):
            return None
        return float(f"{1e3 * squares[0]:.12g}")  # the number that was read, not its last digits
    diameters = {line.cable.diameter for line in robot.lines}
    diameter = diameters.pop()
    if diameters:
        return None
    assert diameter is not None  # a coil needs it
    return 1e3 * machine.winch.pitch * diameter / (math.pi * machine.winch.width)


def _teeth(machine: MachineSettings | None) -> tuple[tuple[int, int], tuple[str, ...]]:
    """Return the teeth of motor and spool for the machine's ratio."""
    if machine is None:
        return (1, 1), ("motors turn the spools without a gear: no machine file says otherwise",)
    ratio = machine.winch.ratio
    for motor in range(1, 1001):
        if abs(motor * ratio - round(motor * ratio)) < 1e-9 * ratio:
            return (motor, round(motor * ratio)), ()
    return (1000, round(1000 * ratio)), (f"gear ratio {ratio:g} as teeth 1000 to {round(1000 * ratio)}",)


def _reach(robot: Robot) -> float:
    """Return the radius of the frame's box about the origin, m."""
    return max(math.hypot(x, y) for x in _ends(robot, 0) for y in _ends(robot, 1))


def _ends(robot: Robot, axis: int) -> tuple[float, float]:
    return robot.scene.frame_min[axis], robot.scene.frame_max[axis]


def _joined(values: Iterable[float | str]) -> str:
    """Return numbers as a list of the firmware, without exponents, whose E is a letter of its own there."""
    return ":".join(format(Decimal(str(value)), "f") for value in values)


def _commands(path: Path, lost: Notes) -> dict[str, _Words]:
    """Return the words of all M665, M666 and M669, with their places; later ones replace earlier ones, as there.

    Raises `InputError` for one that stands under a condition or holds an expression.
    """
    found: dict[str, _Words] = {"M665": {}, "M666": {}, "M669": {}}
    block: tuple[int, str] | None = None  # a condition's depth and word
    for number, text in text_lines(path, MAX_BYTES, "config.g", indented=True):
        line, place = text.expandtabs(4), f"{path}, line {number}"
        depth, line = len(line) - len(line.lstrip()), line.strip()
        if _LINE_NUMBER.match(line):
            line = _CHECKSUM.sub("", _LINE_NUMBER.sub("", line), 1)
        if block is not None and depth <= block[0] and not line.startswith(";"):
            block = None
        if (word := _META.match(line)) is not None:
            block = block or (depth, word[0]) if word[0] in _BLOCKS else block
            continue
        for bare in _split(line):
            head = _HEAD.match(bare)
            if head is None:
                break  # the firmware takes the rest of the line for a bad command
            code, rest = head[1].upper(), head[2]
            if code in _ELSEWHERE:
                lost.add(f"{bare[:60]}: {_ELSEWHERE[code]}")
            if code in _WITH_TEXT and '"' not in rest:
                break
            if code in found:
                found[code] |= _words(bare, code, rest, place, "" if block is None else block[1])
    return found


def _split(line: str) -> list[str]:
    """Return the commands of a line as the firmware finds them: each begins at G or M, also without a space before.

    Not in quotes, in braces, or after an apostrophe (a small axis letter). A semicolon ends the line.
    """
    starts, is_quoted, depth = [0], False, 0
    for at, each in enumerate(line):
        is_quoted ^= each == '"'
        if each == ";" and not is_quoted:
            line = line[:at]
            break
        depth = max(0, depth + (each == "{") - (each == "}")) if not is_quoted else depth
        if each in "GMgm" and at and not (is_quoted or depth or line[at - 1] == "'"):
            starts.append(at)
    return [line[start:end].strip() for start, end in pairwise([*starts, len(line)])]


def _words(bare: str, code: str, rest: str, place: str, block: str) -> _Words:
    """Return the words of a command. Raises `InputError` for one under a condition *block*, or with an expression."""
    if block:
        raise InputError(
            f"{place}: {code} stands under {block!r}: give a config.g without conditions, with the values that hold"
        )
    if "{" in rest:
        raise InputError(f"{place}: {bare[:60]!r}: an expression; write its value, a number in mm")
    words = _WORD.findall(rest)
    if "".join(letter + value for letter, value in words) != "".join(rest.split()) or not all(v for _, v in words):
        raise InputError(f"{place}: {bare[:60]!r}: must be letters, each with its numbers")
    return {letter.upper(): (value, place) for letter, value in words}


def _number(words: _Words, letter: str, default: float) -> float:
    if letter not in words:
        return default
    text, place = words[letter]
    return finite(text, f"{place}: {letter}")


def _list(words: _Words, letter: str, count: int, read: Callable[[str, str], Any]) -> list[Any]:
    """Return one value for each anchor; an empty list without the letter. Raises `InputError` for too few."""
    if letter not in words:
        return []
    text, place = words[letter]
    parts = text.split(":")
    if len(parts) < count:
        raise InputError(
            f"{place}: {letter} = {text[:60]!r}: has {len(parts)} values; give one for each of the {count} anchors"
        )
    return [read(part, f"{place}: {letter}") for part in parts[:count]]
