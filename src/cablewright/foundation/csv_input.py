"""Reader of text tables (CSV) from any source: limited line by line; errors are one line with the position.

A column is found by its name; a unit may follow it: ``force (kN)``, ``elongation [mm]``, ``force_kN``; or all units
are in a row below the names. A cell of dashes has no value.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from difflib import get_close_matches
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.units import NUMBER, Dimension, is_unit

_LONGEST_LINE: Final = 4096  # bytes
_LONGEST_SHOWN: Final = 60
_NUMBER = re.compile(NUMBER)
_BRACKETED = re.compile(r"\((.*)\)|\[(.*)\]")
_NO_VALUE = re.compile("[-\u2013\u2014]*")
_MOST_NAMED, _MOST_SEARCHED = 12, 100  # columns in a message, and for the one that was meant


class Column(NamedTuple):
    """Position of a column, and the size of its unit in SI; None: the header has no unit."""

    position: int
    size: float | None


def text_lines(
    path: Path, max_bytes: int, what: str, longest: int = _LONGEST_LINE, *, indented: bool = False
) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line that is neither empty nor a comment (``#``). *indented*: keep the indentation.

    Lines end with LF, CR or both.

    Raises `InputError` for a file that cannot be read, holds more than ``max_bytes``, has a line over ``longest`` bytes
    or is not UTF-8.
    """
    for count, raw in enumerate(
        io.BytesIO(read_bytes(path, max_bytes, what).replace(b"\r\n", b"\n").replace(b"\r", b"\n")), 1
    ):
        if len(raw) > longest:
            raise InputError(f"{path}, line {count}: longer than {longest} bytes, the most a line may hold")
        try:
            text = raw.decode("utf-8-sig" if count == 1 else "utf-8").rstrip(
                " \n\x1a\0"
            )  # an end of file of DOS, or padding
        except UnicodeDecodeError:
            raise InputError(f"{path}, line {count}: not UTF-8 text; save it as UTF-8") from None
        bare = text.lstrip(" ")
        if bare and not bare.startswith("#"):
            yield count, text if indented else bare


def header_of(rows: Iterator[tuple[int, str]]) -> tuple[int, str, Iterator[tuple[int, str]]]:
    """Return number and text of the header line (0 and nothing where there is none), and the rows below it.

    A row of units below the names, ``(s),(mm)``, becomes a part of the header: ``Time (s),Extension (mm)``.
    """
    number, header = next(rows, (0, ""))
    below = next(rows, None)
    if below is None:
        return number, header, rows
    separator = separator_of(header)
    cells, units = cells_of(header, separator), [_as_unit(cell) for cell in cells_of(below[1], separator)]
    if len(cells) != len(units) or None in units or not any(units):
        return number, header, chain([below], rows)
    named = (f"{cell} ({unit})" if unit else cell for cell, unit in zip(cells, units, strict=True))
    return number, separator.join(named), rows


def _as_unit(cell: str) -> str | None:
    """Return the unit that is all of a cell, in brackets or known; "" for no unit, None for any other cell."""
    bracketed = _BRACKETED.fullmatch(cell)
    if bracketed is not None:
        return (bracketed[1] or bracketed[2] or "").strip(" -")
    return cell if is_unit(cell) else "" if _NO_VALUE.fullmatch(cell) else None


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


def no_column(names: Sequence[str], cells: Sequence[str], place: str, quantity: Dimension) -> InputError:
    """Return the error that a file has no column of the given *names*, with a list of its columns."""
    also = f", also called {', '.join(names[1:])}," if names[1:] else ""
    words = [set(re.findall(r"[^\W\d_]+", cell[:_LONGEST_SHOWN].casefold())) for cell in cells[:_MOST_SEARCHED]]
    near = {cell for cell in cells[: len(words)] if get_close_matches(names[0], [cell.casefold()], cutoff=0.75)}
    pairs = zip(cells, words, strict=False)
    likely = [shown(cell) for cell, held in pairs if cell in near or not held.isdisjoint(names)]
    more = f" and {len(cells) - _MOST_NAMED} more" if len(cells) > _MOST_NAMED else ""
    hint = (
        f"is it {' or '.join(likely[:2])}? then call that {names[0]!r}"
        if likely
        else (f"the header has {', '.join(map(shown, cells[:_MOST_NAMED]))}{more}")
    )
    return InputError(f"{place}: no column {names[0]!r}{also} ({units_wanted(names[0], quantity)}); {hint}")


def units_wanted(name: str, quantity: Dimension) -> str:
    """Return a sentence about the units that may follow a column's name."""
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
    has more or fewer cells than the header, and a cell that is not a finite number; an empty one, or dashes, is NaN in
    the columns that may be *blank*.
    """
    separator = separator_of(header)
    width = len(header.split(separator))
    for count, (number, text) in enumerate(rows):
        place = f"{path}, line {number}"
        cells = text.split(separator)
        if len(cells) != width:
            quoted = f"; a number in quotes holds {separator!r}: write it without" if '"' in text else ""
            raise InputError(f"{place}: {len(cells)} cells; the header has {width}{quoted}")
        if count == max_rows:
            raise InputError(f"{place}: more than {max_rows} {what}, the maximum")
        numbers = [
            math.nan
            if name in blank and _NO_VALUE.fullmatch(bare(cells[c.position]))
            else read_number(cells[c.position], f"{place}: {name}") * (c.size or 1.0)
            for name, c in columns.items()
        ]
        yield number, cells, numbers


def shown(text: str) -> str:
    """Return a cell of the file in quotes, shortened if it is long."""
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
    plain = cell[len(name) :].lstrip(" _/,")
    return plain if plain in quantity.units and plain != cell[len(name) :] else None


def bare(cell: str) -> str:
    """Return the text of a table cell without spaces and quotes around it."""
    cell = cell.strip()
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell
