"""The words of one line of G-code, letters with numbers, without comments and checksums; and layer markers.

An ``E`` always begins a word, because ``G1X1E5`` is legal without spaces. Only a small ``e`` inside a number of a line
in capitals (``X1e5``) is an exponent, which G-code does not have: no word begins there.
"""

from __future__ import annotations

import math
import re
from typing import Final, Literal, NamedTuple

MarkerKind = Literal["colon", "change", "named"]

NUMBER: Final = r"[-+.0-9]+"  # float() of these reads no exponent, inf or nan: only numbers of G-code
MACRO: Final = re.compile(r"[A-Z_]{3}\w*|%", re.ASCII)  # START_PRINT of Klipper, the % that frames a CNC program

_MARKERS: Final[dict[MarkerKind, re.Pattern[bytes]]] = {
    "colon": re.compile(rb";LAYER:([-+]?[0-9]{1,9})(?:\s.*)?", re.DOTALL),
    "change": re.compile(rb";LAYER_CHANGE()\s*"),
    "named": re.compile(rb";\s?layer ([0-9]{1,9})(?:\s*|[\s,:]+[^\s=].*)", re.DOTALL),
}
_COMMENT = re.compile(r";.*|\([^()]*\)?", re.DOTALL)
_CHECKSUM = re.compile(r"\*\s*([0-9]{1,9})\s*$", re.ASCII)
_LINE_NUMBER = re.compile(r"\s*N\s*[0-9]+(?![0-9.])", re.ASCII | re.IGNORECASE)
_EXPONENT = re.compile(r"(?<=[0-9.])e(?=[-+]?[0-9])")
_KEPT_SMALL = "\0"  # replaces such an e while the line is converted to capitals; no line holds a NUL
_CAPITAL = re.compile(r"[A-Z]")
_WORD = re.compile(rf"([A-Z])\s*({NUMBER})?\s*", re.ASCII)


class WordError(ValueError):
    """A line that is no G-code; ``cut``: a word has no number, as at the end of a truncated file."""

    def __init__(self, reason: str, cut: bool = False) -> None:
        super().__init__(reason)
        self.cut = cut


class LayerMarker(NamedTuple):
    """A slicer's comment at the begin of a layer; ``number`` is None for a marker without a number."""

    kind: MarkerKind
    number: int | None


def read_marker(line: bytes) -> LayerMarker | None:
    """Read ``;LAYER:3``, ``;LAYER_CHANGE`` or ``; layer 3``, possibly with text after it, at the start of a line.

    Settings that a slicer writes as comments (``; layer_height = 0.2``, ``; layer 3 = x``) are no markers.
    """
    for kind, pattern in _MARKERS.items():
        if (found := pattern.fullmatch(line)) is not None:
            return LayerMarker(kind, int(found[1]) if found[1] else None)
    return None


def bare_text(line: bytes) -> str:
    """Return the line in capitals, except the ``e`` of an exponent, without comments, line number and checksum.

    Raises `WordError` for a wrong checksum.
    """
    text = line.decode("latin-1")  # one character per byte, so that indices into the text are indices into the line
    text = _COMMENT.sub(lambda comment: " " * len(comment[0]), text)
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
    """Return letter and number text of each word (empty for a letter without number), and the unread rest."""
    words = []
    at = 0
    while (found := _WORD.match(text, at)) is not None:
        words.append((found[1], found[2] or ""))
        at = found.end()
    return words, text[at:]


def code_of(letter: str, number: str) -> str:
    """Return a code in its usual spelling: ``G1`` for G01 and G1.0. Raises `WordError` without a number."""
    as_number(letter, number)
    whole, _, part = number.lstrip("+").partition(".")
    part = part.rstrip("0")
    return letter + (whole.lstrip("0") or "0") + (f".{part}" if part else "")


def as_number(letter: str, number: str) -> float:
    """Return the number of a word. Raises `WordError` unless it is a finite number."""
    try:
        value = float(number)
    except ValueError:
        reason = f"{letter}{number} is no number" if number else f"{letter} has no number"
        cut = not any(character.isdigit() for character in number)
        raise WordError(f"{reason}; digits with an optional sign and one point are allowed", cut) from None
    if not math.isfinite(value):
        raise WordError(f"the number of {letter} is too large")
    return value
