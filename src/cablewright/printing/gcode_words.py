"""The words of one line of G-code, letters with numbers, without comments and checksums; which codes are errors.

A line of a machine tool's program is a set of words: the words that no code owns are those of its motion. A command of
a printer's firmware owns the words after it, up to the next code.

An ``E`` always begins a word, because ``G1X1E5`` is legal without spaces. Only a small ``e`` inside a number of a line
in capitals (``X1e5``) is an exponent, which G-code does not have: no word begins there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Container, Iterable, Mapping
from types import MappingProxyType
from typing import Final

MAX_LINE: Final = 4096  # bytes of a line without its comments
NUMBER: Final = r"[-+.0-9]+"  # float() of these reads no exponent, inf or nan: only numbers of G-code
MACRO: Final = re.compile(
    r"[A-Z_]{3}\w*|%|IF\b|O(?=\s*(?:[0-9]+|<[^>]*>|\[[^\]]*\])\s*[A-Z]{2})", re.ASCII
)  # START_PRINT of Klipper, the % that frames a CNC program, conditions, O100 SUB
Words = list[tuple[str, str]]  # letters with the texts of their numbers
FREE_TEXT: Final = frozenset(f"M{n}" for n in (0, 1, 16, 20, 23, 28, 30, 32, 33, 36, 37, 38, 117, 118, 486, 928))
"""Codes before a text: a message, the name of a file."""

BESIDE: Final[Mapping[str, str]] = MappingProxyType(
    dict.fromkeys(("G8", "G13.1", "G15", "G40", "G49", "G53", "G54", "G61", "G61.1", "G67", "G69", "G80"), "")
    | dict.fromkeys(("G94", "G97", "G98", "G99", "M2", "M6", "M7", "M8", "M9", "M10", "M11", "M30"), "")
    | dict.fromkeys(("M48", "M49", "M60", "M101", "M102", "M103"), "")
    | {"G43": "H", "G44": "H", "G64": "PQ", "G96": "D", "M19": "RQP", "M61": "Q", "M66": "PLEQ"}
    | dict.fromkeys(("M3", "M4", "M5"), "SIOP")
    | dict.fromkeys(("M50", "M51", "M52", "M53", "M62", "M63", "M64", "M65"), "P")
    | dict.fromkeys(("M67", "M68"), "EQ")
)
"""Codes that may stand beside a motion, and the letters that they own, anywhere in the line."""

_MOVES = "G0 to G3, G28 and G92 are allowed: write the motion as those"
_SHIFTS = f"it shifts coordinates; {_MOVES}, or set the job's origin"
_REFUSED: Final = {
    code: why
    for codes, why in {
        "G5 G5.1 G5.2 G5.3": "splines are not read; G0 to G3 are",
        "G18 G19 G17.1 G18.1 G19.1": "arcs are read in the XY plane (G17) only",
        "G7 G12.1 G16 G112": f"radii and angles for X and Y are not read; {_MOVES}",
        "G41 G41.1 G42 G42.1": "cutter compensation is not read; write the path of the tool's centre, with G40",
        "G43.1 G43.2 G52 G92.2 G92.3 M428 M206 M290 G10 SET_GCODE_OFFSET SET_KINEMATIC_POSITION": _SHIFTS,
        "G51 M579": "scaling inside the file is not read; a job has a scale",
        "G54.1 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3": "its offset is not read; G54 is allowed, and a job's origin",
        "G51.1 G51.2 G60 FORCE_MOVE": f"it moves or mirrors axes, and is not read; {_MOVES}",
        "G65 G66 M26 M32 M47 M97 M98 M99 M808 IF ELIF ELSE WHILE BREAK CONTINUE ABORT FOR LOOP ENDLOOP REPEAT UNTIL O "
        "CALL CASE GOTO GOTOF GOTOB GOTOC SDCARD_LOOP_BEGIN SDCARD_LOOP_END SDCARD_PRINT_FILE": (
            "loops, conditions and subprograms are not read; expand them to G0 to G3"
        ),
        "G68 G68.2": "rotation inside the file is not read",
        "TRANS ATRANS ROT AROT ROTS AROTS SCALE ASCALE MIRROR AMIRROR": f"frames are not read; {_MOVES}",
        "G70 G71": "they are units on some machines, cycles on others; G20 and G21 are allowed",
        "G90.1": "absolute arc centres are not read; I and J are measured from the start of the arc",
        "G92.1": "G92 is read with coordinates or bare",
        "G93": "inverse-time feed is not read; F is a speed",
        "G95": "feed per revolution is not read; F is a speed: write it per minute, with G94",
        "M220": "a percentage of F is not read, other than S100; write F as it is to be",
        "RESTORE_GCODE_STATE": "MOVE=1 is not read; write the move back as G0, after it",
    }.items()
    for code in codes.split()
}
"""Codes and macros that would change the path, and why each is an error."""

_NEUTRAL: Final[Mapping[str, tuple[Iterable[str], float | None]]] = {
    "G10": ("XYZL", 0.0),
    "M98": ("P", 0.0),
    "M206": ("XYZ", 0.0),
    "M220": ("S", 100.0),
    "M290": ("XYZS", 0.0),
    "M579": ("XYZ", 1.0),
    "M808": ("L", None),
    "RESTORE_GCODE_STATE": (("MOVE",), 0.0),
    "SET_GCODE_OFFSET": ([axis + end for axis in "XYZE" for end in ("", "_ADJUST")], 0.0),
}
"""Of those, the ones that are errors only where a parameter has another number than this, or any (None)."""

UNREAD: Final = dict.fromkeys(
    (("G2", "K"), ("G3", "K")), "K of an arc is not read; X, Y, Z, E, F, P with I and J, or with R, are allowed"
) | {
    (code, letter): f"{letter} of {code} is not read; write the end of the move by X, Y and Z"
    for code in ("G0", "G1")
    for letter in "RH"
}
"""Words that change a motion and are not read; H0 changes none."""
_FIRST_OF_VENDORS = 500  # M-codes from here on are one to a line; their words may be M and G
_PREPARING = frozenset({"G10", "G29", "G130", "G161", "G162", "G380"})
"""G-codes whose axis words are no path: they level, home or set up the machine."""

_KEPT_COMMENT = 512  # bytes of a comment that are kept of a longer line: more than any marker has
_BRACKET = re.compile(r"[();]")
_CHECKSUM = re.compile(r"\*\s*([0-9]{1,9})\s*$", re.ASCII)
_TEXT = re.compile(rf"\s*(?:M0*(?:{'|'.join(code[1:] for code in FREE_TEXT)})(?![0-9.])|[A-Z_]{{3}})", re.A | re.I)
_PARAMETER = re.compile(r"(?<!\w)([A-Za-z_]\w*)[ \t]*=[ \t]*(\"[^\"]*\"|'[^']*'|[^\s*]+)", re.ASCII)
_LINE_NUMBER = re.compile(r"\s*N\s*[0-9]+(?![0-9.])", re.ASCII | re.IGNORECASE)
_EXPONENT = re.compile(r"(?<=[0-9.])e(?=[-+]?[0-9])")
_KEPT_SMALL = "\0"  # replaces such an e while the line is converted to capitals; no line holds a NUL
_CAPITAL = re.compile(r"[A-Z]")
_DECIMAL_COMMA = re.compile(r",[0-9]")
_WORD = re.compile(rf"([A-Z])\s*({NUMBER})?\s*", re.ASCII)


class WordError(ValueError):
    """Error: a line is no G-code; ``cut``: a word has no number, as at the end of a truncated file."""

    def __init__(self, reason: str, cut: bool = False) -> None:
        super().__init__(reason)
        self.cut = cut


def comments(text: str) -> list[tuple[int, int, int]]:
    """Return begin, end and open parentheses of each comment of a line: after ``;``, or in nested parentheses.

    Only the last comment may be open at the end of the text. The time is linear in its length.
    """
    found = []
    depth = begin = 0
    for bracket in _BRACKET.finditer(text):
        if bracket[0] == "(":
            begin = begin if depth else bracket.start()
            depth += 1
        elif depth and bracket[0] == ")":
            depth -= 1
            if depth == 0:
                found.append((begin, bracket.end(), 0))
        elif depth == 0 and bracket[0] == ";":
            return [*found, (bracket.start(), len(text), 0)]
    return [*found, (begin, len(text), depth)] if depth else found


def without_comments(text: str) -> str:
    """Return the text with a space for each character of its comments.

    A last comment may lack its parenthesis. Where more are open, code might follow: one parenthesis is left in place.
    """
    kept, at = [], 0
    for begin, end, depth in comments(text):
        matched = depth == 0 or text.count("(", begin) == 1
        kept += [text[at:begin], " " * (end - begin) if matched else "("]
        at = end
    return "".join(kept) + text[at:]


def shortened(line: bytes) -> bytes:
    """Return a long G-code line, or its beginning, with long comments shortened; an open one stays open."""
    text = line.decode("latin-1")
    kept, at = [], 0
    for begin, end, depth in comments(text):
        kept.append(text[at:begin])
        kept.append(text[begin : begin + _KEPT_COMMENT] if text[begin] == ";" else "(" * depth or " ")
        at = end
    return ("".join(kept) + text[at:]).encode("latin-1")


def bare_text(line: bytes) -> str:
    """Return the line in capitals, except the ``e`` of an exponent, without comments, line number and checksum.

    Free text has a checksum only after a line number. Raises `WordError` for a wrong one.
    """
    text = line.decode("latin-1")  # one character per byte, so that indices into the text are indices into the line
    text = without_comments(text) if "(" in text else text.partition(";")[0]
    if (found := checksum(text)) is not None:
        own = 0
        for byte in line[: found.start()]:
            own ^= byte
        if own != int(found[1]):
            raise WordError(f"the checksum {found[1]} does not match the line's, {own}")
        text = text[: found.start()]
    if (found := _LINE_NUMBER.match(text)) is not None:
        text = text[found.end() :]
    if _CAPITAL.search(text) is not None:
        text = _EXPONENT.sub(_KEPT_SMALL, text)
    return text.strip().upper().replace(_KEPT_SMALL, "e")


def checksum(text: str) -> re.Match[str] | None:
    """Return the checksum at the end of a line without comments; None where there is none, or a star in free text."""
    return None if "*" not in text or _TEXT.match(text) is not None else _CHECKSUM.search(text)


def parameters(line: bytes) -> dict[str, str]:
    """Return the parameters of a macro, such as ``NAME=a``, by their names in capitals."""
    found = _PARAMETER.findall(line.decode("latin-1").partition(";")[0])
    return {name.upper(): value.strip("\"'") for name, value in found}


def is_nonzero(number: str) -> bool:
    """Return whether the text of a number has a digit other than 0."""
    return bool(number.strip("+-.0"))


def reject(code: str, own: Collection[tuple[str, str]]) -> None:
    """Raise `WordError` where a code or macro, with its ``own`` words or parameters, would change the path."""
    is_motion = code[0] == "G" and code[1:2].isdigit() and code.partition(".")[0] not in _PREPARING
    letters, neutral = _NEUTRAL.get(code, ("XYZ" if is_motion else "", None))
    changed = any(
        letter in letters and (neutral is None or (number and as_number(letter, number) != neutral))
        for letter, number in own
    )
    is_set_up = code == "M290" and len(own) > 2  # of the motors of a Bambu: X40 Y40 Z2.7
    if (changed and not is_set_up) or (code in _REFUSED and code not in _NEUTRAL):
        raise WordError(_REFUSED.get(code, f"{code} with axes may move or shift them, and is not read; {_MOVES}"))


def split(text: str) -> tuple[list[tuple[str, str]], str]:
    """Return letter and number text of each word of a line (empty for a letter without number), and the unread rest."""
    words = []
    at = 0
    while (found := _WORD.match(text, at)) is not None:
        words.append((found[1], found[2] or ""))
        at = found.end()
    return words, text[at:]


def commands(words: Words, rest: str, sharing: Container[str]) -> tuple[list[tuple[str, Words | None]], Words, bool]:
    """Return each code of a line with the words that it owns, and the words that are shared.

    A code of ``sharing`` owns none (None): it takes part in the shared ones. Third, False where the unread ``rest`` of
    the line is no text of a code that owns it.
    """
    shared: Words = []
    codes: list[tuple[str, Words | None]] = []
    into: Words = shared
    is_vendors = False  # M1006 A0 M60 E37: no code follows
    for at, (letter, number) in enumerate(words):
        is_code = (letter == "T" and into is shared) or (letter in "GM" and (number != "" or into is shared))
        if is_vendors or not is_code:
            into.append((letter, number))
            continue
        code = letter + number if letter == "T" else code_of(letter, number)
        is_text = code in FREE_TEXT and (at + 1 < len(words) or rest != "")
        into = shared if not is_text and (code in sharing or (letter == "T" and number)) else []
        codes.append((code, None if into is shared else into))
        is_vendors = letter == "M" and float(number) >= _FIRST_OF_VENDORS
        if is_text:
            break
    return codes, shared, not rest or into is not shared


def why_unread(words: list[tuple[str, str]], rest: str) -> str:
    """Return why the ``rest`` of a line is no word of G-code, after the ``words`` that `split` could read."""
    if words and _DECIMAL_COMMA.match(rest) is not None:
        letter, number = words[-1]
        return f"{letter + number + ','!r} is a decimal comma; export the file with decimal points, as in {letter}1.5"
    if rest[0] in "()":
        return "the parentheses of the comment do not match; each ( needs its )"
    shown = rest[:20].encode("ascii", "replace").decode()
    return f"{shown!r} is no G-code word; a letter and a number without exponent are allowed"


def code_of(letter: str, number: str) -> str:
    """Return a code in its usual spelling: ``G1`` for G01 and G1.0. Raises `WordError` without a number."""
    as_number(letter, number)
    whole, _, part = number.lstrip("+").partition(".")
    part = part.rstrip("0")
    return letter + (whole.lstrip("0") or "0") + (f".{part}" if part else "")


def as_number(letter: str, number: str) -> float:
    """Return the number of a G-code word, such as X1.5. Raises `WordError` unless it is finite."""
    try:
        value = float(number)
    except ValueError:
        reason = f"{letter}{number} is no number" if number else f"{letter} has no number"
        cut = not any(character.isdigit() for character in number)
        raise WordError(f"{reason}; digits with an optional sign and one point are allowed", cut) from None
    if not math.isfinite(value):
        raise WordError(f"the number of {letter} is too large")
    return value
