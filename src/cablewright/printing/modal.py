"""Interpreter of G-code: the modal state of a printer's controller, and the effect of each word on it.

Choices where dialects differ:

* G90 and G91 apply to E as well until the first M82 or M83, as in RepRap firmwares.
* I and J are relative to the start of the arc; arcs lie in the XY plane, G18 and G19 are rejected.
* P of G2 and G3 is the number of turns, of which the last may be incomplete: P1 is the arc without P.
* P of G4 is in milliseconds, S in seconds; S applies where both are given.
* G92 shifts the coordinates of the file, never the machine; without words it sets all of them to zero.
* G28 travels to the machine's zero along the named axes (all, if none is named) and removes their shift.
* Every file starts at the machine's zero, in absolute millimetres.
* A line that only names axes repeats the last of G0 to G3; F alone needs no motion and holds from there.
* Accelerations, jerks and macros of a firmware are not interpreted. An unknown code and the words after it are counted
  and ignored; codes that would change the path are rejected.
"""

from __future__ import annotations

import math
import re
import struct
from array import array
from typing import Final, NoReturn

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.printing.annotations import Annotations
from cablewright.printing.arc import ArcError, centre_from_offset, centre_from_radius, piece_count, pieces, swept_angle
from cablewright.printing.gcode_words import MACRO, NUMBER, WordError, as_number, bare_text, code_of, split, why_unread
from cablewright.printing.row_changes import Changes

MAX_COORDINATE: Final = 1e6  # m, distance from the origin
MAX_MOVES: Final = 20_000_000  # about 2 GB of toolpath
MAX_DWELL: Final = 1e6  # s, of one G4
MAX_TURNS: Final = 1000  # of one arc
MAX_UNKNOWN: Final = 1000  # different unknown words counted by name; the others are counted together
COLUMNS: Final = 5  # of a row: x, y, z (m, machine), extrusion (m), feed (m/s)

_ROW: Final = struct.Struct(f"={COLUMNS}d")
_Word = bytes | float | None

_SLOWEST, _FASTEST = 1e-9, 1e6  # m/s
_FARTHEST_SQUARED = MAX_COORDINATE**2
_SETTINGS = frozenset({"G17", "G20", "G21", "G90", "G91", "G91.1", "M82", "M83"})
_LETTERS = {
    "": "F",
    "G0": "XYZEF",
    "G1": "XYZEF",
    "G2": "XYZEFIJPR",
    "G3": "XYZEFIJPR",
    "G4": "PS",
    "G28": "XYZ",
    "G92": "XYZE",
}
_REFUSED = {
    "G5": "splines are not read; G0 to G3 are",
    "G5.1": "splines are not read; G0 to G3 are",
    "G18": "arcs are read in the XY plane (G17) only",
    "G19": "arcs are read in the XY plane (G17) only",
    "G51": "scaling inside the file is not read; a job has a scale",
    "G68": "rotation inside the file is not read",
    "G90.1": "absolute arc centres are not read; I and J are measured from the start of the arc",
    "G92.1": "G92 is read with coordinates or bare",
    "G93": "inverse-time feed is not read; F is a speed",
}
_FREE_TEXT = frozenset({"M0", "M1", "M16", "M23", "M28", "M30", "M32", "M117", "M118", "M486", "M928"})
_BESIDE = frozenset(f"G{n}" for n in (40, 43, 49, *range(54, 60), 61, 64, 80, 94, 98, 99)) | frozenset(
    f"M{n}" for n in (*range(3, 10), 48, 49)
)
"""Codes of machine tools that own no F: it is the feed of their line."""
_LABELS = frozenset({"EXCLUDE_OBJECT_DEFINE", "EXCLUDE_OBJECT_START", "EXCLUDE_OBJECT_END"})
_SWITCHES = {
    "M101": ("M101", True), "M102": ("M101", False), "M103": ("M101", False),
    "M106": ("M106", True), "M107": ("M106", False),
    "M3": ("M3", True), "M4": ("M3", True), "M5": ("M3", False),
}  # fmt: skip
"""What may switch a pump or an extruder: the name of the switch, and whether it is on then."""


def _straight(extruder: str) -> re.Pattern[bytes]:
    """Return the pattern of nine of ten lines: G0 or G1 with axes in the usual order and capitals.

    Groups: 0 or 1, F, X, Y, Z, E, F.
    """
    pattern = (
        r"G0?([01])(?:[ \t]*F(#))?(?:[ \t]*X(#))?(?:[ \t]*Y(#))?(?:[ \t]*Z(#))?(?:[ \t]*E(#))?(?:[ \t]*F(#))?"
        r"[ \t\r]*(?:;.*)?"
    )
    return re.compile(pattern.replace("E", extruder).replace("#", NUMBER).encode(), re.DOTALL)


class Controller:
    """Interprets lines in order and records straight moves: `COLUMNS` floats each in `rows`, a line number in `lines`.

    The rows at which something changes: ``rapid`` (1 from a G0 or G28 on, 0 from a G1 to G3 on), ``homing`` (1 in
    G28), ``switches`` (1 while on). ``dwells``: (row, s); ``unknown``: ignored words and their counts.
    """

    def __init__(self, origin: str, arc_step: float, arc_error: float, extruder: str = "E") -> None:
        """``origin`` names the file in messages; pieces of arcs are at most ``arc_step`` long, ``arc_error`` off (m).

        ``extruder`` is the letter of the axis that extrudes.
        """
        self.rows = array("d")
        self.lines = array("i")
        self.notes = Annotations()
        self.rapid = Changes()
        self.homing = Changes()
        self.switches = {name: Changes() for name, _ in _SWITCHES.values()}
        self.dwells: list[tuple[int, float]] = []
        self.unknown: dict[str, int] = {}
        self._origin = origin
        self._arc_step = arc_step
        self._arc_error = arc_error
        self._spelling = {} if extruder == "E" else {extruder: "E", "E": extruder}  # both ways
        self._pattern = _straight(extruder)
        self._unit = 1e-3  # m
        self._relative = self._relative_e = False
        self._e_follows_axes = True  # until M82 or M83
        self._x = self._y = self._z = 0.0  # m, machine
        self._shift = [0.0, 0.0, 0.0]  # m, machine minus written
        self._e = 0.0  # m, written
        self._feed = math.inf  # m/s; without F only the job's limits apply
        self._motion = ""
        self._number = 0
        self._line = b""
        self._unterminated = False

    def run(self, lines: list[bytes], first_number: int, unterminated: bool = False) -> None:
        """Interpret G-code ``lines`` from line ``first_number`` on; ``unterminated``: no line end follows them.

        Raises `InputError` with file, line number, text and what is allowed.
        """
        self._unterminated = unterminated
        straight = self._pattern.fullmatch
        for number, line in enumerate(lines, first_number):
            self._number = number
            self._line = line
            found = straight(line)
            if found is None:
                self._interpret(line)
                continue
            code, early, x, y, z, e, feed = found.groups()
            if early is not None and feed is not None:
                self._interpret(line)  # rejects two F
            try:
                self._straight("G1" if code == b"1" else "G0", x, y, z, e, feed or early)
            except ValueError:
                self._interpret(line)  # rejects the word that is no number
        if len(self.lines) > MAX_MOVES:
            self._refuse(f"more than {MAX_MOVES} moves, the most a file may make")

    def _interpret(self, line: bytes) -> None:
        """Interpret any line."""
        try:
            begin = line[:1]
            if begin in (b";", b"(") and (unknown := self.notes.read(line, len(self.lines))):
                self._count(f";TYPE:{unknown}")
            if begin != b";":
                self._obey(bare_text(line))
        except WordError as error:
            cut = error.cut and self._unterminated
            self._refuse("the line ends inside a word; the file looks truncated" if cut else str(error))
        except ArcError as error:
            self._refuse(str(error))

    def _obey(self, text: str) -> None:
        """Apply the settings of a line, then its one action. Raises `WordError`, `ArcError`."""
        if (macro := MACRO.match(text)) is not None:
            if macro[0] in _LABELS:
                self.notes.read_label(macro[0], self._line, len(self.lines))
            else:
                self._count(macro[0])
            return
        action, foreign = "", False  # the words after an unknown code belong to it
        taken = []
        words, rest = split(text)
        for letter, number in words:
            if not ((letter == "T" and not foreign) or (letter in "GM" and (number or not foreign))):
                taken.append((self._spelling.get(letter, letter), number))
                continue
            code = letter + number if letter == "T" else code_of(letter, number)
            if code in _LETTERS:
                if action:
                    raise WordError(f"{action} and {code} in one line; one of them is allowed")
                action = code
            elif code in _SETTINGS:
                self._set(code)
            else:
                self._pass(code, words)
                foreign = True
            if code in _FREE_TEXT:
                break
        if action or not foreign:
            if rest:
                raise WordError(why_unread(words, rest))
            self._act(action, taken)
        else:
            self._act("", _feeds_of_line(words))

    def _pass(self, code: str, words: list[tuple[str, str]]) -> None:
        """Record a code that moves nothing, of a line of these ``words``. Raises `WordError` where it is rejected."""
        if code in _REFUSED:
            raise WordError(_REFUSED[code])
        if code == "M486":
            self.notes.read_m486(self._line, len(self.lines))
            return
        self._count(code)
        if code == "M200" and (diameter := dict(words).get("D")):
            self.notes.settings["volumetric"] = float(bool(diameter.strip("+-.0")))  # whether E is in mm^3
        if code in _SWITCHES:
            name, on = _SWITCHES[code]
            stopped = any(letter == "S" and number and not number.strip("+-.0") for letter, number in words)
            self.switches[name].set(len(self.lines), on and not stopped)

    def _act(self, action: str, taken: list[tuple[str, str]]) -> None:
        """Execute ``action`` with the words of its line, or repeat the last motion where the line only names axes."""
        if not action and any(letter in "XYZEIJR" for letter, _ in taken):
            action = self._motion
            if not action:
                raise WordError("axes without a G code before any of G0 to G3")
        words: dict[str, float] = {}
        for letter, number in taken:
            if action in ("G2", "G3") and letter == "K":
                raise WordError("K of an arc is not read; X, Y, Z, E, F, P with I and J, or with R, are allowed")
            if letter in words:
                raise WordError(f"{self._spelling.get(letter, letter)} is given twice; once is allowed")
            if letter in _LETTERS.get(action, ""):
                words[letter] = 0.0 if action == "G28" else as_number(letter, number)
            else:
                self._count(self._spelling.get(letter, letter))
        match action:
            case "" | "G0" | "G1":
                self._straight(action or self._motion, *(words.get(letter) for letter in "XYZEF"))
            case "G2" | "G3":
                self._arc(words, action)
            case "G4":
                self._wait(words)
            case "G28":
                self._home(words)
            case "G92":
                self._rename(words if taken else dict.fromkeys("XYZE", 0.0))

    def _set(self, code: str) -> None:
        match code:
            case "G20" | "G21":
                self._unit = 0.0254 if code == "G20" else 1e-3
            case "G90" | "G91":
                self._relative = code == "G91"
                if self._e_follows_axes:
                    self._relative_e = self._relative
            case "M82" | "M83":
                self._e_follows_axes = False
                self._relative_e = code == "M83"

    def _straight(self, code: str, x: _Word, y: _Word, z: _Word, e: _Word, feed: _Word) -> None:
        """Move in a line (file units). Raises `ValueError` for a text that is no number, `InputError` out of range."""
        unit = self._unit
        if code != self._motion:
            self._move_by(code)
        if feed is not None:
            self._set_feed(float(feed))
        if x is not None:
            self._x = float(x) * unit + (self._x if self._relative else self._shift[0])
        if y is not None:
            self._y = float(y) * unit + (self._y if self._relative else self._shift[1])
        if z is not None:
            self._z = float(z) * unit + (self._z if self._relative else self._shift[2])
        if e is not None:
            self._add(self._extrude(float(e)))
        elif x is not None or y is not None or z is not None:
            self._add(0.0)

    def _move_by(self, code: str) -> None:
        """Let ``code``, one of G0 to G3, be the motion of the rows that follow."""
        self._motion = code
        self.rapid.set(len(self.lines), code == "G0")

    def _add(self, extrusion: float) -> None:
        """Record a move that ends at the current position."""
        x, y, z = self._x, self._y, self._z
        if not x * x + y * y + z * z <= _FARTHEST_SQUARED:  # nan and inf too
            self._refuse(f"farther than {MAX_COORDINATE:.0f} m from the origin")
        self.rows.frombytes(_ROW.pack(x, y, z, extrusion, self._feed))
        self.lines.append(self._number)

    def _extrude(self, written: float) -> float:
        """Return the extrusion (m) of an E word."""
        value = written * self._unit
        if self._relative_e:
            self._e += value
            return value
        grown = value - self._e
        self._e = value
        return grown

    def _set_feed(self, written: float) -> None:
        speed = written * self._unit / 60
        if not _SLOWEST <= speed <= _FASTEST:
            self._refuse(f"F must be above 0 and no more than {_FASTEST:.0f} m/s; it is in file units per minute")
        self._feed = speed

    def _arc(self, words: dict[str, float], action: str) -> None:
        """Move along an arc or a helix about Z. Raises `ArcError`."""
        unit = self._unit
        if "F" in words:
            self._set_feed(words["F"])
        start = (self._x, self._y, self._z)
        x, y, z = (
            words[axis] * unit + (at if self._relative else shift) if axis in words else at
            for axis, at, shift in zip("XYZ", start, self._shift, strict=True)
        )
        for letter, value in zip("XYZIJR", (x, y, z, *(words.get(c, 0.0) * unit for c in "IJR")), strict=True):
            if abs(value) > MAX_COORDINATE:
                raise ArcError(f"{letter} is out of range; at most {MAX_COORDINATE:.0f} m is allowed")
        clockwise = action == "G2"
        if ("R" in words) == ("I" in words or "J" in words):
            raise ArcError("an arc needs either R, or I and J")
        if "R" in words:
            centre = centre_from_radius(start[:2], (x, y), words["R"] * unit, clockwise)
        else:
            centre = centre_from_offset(start[:2], (x, y), (words.get("I", 0.0) * unit, words.get("J", 0.0) * unit))
        sweep = swept_angle(start[:2], (x, y), centre, clockwise) + _further_turns(words.get("P", 1.0), clockwise)
        count = piece_count(math.dist(start[:2], centre), sweep, z - start[2], self._arc_step, self._arc_error)
        if len(self.lines) + count > MAX_MOVES:
            raise ArcError(f"more than {MAX_MOVES} moves, the most a file may make")
        self._move_by(action)
        rows = np.empty((count, COLUMNS))
        rows[:, :3] = pieces(start, (x, y, z), centre, sweep, count)
        rows[:, 3] = self._extrude(words["E"]) / count if "E" in words else 0.0
        rows[:, 4] = self._feed
        self.rows.frombytes(rows.tobytes())
        self.lines.extend(array("i", [self._number]) * count)
        self._x, self._y, self._z = x, y, z

    def _wait(self, words: dict[str, float]) -> None:
        seconds = words["S"] if "S" in words else words.get("P", 0.0) * 1e-3
        if not 0 <= seconds <= MAX_DWELL:
            raise WordError(f"a dwell must last from 0 to {MAX_DWELL:.0f} s")
        if seconds > 0:
            self.dwells.append((len(self.lines), seconds))
            self._add(0.0)

    def _home(self, named: dict[str, float]) -> None:
        place = [self._x, self._y, self._z]
        for at, axis in enumerate("XYZ"):
            if axis in named or not named:
                place[at] = self._shift[at] = 0.0
        if place != [self._x, self._y, self._z]:
            self._x, self._y, self._z = place
            self.homing.set(len(self.lines), 1)
            self._add(0.0)
            self.homing.set(len(self.lines), 0)

    def _rename(self, words: dict[str, float]) -> None:
        """Give the current position the coordinates of ``words`` (G92)."""
        for at, (axis, machine) in enumerate(zip("XYZ", (self._x, self._y, self._z), strict=True)):
            if axis in words:
                self._shift[at] = machine - words[axis] * self._unit
        if "E" in words:
            self._e = words["E"] * self._unit

    def _count(self, word: str) -> None:
        word = word[:32]
        if word not in self.unknown and len(self.unknown) >= MAX_UNKNOWN:
            word = "(others)"
        self.unknown[word] = self.unknown.get(word, 0) + 1

    def _refuse(self, reason: str) -> NoReturn:
        """Raise the `InputError` of the current line."""
        text = self._line.decode("utf-8", "replace").strip()
        shown = repr(text if len(text) <= 60 else text[:57] + "...")
        raise InputError(f"{self._origin}, line {self._number}: {shown}: {reason}")


def _feeds_of_line(words: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the F words before the first code that owns the words after it."""
    found = []
    for letter, number in words:
        if letter in "GM" and code_of(letter, number) not in _BESIDE | _SETTINGS:
            break
        if letter == "F":
            found.append((letter, number))
    return found


def _further_turns(turns: float, clockwise: bool) -> float:
    """Return the angle (rad) by which an arc of so many ``turns`` (P) is longer than one of P1. Raises `ArcError`."""
    if not 1 <= turns <= MAX_TURNS or turns != int(turns):
        raise ArcError(f"P is the number of turns of an arc; whole numbers from 1 to {MAX_TURNS} are allowed")
    return (turns - 1) * (-math.tau if clockwise else math.tau)
