"""Interpreter of G-code: the modal state of a printer's controller, and the effect of each word on it.

Choices where dialects differ:

* G90 and G91 apply to E as well until the first M82 or M83, as in RepRap firmwares.
* I and J are relative to the start of the arc; arcs lie in the XY plane, G18 and G19 are rejected.
* P of G2 and G3 is the number of turns, of which the last may be incomplete: P1 is the arc without P.
* P of G4 is in milliseconds, S in seconds; S applies where both are given.
* G92 shifts the coordinates of the file, never the machine; without words it sets all of them to zero.
* G28 travels to the machine's zero along the named axes (all, if none is named) and removes their shift.
* Every file starts at the machine's zero, in absolute millimetres.
* A line with axes but no motion of its own repeats the last of G0 to G3, beside codes such as G43 and M8 too
  (`gcode_words.BESIDE`); F alone needs no motion and holds from there.
* M120 and M121 stack modes, as in RepRapFirmware: units, G90 and G91, M82 and M83, F. M121 without M120 is ignored. M72
  restores those of M70 or M73, and the spindle, as in LinuxCNC. RESTORE_GCODE_STATE restores the shift and E, too, as
  in Klipper.
* S holds until the next S, as in GRBL and LinuxCNC. M106 and M107 with P above 0 switch another output.
* M2, M30 without a file's name, and the second % end the program. Later lines are counted, comments are read. M0 and
  M1 pause.
* Accelerations, jerks and macros of a firmware are not interpreted. An unknown code and the words after it are counted
  and ignored; codes that would change the path are rejected (`gcode_words.reject`).
"""

from __future__ import annotations

import math
import re
import struct
from array import array
from typing import Any, Final, NoReturn

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.printing.annotations import Annotations
from cablewright.printing.arc import ArcError, centre_from_offset, centre_from_radius, piece_count, pieces, swept_angle
from cablewright.printing.gcode_words import (
    BESIDE,
    MACRO,
    NUMBER,
    UNREAD,
    WordError,
    Words,
    as_number,
    bare_text,
    commands,
    is_nonzero,
    parameters,
    reject,
    split,
    why_unread,
)
from cablewright.printing.row_changes import Changes

MAX_COORDINATE: Final = 1e6  # m, distance from the origin
MAX_MOVES: Final = 20_000_000  # about 2 GB of toolpath
MAX_DWELL: Final = 1e6  # s, of one G4
MAX_TURNS: Final = 1000  # of one arc
MAX_SAVED: Final = 100  # saved sets of modes
MAX_UNKNOWN: Final = 1000  # different unknown words counted by name; the others are counted together
COLUMNS: Final = 5  # of a row: x, y, z (m, machine), extrusion (m), feed (m/s)

_ROW: Final = struct.Struct(f"={COLUMNS}d")
_Word = bytes | float | None

_NOTHING = re.compile(rb"(?!)").fullmatch  # matches no line

_SLOWEST, _FASTEST = 1e-9, 1e6  # m/s
_FARTHEST_SQUARED = MAX_COORDINATE**2
_SETTINGS: dict[str, dict[str, object]] = {
    "G17": {},
    "G91.1": {},
    "G20": {"_unit": 0.0254},
    "G21": {"_unit": 1e-3},
    "G90": {"_relative": False},
    "G91": {"_relative": True},
    "M82": {"_relative_e": False, "_e_follows_axes": False},
    "M83": {"_relative_e": True, "_e_follows_axes": False},
}
"""Codes that set a mode: attributes of `Controller`."""
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
_SHARING = frozenset({*BESIDE, *_LETTERS, *_SETTINGS})
"""Codes after which the words of the line go on."""
_MODES = ("_unit", "_relative", "_relative_e", "_e_follows_axes", "_feed")
_ALL = (*_MODES, "_shift", "_e")
_RESTORED = {"M121": _MODES, "M72": _MODES, "RESTORE_GCODE_STATE": _ALL}
"""What the codes and macros that restore modes restore."""
_SAVED = {"M120": "M120", "M121": "M120", "M70": "M70", "M71": "M70", "M72": "M70", "M73": "M70"}
"""Codes that save or restore modes, and the code under which those are saved."""
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
    G28), ``switches`` (1 while on; S: while not 0). ``dwells``: (row, s); ``unknown``: ignored words, their counts.
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
        self.switches = {name: Changes() for name in ("M101", "M106", "M3", "S")}
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
        self._saved: dict[str, list[dict[str, Any]]] = {}  # attributes by the code that saved them
        self._ended = ""  # the code that ended the program
        self._motion = ""
        self._number = 0
        self._line = b""
        self._unterminated = False

    def run(self, lines: list[bytes], first_number: int, unterminated: bool = False) -> None:
        """Interpret G-code ``lines`` from line ``first_number`` on; ``unterminated``: no line end follows them.

        Raises `InputError` with file, line number, text and what is allowed.
        """
        self._unterminated = unterminated
        straight = _NOTHING if self._ended else self._pattern.fullmatch
        for number, line in enumerate(lines, first_number):
            self._number = number
            self._line = line
            found = straight(line)
            if found is None:
                self._interpret(line)
                straight = _NOTHING if self._ended else straight
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
            if begin != b";" and (text := bare_text(line)):
                self._obey(text)
        except WordError as error:
            cut = error.cut and self._unterminated
            self._refuse("the line ends inside a word; the file looks truncated" if cut else str(error))
        except ArcError as error:
            self._refuse(str(error))

    def _obey(self, text: str) -> None:
        """Apply the settings of a line, then its one action. Raises `WordError`, `ArcError`."""
        if self._ended:
            self._count(f"after {self._ended}")
            return
        if (macro := MACRO.match(text)) is not None:
            self._call(macro[0])
            return
        words, rest = split(text)
        codes, shared, is_read = commands(words, rest, _SHARING)
        action = ""
        for code, own in codes:
            if code in _LETTERS:
                if action:
                    raise WordError(f"{action} and {code} in one line; one of them is allowed")
                action = code
            elif code in _SETTINGS:
                self._set(code)
            else:
                self._pass(code, own, len(words) == 1)
        if not is_read:
            raise WordError(why_unread(words, rest))
        taken = [(self._spelling.get(letter, letter), number) for letter, number in shared]
        owned = {letter for code, _ in codes for letter in BESIDE.get(code, "")}
        for letter, number in taken:
            if letter == "S" and number and (action != "G4" or "S" in owned):
                self.switches["S"].set(len(self.lines), is_nonzero(number))
        self._act(action, taken, owned)

    def _call(self, macro: str) -> None:
        """Obey or count a macro. Raises `WordError` where it is rejected."""
        given = parameters(self._line)
        reject(macro, given.items())
        if macro in _LABELS:
            self.notes.read_label(macro, self._line, len(self.lines))
        elif macro in ("SAVE_GCODE_STATE", "RESTORE_GCODE_STATE"):
            self._keep(macro, f"SAVE_GCODE_STATE NAME={given.get('NAME', 'default')}")
        else:
            if macro == "%" and (macro in self.unknown or len(self.lines)):
                self._ended = macro
            self._count(macro)

    def _keep(self, code: str, name: str) -> None:
        """Save modes by a ``name``, or restore the last ones saved by it. Raises `WordError`."""
        saved = self._saved.setdefault(name, [])
        if code in _RESTORED:
            if not saved:
                raise WordError(f"no modes are saved; {name[:60]} must stand before {code}")
            state = saved.pop() if code == "M121" else saved[-1]
            for key in _RESTORED[code]:
                setattr(self, key, state[key])
            for switch in ("M3", "S") if code == "M72" and len(self.switches["M3"]) else ():
                self.switches[switch].set(len(self.lines), state[switch])
            return
        if code != "M120":
            saved.clear()
        if code != "M71":
            if len(saved) + len(self._saved) > MAX_SAVED:
                raise WordError(f"more than {MAX_SAVED} saved modes")
            on, speed = (self.switches[name].last for name in ("M3", "S"))
            saved.append(
                {key: getattr(self, key) for key in _ALL} | {"M3": on or 0.0, "S": 1.0 if speed is None else speed}
            )

    def _pass(self, code: str, own: Words | None, alone: bool) -> None:
        """Record a code that moves nothing, and its ``own`` words (None: it shares those of its line).

        Raises `WordError` where it is rejected, or has to be ``alone`` in its line.
        """
        reject(code, own or ())
        given = dict(own or ())
        if code == "M486":
            self.notes.read_m486(self._line, len(self.lines))
        elif code == "G53":
            if any(self._shift) or self._relative:
                raise WordError("G53 is read with G90 and where nothing shifts the axes; write coordinates without it")
        elif code in _SAVED and not given.keys() - {*"XYZEF"} and (code != "M121" or self._saved.get("M120")):
            if not alone:
                raise WordError(f"{code} is read on a line of its own; write it there")
            self._keep(code, _SAVED[code])
        elif code in ("M106", "M107") and is_nonzero(given.get("P", "")):
            self._count(f"{code} P{given['P']}")
        else:
            self._count(code)
            if own is None and code in ("M2", "M30"):
                self._ended = code
            if code in _SWITCHES:
                name, on = _SWITCHES[code]
                self.switches[name].set(len(self.lines), on and (own is None or is_nonzero(given.get("S", "1"))))
        if code == "M200" and (diameter := given.get("D")):
            self.notes.settings["volumetric"] = float(is_nonzero(diameter))  # whether E is in mm^3

    def _act(self, action: str, taken: Words, owned: set[str]) -> None:
        """Execute ``action`` with the words of its line, or repeat the last motion where the line only names axes.

        Letters that are ``owned`` by other codes are theirs, except where the motion has to have them.
        """
        if not action and any(letter in "XYZEIJR" and letter not in owned for letter, _ in taken):
            action = self._motion
            if not action:
                raise WordError("axes without a G code before any of G0 to G3")
        owned -= {*_LETTERS.get(action, "")} - {"E", "S"}
        taken = [word for word in taken if word[0] not in owned]
        words: dict[str, float] = {}
        for letter, number in taken:
            if (action, letter) in UNREAD and (letter != "H" or is_nonzero(number)):
                raise WordError(UNREAD[action, letter])
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
        for name, value in _SETTINGS[code].items():
            setattr(self, name, value)
        if self._e_follows_axes:
            self._relative_e = self._relative

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
        homed = [not named or axis in named for axis in "XYZ"]
        before = self._x, self._y, self._z
        place = [0.0 if gone else at for gone, at in zip(homed, before, strict=True)]
        self._shift = [0.0 if gone else at for gone, at in zip(homed, self._shift, strict=True)]
        if place != [*before]:
            self._x, self._y, self._z = place
            self.homing.set(len(self.lines), 1)
            self._add(0.0)
            self.homing.set(len(self.lines), 0)

    def _rename(self, words: dict[str, float]) -> None:
        """Give the current position the coordinates of ``words`` (G92)."""
        self._shift = [
            at - words[axis] * self._unit if axis in words else shift
            for axis, at, shift in zip("XYZ", (self._x, self._y, self._z), self._shift, strict=True)
        ]  # a new list: saved modes hold the one before
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
        if "\r" in text:
            reason = "a carriage return inside a line of a file with line feeds; give each line one kind of line end"
        shown = repr(text if len(text) <= 60 else text[:57] + "...")
        raise InputError(f"{self._origin}, line {self._number}: {shown}: {reason}")


def _further_turns(turns: float, clockwise: bool) -> float:
    """Return the angle (rad) by which an arc of so many ``turns`` (P) is longer than one of P1. Raises `ArcError`."""
    if not 1 <= turns <= MAX_TURNS or turns != int(turns):
        raise ArcError(f"P is the number of turns of an arc; whole numbers from 1 to {MAX_TURNS} are allowed")
    return (turns - 1) * (-math.tau if clockwise else math.tau)
