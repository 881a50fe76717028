"""Reading tables of text that a stranger wrote: limited line by line, and errors are one line with the place.

A column is found by its name; a unit may follow it: ``force (kN)``, ``elongation [mm]``, ``force_kN``.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from difflib import SequenceMatcher
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.errors import InputError, suggestion
from cablewright.toml_input import read_bytes
from cablewright.units import Dimension

_LONGEST_LINE: Final = 4096  # bytes
_LONGEST_SHOWN: Final = 60
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


class Column(NamedTuple):
    """Position of a column, and the size of its unit in SI; None: the header gives no unit."""

    position: int
    size: float | None


def text_lines(path: Path, max_bytes: int, what: str, *, indented: bool = False) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line that is neither empty nor a comment (``#``); *indented*: with its indentation.

    Raises `InputError` for a file that cannot be read, holds more than ``max_bytes``, has a line over 4096 bytes or is
    not UTF-8.
    """
    for count, raw in enumerate(io.BytesIO(read_bytes(path, max_bytes, what)), 1):
        if len(raw) > _LONGEST_LINE:
            raise InputError(f"{path}, line {count}: longer than {_LONGEST_LINE} bytes, the most a line may hold")
        try:
            text = raw.decode("utf-8-sig" if count == 1 else "utf-8").rstrip(" \r\n")
        except UnicodeDecodeError:
            raise InputError(f"{path}, line {count}: not UTF-8 text; save the table as CSV in UTF-8") from None
        bare = text.lstrip(" ")
        if bare and not bare.startswith("#"):
            yield count, text if indented else bare


def separator_of(header: str) -> str:
    """Return the first of tab, semicolon and comma that is in the header."""
    return next((mark for mark in "\t;," if mark in header), ",")


def cells_of(text: str, separator: str) -> list[str]:
    """Split a row into cells, without the quotes around them."""
    return [bare(cell) for cell in text.split(separator)]


def find_column(names: Sequence[str], cells: Sequence[str], place: str, quantity: Dimension) -> Column | None:
    """Find the column with one of these ``names``; None if no cell of the header has one.

    Raises `InputError` for two such columns, or for a unit that ``quantity`` does not have.
    """
    units = ((i, _unit(cell, name, quantity)) for i, cell in enumerate(cells) for name in names)
    found = [(i, unit) for i, unit in units if unit is not None]
    if len(found) > 1:
        both = " and ".join(repr(cells[i][:_LONGEST_SHOWN]) for i, _ in found[:2])
        raise InputError(f"{place}: more than one column {names[0]!r}: {both}; keep one")
    if not found:
        return None
    position, unit = found[0]
    if not unit:
        return Column(position, None)
    if unit not in quantity.units:
        unknown = f"unknown unit {unit[:_LONGEST_SHOWN]!r}"
        raise InputError(f"{place}: column {shown(cells[position])}: {unknown}; {units_wanted(names[0], quantity)}")
    return Column(position, float(quantity.units[unit]))


def no_column(name: str, cells: Sequence[str], place: str, quantity: Dimension, names: Sequence[str]) -> InputError:
    """Return the error for a missing column; ``names`` are all expected ones."""
    near = max(cells, key=lambda cell: SequenceMatcher(None, name, cell[:_LONGEST_SHOWN].casefold()).ratio())
    hint = suggestion(near[:_LONGEST_SHOWN].casefold(), names)
    units = units_wanted(name, quantity)
    return InputError(f"{place}: no column {name!r} ({units}); column {near[:_LONGEST_SHOWN]!r}: {hint}")


def units_wanted(name: str, quantity: Dimension) -> str:
    """Return a sentence about the unit after a column's name."""
    units = list(quantity.units)
    return f"a unit may follow, as in '{name} ({units[:2][-1]})', one of {', '.join(units)}"


def read_number(cell: str, place: str) -> float:
    """Return the finite number in a cell, quoted or not. Raises `InputError`."""
    cell = bare(cell)
    if _NUMBER.fullmatch(cell) is None:
        raise InputError(f"{place} = {shown(cell)}: must be a finite number, with a decimal point and without a unit")
    return float(cell)


def number_rows(
    path: Path,
    rows: Iterator[tuple[int, str]],
    header: str,
    columns: Mapping[str, Column],
    max_rows: int,
    what: str,
    blank: Container[str] = (),
) -> Iterator[tuple[int, list[str], list[float]]]:
    """Yield line number, cells and the SI numbers of *columns* (by name) of each row below *header*.

    Raises `InputError` for more than *max_rows* rows (*what* a row is, in the plural, is for the message), a row that
    has more or fewer cells than the header, and a cell that is not a finite number; an empty one is NaN in the columns
    that may be *blank*.
    """
    separator = separator_of(header)
    width = len(header.split(separator))
    for count, (number, text) in enumerate(rows):
        place = f"{path}, line {number}"
        cells = text.split(separator)
        if len(cells) != width:
            raise InputError(f"{place}: {len(cells)} cells; the header has {width}")
        if count == max_rows:
            raise InputError(f"{place}: more than {max_rows} {what}, the maximum")
        numbers = [
            math.nan
            if name in blank and not bare(cells[c.position])
            else read_number(cells[c.position], f"{place}: {name}") * (c.size or 1.0)
            for name, c in columns.items()
        ]
        yield number, cells, numbers


def shown(text: str) -> str:
    """Return the ``repr`` of a text of the file, shortened where it is long."""
    return repr(text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 3] + "...")


def _unit(cell: str, name: str, quantity: Dimension) -> str | None:
    """Return the unit in a header's cell of the column ``name``, "" for none; None for another column.

    Text in brackets is a unit, known or not; without brackets only a known one, because ``force_rate`` is a different
    quantity. Units are case-sensitive: mN and MN differ by nine orders of magnitude.
    """
    if cell[: len(name)].casefold() != name:
        return None
    rest = cell[len(name) :].strip()
    if not rest:
        return ""
    bare = rest.lstrip(" _")
    if bare[:1] + bare[-1:] in ("()", "[]"):
        return bare[1:-1].strip() or "()"
    plain = cell[len(name) :].lstrip(" _/")
    return plain if plain in quantity.units and plain != cell[len(name) :] else None


def bare(cell: str) -> str:
    """Return the text of a cell without spaces and quotes around it."""
    cell = cell.strip()
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell
