"""The recording of a tensile test: read from a CSV that a stranger wrote, capped and refused in one line."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.calibration.table import bare, rows_of
from cablewright.calibration.table import number as to_number
from cablewright.errors import InputError, suggestion
from cablewright.units import FORCE, LENGTH, Dimension

__all__ = ["MAX_BYTES", "MAX_ROWS", "MIN_POINTS", "TensileTest", "read_test"]

Array = NDArray[np.float64]

MAX_BYTES: Final = 64 << 20
MAX_ROWS: Final = 2_000_000
MIN_POINTS: Final = 20
"""Samples that a test needs, and each of its branches within the band."""

_LONGEST_LINE: Final = 4096  # bytes: a line is split as a whole
_LARGEST: Final = {"force": 1e9, "elongation": 1e5}  # N, m: sums of their products stay finite
_COLUMNS: Final = {"force": FORCE, "elongation": LENGTH}


@dataclass(frozen=True, eq=False)
class TensileTest:
    """The recording of a tensile test in the order of time; read-only arrays.

    Raises `InputError` unless both columns are one-dimensional, as long as each other, finite, and of at least
    `MIN_POINTS` samples.
    """

    force: Array  # (k,) N, tension positive
    elongation: Array  # (k,) m, growing as the cable is pulled
    origin: str = "the test"  # names it in messages
    lines: Sequence[int] = ()  # (k,) line of the file of each sample; none if it comes from no file

    def __post_init__(self) -> None:
        for name in _COLUMNS:
            object.__setattr__(self, name, self._checked(name, getattr(self, name)))
        if len(self.force) != len(self.elongation):
            raise InputError(f"{self.origin}: {len(self.force)} forces, but {len(self.elongation)} elongations")
        if len(self.force) < MIN_POINTS:
            raise InputError(f"{self.origin}: {len(self.force)} samples; at least {MIN_POINTS} are wanted")

    def _checked(self, name: str, values: ArrayLike) -> Array:
        column = np.array(values, dtype=np.float64)
        if column.ndim != 1:
            raise InputError(f"{self.origin}: {name}: one number for each sample is wanted, not shape {column.shape}")
        bad = np.flatnonzero(~(np.abs(column) <= _LARGEST[name]))
        if len(bad):
            allowed = f"must be finite and at most {_LARGEST[name]:g} {_COLUMNS[name].si} in size"
            raise InputError(f"{self.origin}, {self.place(bad[0])}: {name} = {column[bad[0]]:g}: {allowed}")
        column.flags.writeable = False
        return column

    def place(self, sample: int) -> str:
        """Say where a sample (counted from 0) stands: ``line 7`` of the file."""
        return f"line {self.lines[sample]}" if len(self.lines) else f"sample {sample + 1}"


def read_test(path: str | Path) -> TensileTest:
    """Read a CSV whose header names columns ``force`` and ``elongation``; others are ignored.

    A unit may follow the name (``force (kN)``, ``elongation [mm]``, ``force_kN``); without one it is SI. Tab, semicolon
    or comma is between cells: the first of these that the header holds. Empty lines and comments (``#``) are skipped.

    Raises `InputError` where it is no regular file, is over `MAX_BYTES` or `MAX_ROWS`, is not UTF-8, lacks a column, or
    has a row that is shorter or longer than the header or a cell that is no finite number.
    """
    path = Path(path)
    rows = rows_of(path, MAX_BYTES, _LONGEST_LINE, "test")
    number, text = next(rows, (0, ""))
    if not number:
        raise InputError(f"{path}: empty; a header with columns force and elongation, and rows of numbers are wanted")
    table = _header(text, f"{path}, line {number}")
    columns = {name: array("d") for name in _COLUMNS}
    lines = array("q")
    for number, text in rows:
        if len(lines) == MAX_ROWS:
            raise InputError(f"{path}, line {number}: more than {MAX_ROWS} rows, the most a test may have")
        cells = text.split(table.separator)
        if len(cells) != table.width:
            raise InputError(f"{path}, line {number}: {len(cells)} cells; the header has {table.width}")
        for name, (position, size) in table.columns.items():
            columns[name].append(to_number(cells[position], f"{path}, line {number}: {name}") * size)
        lines.append(number)
    return TensileTest(np.array(columns["force"]), np.array(columns["elongation"]), str(path), lines)


class _Table(NamedTuple):
    """How rows are to be read: the cells in a row, and the position and the unit's size of each column."""

    separator: str
    width: int
    columns: dict[str, tuple[int, float]]


def _header(text: str, place: str) -> _Table:
    separator = next((mark for mark in "\t;," if mark in text), ",")
    cells = [bare(cell) for cell in text.split(separator)]
    columns = {name: _column(name, cells, place) for name in _COLUMNS}
    return _Table(separator, len(cells), columns)


def _column(name: str, cells: list[str], place: str) -> tuple[int, float]:
    """Find the one column of that name: its position and its unit's size."""
    quantity = _COLUMNS[name]
    found = [(i, unit) for i, cell in enumerate(cells) if (unit := _unit(cell, name, quantity)) is not None]
    if len(found) > 1:
        both = " and ".join(repr(cells[i][:60]) for i, _ in found[:2])
        raise InputError(f"{place}: more than one column {name!r}: {both}; keep one")
    units = f"a unit may follow, as in '{name} ({list(quantity.units)[1]})', one of {', '.join(quantity.units)}"
    if not found:
        near = max(cells, key=lambda cell: SequenceMatcher(None, name, cell[:60].casefold()).ratio())
        hint = suggestion(near[:60].casefold(), _COLUMNS)
        raise InputError(f"{place}: no column {name!r} ({units}); column {near[:60]!r}: {hint}")
    position, unit = found[0]
    if unit not in quantity.units:
        raise InputError(f"{place}: column {cells[position][:60]!r}: unknown unit {unit[:60]!r}; {units}")
    return position, float(quantity.units[unit])


def _unit(cell: str, name: str, quantity: Dimension) -> str | None:
    """Return the unit that a header's cell gives to the column ``name``, or None if the cell is another column.

    What is in brackets is a unit, known or not. Without them ``force_rate`` must stay a quantity of its own. Units are
    told apart by case, for in some mN and MN are one letter and nine digits apart.
    """
    if cell[: len(name)].casefold() != name:
        return None
    rest = cell[len(name) :].strip()
    if not rest:
        return quantity.si
    bare = rest.lstrip(" _")
    if bare[:1] + bare[-1:] in ("()", "[]"):
        return bare[1:-1].strip()
    plain = cell[len(name) :].lstrip(" _/")
    return plain if plain in quantity.units and plain != cell[len(name) :] else None
