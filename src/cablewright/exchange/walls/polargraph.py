"""Import of polargraphs: settings of Marlin (``Configuration.h`` or M665) and of Makelangelo (M101). Lengths are mm.

Both have the belts' ends in the upper corners of the area that they draw on, x to the right, y up the wall.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.millimetres import from_mm
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.walls.two_belts import Wall, wall_robot
from cablewright.exchange.xml_input import finite
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.validation import shown

MAX_BYTES: Final = 1 << 20

CARRIED: Final = (
    Mapped("M665 L, R, T; X_MIN_POS, X_MAX_POS, Y_MAX_POS", "lines.exit_point", "eyelets, in the upper corners"),
    Mapped("M665 B; Y_MIN_POS", "scene.frame_min", "the lowest place of the pen"),
    Mapped("M665 H; POLARGRAPH_MAX_BELT_LEN", "lines.winch.capacity"),
    Mapped("M203 X, Y; DEFAULT_MAX_FEEDRATE", "lines.winch.max_speed", "mm/s"),
)
OF_MAKELANGELO: Final = (
    Mapped("M101 A0 B, T", "lines.exit_point", "x of the left and the right eyelet"),
    Mapped("M101 A1 T, B", "lines.exit_point, scene.frame_min", "y of both eyelets, and the lowest place of the pen"),
)

_WORD = re.compile(r"([A-Z])\s*([-+.0-9]+)")
_DEFINE = re.compile(r"\s*#\s*define\s+(\w+)[ \t]+(.+)")
_ENABLED = re.compile(r"\s*#\s*define\s+(\w+)\s*(?://.*|/\*.*)?")
_CONDITION = re.compile(r"\s*#\s*(if|ifdef|ifndef|elif|else|endif)\b\s*(.*)")
_SWITCHES = re.compile(r"(!?)\s*(ENABLED|DISABLED|defined|ANY|EITHER|ALL|BOTH)\s*\(([\w\s,]+)\)")
_COMMENT = re.compile(r"//|/\*")
_FUNCTIONS: Final[Mapping[str, Callable[[float], float]]] = {"sq": lambda x: x * x, "sqrt": math.sqrt}
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*")
_MOST_ROUNDS: Final = 20  # of names in texts of names
_LONGEST_FORMULA: Final = 4000
_LARGEST_INTEGER: Final = 1 << 63
_INCH: Final = 25.4  # mm
_Words = dict[str, tuple[str, str]]


def read_polargraph(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of Marlin's ``Configuration.h`` with POLARGRAPH, or of its settings, as M503 lists them.

    Raises `InputError`.
    """
    lost, assumed = Notes(), Notes()
    if b"#define" in read_bytes(path, MAX_BYTES, "polargraph"):
        defines = _Defines(path)
        left, right, top, low = map(defines.metres, ("X_MIN_POS", "X_MAX_POS", "Y_MAX_POS", "Y_MIN_POS"))
        belt = defines.metres("POLARGRAPH_MAX_BELT_LEN") if "POLARGRAPH_MAX_BELT_LEN" in defines.texts else 0.0
        speeds, version = defines.speeds(), "Configuration.h; M665 and M203 stored in the machine replace it"
        lost.add("Configuration.h: all but the drawing area, the belts' length and their speed")
    else:
        codes = _codes(path, ("M665", "M203"))
        left, right, top, low = (_metres(path, codes["M665"], "M665", letter) for letter in "LRTB")
        belt = _metres(path, codes["M665"], "M665", "H") if "H" in codes["M665"] else 0.0
        speeds = {k: _metres(path, codes["M203"], "M203", axis) for k, axis in enumerate("XY") if axis in codes["M203"]}
        version = "M665"
        if "S" in codes["M665"]:
            lost.add("M665 S: segments of a second; an export has points of its own")
    winches = [{"max_speed": speeds[k]} if speeds.get(k) else {} for k in (0, 1)]
    if belt > 0.0:
        winches = [winch | {"capacity": belt} for winch in winches]
    wall = Wall((left, top), (right, top), low, winches=(winches[0], winches[1]))
    robot = wall_robot(path, wall, "A polargraph on two belts", cable, assumed)
    return ImportedRobot(robot, f"Marlin's polargraph ({version})", lost.all, assumed.all)


def read_makelangelo(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a Makelangelo by the commands with which its software sets limits. Raises `InputError`."""
    limits: dict[str, _Words] = {}
    lost, assumed = Notes(), Notes()
    for number, text in text_lines(path, MAX_BYTES, "Makelangelo"):
        bare = text.split(";", 1)[0].strip()
        code, _, rest = bare.partition(" ")
        words = _words(rest.upper(), f"{path}, line {number}", is_inch=False)
        axis = words.get("A", ("", ""))[0]
        if code.upper() == "G20":
            raise InputError(f"{path}, line {number}: {bare[:40]}: inches; give the limits in mm, with G21 or without")
        if code.upper() == "M101" and axis in ("0", "1"):
            limits[axis] = words
        elif bare:
            lost.add(f"{bare[:40]}: {'the pen' if axis == '2' else 'a robot file has no such thing'}")
    for axis in "01":
        if axis not in limits:
            raise InputError(f"{path}: has no M101 A{axis} T... B..., the limits of {'xy'[int(axis)]} in mm")
    (left, right), (low, top) = (
        [_metres(path, limits[axis], f"M101 A{axis}", letter) for letter in "BT"] for axis in "01"
    )
    robot = wall_robot(path, Wall((left, top), (right, top), low), "A Makelangelo on two belts", cable, assumed)
    return ImportedRobot(robot, "Makelangelo's own firmware (M101, before it was Marlin)", lost.all, assumed.all)


def _metres(path: Path, words: _Words, code: str, letter: str) -> float:
    if letter not in words:
        raise InputError(f"{path}: {code} has no {letter}, mm")
    text, place = words[letter]
    return from_mm(text, f"{place}: {code} {letter}")


def _codes(path: Path, codes: tuple[str, ...]) -> dict[str, _Words]:
    """Return the words of codes, the last of each letter; an ``echo:`` before a code is what M503 prints."""
    found: dict[str, _Words] = {code: {} for code in codes}
    is_inch = False
    for number, text in text_lines(path, MAX_BYTES, "polargraph"):
        bare = text.split(";", 1)[0].upper().removeprefix("ECHO:").strip()
        code, _, rest = bare.partition(" ")
        is_inch = code == "G20" or (is_inch and code != "G21")
        if code in found:
            found[code] |= _words(rest, f"{path}, line {number}", is_inch)
    return found


def _words(text: str, place: str, is_inch: bool) -> _Words:
    """Return the words of a command with their *place*, those in inches as mm. Raises `InputError`."""
    words = dict(_WORD.findall(text))
    if is_inch:
        words = {word: repr(_INCH * finite(value, f"{place}: {word}")) for word, value in words.items()}
    return {word: (value, place) for word, value in words.items()}


@dataclass(frozen=True)
class _Condition:
    """An #if that is open. ``holds``: what follows it; ``taken``: whether a branch has held yet; None: not known."""

    text: str
    holds: bool | None
    taken: bool | None


class _Defines:
    """The numbers that a ``Configuration.h`` defines, by their names; some are sums of others."""

    def __init__(self, path: Path) -> None:
        self.path, self.texts = path, {}
        self.places: dict[str, str] = {}
        self.unclear: dict[str, str] = {}  # names under a condition that is not known, and the condition
        conditions: list[_Condition] = []
        for number, text in enumerate(
            read_bytes(path, MAX_BYTES, "Configuration.h").decode("utf-8", "replace").splitlines(), 1
        ):
            if match := _CONDITION.fullmatch(text):
                self._enter(conditions, match[1], _COMMENT.split(match[2], maxsplit=1)[0].strip(), number)
                continue
            given = _ENABLED.fullmatch(text) or _DEFINE.fullmatch(text)
            if given is None or any(each.holds is False for each in conditions):
                continue
            self.texts[given[1]] = _COMMENT.split(given[2], maxsplit=1)[0].strip() if given.re is _DEFINE else ""
            self.places[given[1]] = f"{path}, line {number}: {given[1]}"
            self.unclear.pop(given[1], None)
            if (open_one := next((each for each in conditions if each.holds is None), None)) is not None:
                self.unclear[given[1]] = open_one.text
        if conditions:
            raise InputError(f"{path}: #{conditions[-1].text} has no #endif: is the file whole?")
        if "POLARGRAPH" not in self.texts:
            raise InputError(f"{path}: POLARGRAPH is not defined: another kinematics of Marlin")

    def _enter(self, conditions: list[_Condition], word: str, text: str, number: int) -> None:
        """Follow a directive. Raises `InputError` for one without its #if."""
        if word in ("if", "ifdef", "ifndef"):
            asked = text if word == "if" else f"{'!' if word == 'ifndef' else ''}defined({text})"
            holds = self._holds(asked)
            conditions.append(_Condition(f"{word} {text}"[:60], holds, holds))
            if len(conditions) > _MOST_ROUNDS:
                raise InputError(f"{self.path}, line {number}: over {_MOST_ROUNDS} conditions, one in another")
            return
        if not conditions:
            raise InputError(f"{self.path}, line {number}: #{word} without an #if: is the file whole?")
        before = conditions.pop()
        if word != "endif":
            own = True if word == "else" else self._holds(text)
            holds = False if before.taken else own if before.taken is False else None if own is not False else False
            taken = True if True in (before.taken, holds) else None if None in (before.taken, holds) else False
            conditions.append(_Condition(f"{word} {text}".strip()[:60], holds, taken))

    def _holds(self, text: str) -> bool | None:
        """Return whether switches are defined; None for any other condition."""
        match = _SWITCHES.fullmatch(text)
        if match is None:
            return {"1": True, "0": False}.get(text)
        known = [name.strip() in self.texts for name in match[3].split(",")]
        holds = any(known) if match[2] in ("ANY", "EITHER") else all(known)
        if match[2] == "DISABLED":
            holds = not any(known)
        return holds is not bool(match[1])

    def metres(self, name: str) -> float:
        """Return a length of the settings, m. Raises `InputError`."""
        return 1e-3 * self._number(self._text(name), name)

    def speeds(self) -> dict[int, float]:
        """Return the largest speed of each belt, m/s, by its index: 0 is the left one."""
        text = self.texts.get("DEFAULT_MAX_FEEDRATE", "").strip("{} ")
        parts = text.split(",")[:2] if text else []
        return {k: 1e-3 * self._number(part, "DEFAULT_MAX_FEEDRATE") for k, part in enumerate(parts)}

    def _text(self, name: str) -> str:
        if name not in self.texts:
            raise InputError(f"{self.path}: has no #define {name}, mm")
        if name in self.unclear:
            raise InputError(f"{self.places[name]} stands under #{self.unclear[name]}: give it without that condition")
        return self.texts[name]

    def _number(self, formula: str, name: str) -> float:
        """Return the value of a formula in which names are replaced by their texts, as by the preprocessor of C."""
        try:
            text = formula
            for _ in range(_MOST_ROUNDS):
                text = _NAME.sub(lambda match: match[0] if match[0] in _FUNCTIONS else self._text(match[0]), text)
                if len(text) > _LONGEST_FORMULA:
                    raise OverflowError
            with warnings.catch_warnings():  # of a text as 1and, which is rejected below
                warnings.simplefilter("ignore", SyntaxWarning)
                value = float(_value(ast.parse(text.strip(), mode="eval").body))
        except (SyntaxError, ArithmeticError, KeyError, ValueError, RecursionError, MemoryError):
            value = math.nan
        if not math.isfinite(value):
            raise InputError(
                f"{self.places[name]} = {shown(formula)}: must be a number in mm, or a formula of such numbers"
            )
        return value


def _value(node: Any) -> float:
    """Return the value of an expression of numbers and + - * /, an `int` of integers as in C. Raises `KeyError`."""
    found: float
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        found = node.value
    elif isinstance(node, ast.BinOp):
        found = _OPERATORS[type(node.op)](_value(node.left), _value(node.right))
    elif isinstance(node, ast.UnaryOp):
        found = _OPERATORS[type(node.op)](_value(node.operand))
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1:
        found = _FUNCTIONS[node.func.id](_value(node.args[0]))
    else:
        raise KeyError(type(node).__name__)
    if abs(found) >= _LARGEST_INTEGER and isinstance(found, int):
        raise OverflowError
    return found


def _quotient(a: float, b: float) -> float:
    """Return a / b. Of two integers it is rounded towards 0, as in C."""
    if isinstance(a, int) and isinstance(b, int):
        return abs(a) // abs(b) * (1 if (a < 0) is (b < 0) else -1)
    return a / b


_OPERATORS: Final[Mapping[type, Callable[..., float]]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: _quotient,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
