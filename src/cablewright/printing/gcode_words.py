"""The words of one line of G-code, letters with numbers, without comments and checksums.

An ``E`` always begins a word, because ``G1X1E5`` is legal without spaces. Only a small ``e`` inside a number of a line
in capitals (``X1e5``) is an exponent, which G-code does not have: no word begins there.
"""

from __future__ import annotations

import math
import re
from typing import Final

MAX_LINE: Final = 4096  # bytes of a line without its comments
NUMBER: Final = r"[-+.0-9]+"  # float() of these reads no exponent, inf or nan: only numbers of G-code
MACRO: Final = re.compile(r"[A-Z_]{3}\w*|%", re.ASCII)  # START_PRINT of Klipper, the % that frames a CNC program

_KEPT_COMMENT = 512  # bytes of a comment that are kept of a longer line: more than any marker has
_BRACKET = re.compile(r"[();]")
_CHECKSUM = re.compile(r"\*\s*([0-9]{1,9})\s*$", re.ASCII)
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

    Raises `WordError` for a wrong checksum.
    """
    text = line.decode("latin-1")  # one character per byte, so that indices into the text are indices into the line
    text = without_comments(text) if "(" in text else text.partition(";")[0]
    if (found := _CHECKSUM.search(text)) is not None:
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


def split(text: str) -> tuple[list[tuple[str, str]], str]:
    """Return letter and number text of each word of a line (empty for a letter without number), and the unread rest."""
    words = []
    at = 0
    while (found := _WORD.match(text, at)) is not None:
        words.append((found[1], found[2] or ""))
        at = found.end()
    return words, text[at:]


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
