"""Leica's GSI-8 and GSI-16: blocks of words, each an index, a unit digit, a sign and 8 or 16 digits.

A block begins at word 11, or at the first of words 41 to 49, in any place of a line.

A word as in Leica's manuals (TPS1100 user manual, chapter "Data format"): positions 1 and 2 hold the word's index,
position 6 the unit, position 7 the sign, then the digits, without a decimal point; the unit says where it is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.foundation.csv_input import shown
from cablewright.foundation.errors import InputError

POINT: Final = 11
ANGLES: Final = frozenset({21, 22})  # horizontal circle, zenith angle
LENGTHS: Final = frozenset({31, 81, 82, 83, 84, 85, 86, 87, 88})
"""Slope distance; E, N, H of the target; E0, N0, H0 of the station; height of the reflector and of the instrument."""

_CODES: Final = range(41, 50)  # of a block of codes: the code, then what belongs to it
_FOOT: Final = 0.3048
_UNITS: Final = {"0": 1e-3, "1": 1e-3 * _FOOT, "6": 1e-4, "7": 1e-4 * _FOOT, "8": 1e-5}  # m for the last digit
_CIRCLE: Final = {"2": 400e5, "3": 360e5, "5": 6400e4}  # last digits in a turn
_SEXAGESIMAL: Final = "4"
_FIRST = re.compile(r"\*?[0-9]{2}[0-9.]{4}[+-]")
_NO_VALUE = re.compile(r"-+")
_WORD = re.compile(r"([0-9]{2})([0-9. ]{3})([0-9. ])([+-])(.*)")
_MAX_WORDS: Final = 64


class Block(NamedTuple):
    """One block of a GSI file: the point's name and its measurements by word index, in m and rad; or codes.

    ``codes``: what the words 41 to 49 hold that are not empty, in words; empty for a block of measurements. ``blank``:
    words without a value.
    """

    line: int
    point: str | None
    words: dict[int, float]
    codes: tuple[str, ...] = ()
    blank: frozenset[int] = frozenset()


def looks_like_gsi(text: str) -> bool:
    """Return whether a file that begins with this line is a GSI file."""
    return _FIRST.match(text) is not None


def read_blocks(path: Path, lines: Iterator[tuple[int, str]]) -> Iterator[Block]:
    """Yield the blocks of all lines of a GSI file.

    A word whose digits are dashes has no value. Raises `InputError` for a line that is not of words, a word with the
    wrong number of digits, or an unknown unit.
    """
    for number, text in lines:
        for count, words in enumerate(_parts(text.split()), 1):
            yield _block(number, words, f"{path}, line {number}" + (f", block {count}" if count > 1 else ""))


def _parts(words: list[str]) -> Iterator[list[str]]:
    """Yield the words of each block of a line."""
    first = 0
    kinds = [word.removeprefix("*")[:2] for word in words]
    codes = [kind.isdecimal() and int(kind) in _CODES for kind in kinds]
    for at in range(1, len(words)):
        if kinds[at] in ("11", "41") or (codes[at] and not codes[at - 1]):
            yield words[first:at]
            first = at
    yield words[first:]


def _block(number: int, raw: list[str], place: str) -> Block:
    """Return the block of the words *raw* of line *number*. Raises `InputError`."""
    if len(raw) > _MAX_WORDS:
        raise InputError(f"{place}: {len(raw)} words, over the limit of {_MAX_WORDS} in a block")
    digits = 16 if raw[0].startswith("*") else 8
    point: str | None = None
    words: dict[int, float] = {}
    codes: list[str] = []
    blank: set[int] = set()
    for word in (raw[0].removeprefix("*"), *raw[1:]):
        match = _WORD.fullmatch(word)
        if match is None:
            raise InputError(
                f"{place}: {shown(word)} is not a GSI word: two digits of index, four of information, a sign and the "
                "data"
            )
        index, (unit, sign, data) = int(match[1]), match.group(3, 4, 5)
        if index in _CODES and data.strip("0"):
            codes.append(f"{index} {data.lstrip('0')}")
        if index != POINT and index not in ANGLES and index not in LENGTHS:
            continue
        if len(data) != digits:
            raise InputError(f"{place}: word {shown(word)} has {len(data)} places of data; expected {digits}")
        if index in words or index in blank:
            raise InputError(f"{place}: the GSI word {index} occurs twice in this block")
        if index == POINT:
            point = data.lstrip("0") or "0"
        elif _NO_VALUE.fullmatch(data):
            blank.add(index)
        else:
            words[index] = _value(index, unit, data, f"{place}: word {shown(word)}") * (-1 if sign == "-" else 1)
    return Block(number, point, words, tuple(codes), frozenset(blank))


def _value(index: int, unit: str, data: str, place: str) -> float:
    """Return the value of a word's digits, m or rad."""
    if not data.isascii() or not data.isdigit():
        raise InputError(f"{place}: {shown(data)} must be digits")
    if index in LENGTHS:
        if unit not in _UNITS:
            raise InputError(f"{place}: unit {unit!r}; a length has one of {', '.join(_UNITS)}")
        return int(data) * _UNITS[unit]
    if unit == _SEXAGESIMAL:
        return math.radians(_degrees(int(data), place))
    if unit not in _CIRCLE:
        raise InputError(f"{place}: unit {unit!r}; an angle has one of {', '.join(sorted({*_CIRCLE, _SEXAGESIMAL}))}")
    return int(data) / _CIRCLE[unit] * math.tau


def _degrees(data: int, place: str) -> float:
    """Return the degrees of DDDMMSSs, the last digit a tenth of a second."""
    rest, tenths = divmod(data, 1000)
    degrees, minutes = divmod(rest, 100)
    if minutes >= 60 or tenths >= 600:
        raise InputError(f"{place}: {minutes} minutes and {tenths / 10:g} seconds; both must be under 60")
    return degrees + minutes / 60 + tenths / 36000
