"""The recording of a tensile test: read from a CSV that a stranger wrote, capped and refused in one line."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.csv_input import cells_of, find_column, no_column, read_number, separator_of, text_lines
from cablewright.errors import InputError
from cablewright.units import FORCE, LENGTH

MAX_BYTES: Final = 64 << 20
MAX_ROWS: Final = 2_000_000
MIN_POINTS: Final = 20
"""Samples that a test needs, and each of its branches within the band."""

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
    rows = text_lines(path, MAX_BYTES, "test")
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
            columns[name].append(read_number(cells[position], f"{path}, line {number}: {name}") * size)
        lines.append(number)
    return TensileTest(np.array(columns["force"]), np.array(columns["elongation"]), str(path), lines)


class _RecordingColumns(NamedTuple):
    """How rows are to be read: the cells in a row, and the position and the unit's size of each column."""

    separator: str
    width: int
    columns: dict[str, tuple[int, float]]


def _header(text: str, place: str) -> _RecordingColumns:
    separator = separator_of(text)
    cells = cells_of(text, separator)
    columns = {name: _column(name, cells, place) for name in _COLUMNS}
    return _RecordingColumns(separator, len(cells), columns)


def _column(name: str, cells: list[str], place: str) -> tuple[int, float]:
    """Find the one column of that name: its position and its unit's size."""
    found = find_column((name,), cells, place, _COLUMNS[name])
    if found is None:
        raise no_column(name, cells, place, _COLUMNS[name], tuple(_COLUMNS))
    return found.position, 1.0 if found.size is None else found.size
