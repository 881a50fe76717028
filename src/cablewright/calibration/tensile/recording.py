"""The recording of a tensile test, read from a CSV with limits on size and one-line errors."""

from __future__ import annotations

import re
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.csv_input import (
    Column,
    cells_of,
    find_column,
    header_of,
    no_column,
    number_rows,
    separator_of,
    shown,
    text_lines,
    units_wanted,
)
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import DURATION, FORCE, LENGTH, RELATIVE_HUMIDITY, TEMPERATURE_DIFFERENCE, Dimension

MAX_BYTES: Final = 64 << 20
MAX_ROWS: Final = 2_000_000
MIN_POINTS: Final = 20
"""Minimum number of samples of a test, and of each of its branches within the band."""

_MAX_SIZE: Final = {"force": 1e9, "elongation": 1e5, "time": 1e10, "temperature": 1e4}  # sums of products stay finite
_SHARES: Final = ("humidity",)  # from 0 to 1
_COLUMNS: Final = {"force": FORCE, "elongation": LENGTH}
_ALSO: Final = {
    "force": ("load", "tensile force", "tensile load", "standard force"),
    "elongation": ("extension", "displacement", "tensile extension", "tensile displacement", "extensometer"),
    "time": ("test time", "elapsed time"),
}
"""What testing machines call them; the name itself comes first."""
_OTHER_STRAINS: Final = (
    "rate", "displacement", "crosshead", "traverse", "nominal", "extension", "grip", "transverse", "lateral", "plastic",
    "true", "shear", "hoop", "radial", "diametral", "width", "thickness", "poisson",
)  # fmt: skip
_LONGEST_NAME: Final = 60
_WRONG_UNIT: Final = 20.0  # motion of a crosshead over that of the specimen
_ROUNDING: Final = 0.01  # of the range: columns of one motion differ by less, as of few digits
_STRAIN: Final = Dimension(
    "strain", {unit: Decimal(size) for unit, size in {"m/m": "1", "mm/mm": "1", "%": "1e-2"}.items()}
)
_MORE_COLUMNS: Final[dict[str, Dimension]] = {
    "time": DURATION, "temperature": TEMPERATURE_DIFFERENCE, "humidity": RELATIVE_HUMIDITY,
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class TensileTest:
    """The recording of a tensile test in order of time; read-only arrays.

    ``time``, ``temperature`` and ``humidity`` are for `creep` alone. Raises `InputError` unless all columns are
    one-dimensional, of the same length, finite, and of at least `MIN_POINTS` samples, and times rise.
    """

    force: Array  # (k,) N, tension positive
    elongation: Array  # (k,) m, growing as the cable is pulled
    origin: str = "the test"  # the name in messages
    lines: Sequence[int] = ()  # (k,) line number of each sample in the file; empty without a file
    time: Array | None = None  # (k,) s
    temperature: Array | None = None  # (k,) K, or degrees Celsius where one is under 170
    humidity: Array | None = None  # (k,) relative, 0 to 1
    notes: tuple[str, ...] = ()  # sentences on columns that were not used

    def __post_init__(self) -> None:
        for name in (*_COLUMNS, *_MORE_COLUMNS):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, self._checked(name, getattr(self, name)))
        if len(self.force) != len(self.elongation):
            raise InputError(f"{self.origin}: {len(self.force)} forces, but {len(self.elongation)} elongations")
        for name in _MORE_COLUMNS:
            column = getattr(self, name)
            if column is not None and len(column) != len(self.force):
                raise InputError(f"{self.origin}: {len(self.force)} forces, but {len(column)} numbers of {name}")
        if self.time is not None and (late := np.flatnonzero(np.diff(self.time) <= 0.0)).size:
            before, after = self.time[late[0] : late[0] + 2]
            raise InputError(
                f"{self.origin}, {self.place(late[0] + 1)}: time = {after:g} s follows {before:g} s: times must rise"
            )
        if len(self.force) < MIN_POINTS:
            raise InputError(f"{self.origin}: {len(self.force)} samples; at least {MIN_POINTS} are required")

    def _checked(self, name: str, values: ArrayLike) -> Array:
        column = np.array(values, dtype=np.float64)
        if column.ndim != 1:
            raise InputError(f"{self.origin}: {name}: expected one number for each sample, not shape {column.shape}")
        low, high = (0.0, 1.0) if name in _SHARES else (-_MAX_SIZE[name], _MAX_SIZE[name])
        bad = np.flatnonzero(~((low <= column) & (column <= high)))  # NaN is bad
        if len(bad):
            unit = (_COLUMNS | _MORE_COLUMNS)[name].si
            allowed = f"must be finite and at most {high:g} {unit} in size"
            if name in _SHARES:
                allowed = f"must be 0 to 1, or '{name} (%)'"
            raise InputError(f"{self.origin}, {self.place(bad[0])}: {name} = {column[bad[0]]:g}: {allowed}")
        column.flags.writeable = False
        return column

    def place(self, sample: int) -> str:
        """Return where a sample (counted from 0) is: ``line 7`` of the file, or ``sample 7``."""
        return f"line {self.lines[sample]}" if len(self.lines) else f"sample {sample + 1}"


def read_test(path: str | Path, *, timed: bool = False, gauge: float | None = None) -> TensileTest:
    """Read a CSV whose header names columns ``force`` and ``elongation``; other columns are ignored.

    If *timed* it may name ``time``, ``temperature`` and ``humidity`` too. ``load``, ``extension`` and ``displacement``
    are the names of testing machines for the first two; a ``strain (%)`` or ``strain (m/m)`` is the elongation divided
    by *gauge*, the specimen's length in m. Where a file has both and they differ, strain is that of the extensometer,
    with a note; beside a column of the name ``elongation`` itself that is an error.
    A unit may follow the name (``force (kN)``, ``elongation [mm]``, ``force_kN``) or stand in a row below; without one
    it is SI. The separator is tab, semicolon or comma: the first of these that the header holds. Empty lines and
    comments (``#``) are skipped.

    Raises `InputError` for a file that is no regular file, is over `MAX_BYTES` or `MAX_ROWS`, is not UTF-8, lacks a
    column, or has a row shorter or longer than the header or a cell that is not a finite number.
    """
    path = Path(path)
    number, header, rows = header_of(text_lines(path, MAX_BYTES, "test"))
    if not number:
        raise InputError(f"{path}: empty; expected a header with columns force and elongation, then rows of numbers")
    cells, place = cells_of(header, separator_of(header)), f"{path}, line {number}"
    columns: dict[str, Column] = {}
    strain = _strain(cells, place, gauge)
    for name, quantity in _COLUMNS.items():
        found = _column(name, cells, place, quantity) or (strain if name == "elongation" else None)
        if found is None:
            raise no_column((name, *_ALSO[name]), cells, place, quantity)
        columns[name] = found
    used = cells[columns["elongation"].position]
    corrected = [cell for cell in cells if "correct" in cell[:_LONGEST_NAME].casefold() and cell != used]
    if corrected and columns["elongation"] != strain:
        raise InputError(
            f"{place}: columns {shown(used)} and {shown(corrected[0])}: keep the one that is of the specimen"
        )
    if strain not in (None, columns["elongation"]):
        columns["strain"] = strain
    for name, quantity in _MORE_COLUMNS.items() if timed else ():
        found = _column(name, cells, place, quantity)
        if found is not None:
            columns[name] = found
    numbers, lines = array("d"), array("q")
    for number, _, row in number_rows(path, rows, header, columns, MAX_ROWS, "rows"):
        numbers.extend(row)
        lines.append(number)
    values = dict(zip(columns, np.array(numbers).reshape(-1, len(columns)).T, strict=True))
    notes: tuple[str, ...] = ()
    if "strain" in values:
        both = [cells[columns[each].position] for each in ("elongation", "strain")]
        values["elongation"], notes = _by_extensometer(values["elongation"], values.pop("strain"), both, place)
    return TensileTest(origin=str(path), lines=lines, notes=notes, **values)


def _by_extensometer(
    elongation: Array, strain: Array, names: Sequence[str], place: str
) -> tuple[Array, tuple[str, ...]]:
    """Return the elongation (k,), m, of the extensometer, of two columns with these *names*, and a note if they differ.

    *strain* (k,): m, times the gauge length. Testing machines call the motion of the crosshead, with that of grips and
    frame, extension. Raises `InputError` where *strain* is constant, a unit must be wrong,
    or the other is named ``elongation``.
    """
    ranges = float(np.ptp(elongation)), float(np.ptp(strain))
    if np.ptp(elongation - strain) <= _ROUNDING * max(ranges):
        return elongation, ()
    differ = f"{shown(names[0])} and {shown(names[1])} times the initial length"
    ratio = ranges[0] / ranges[1] if ranges[1] else 0.0
    if not 1.0 / _WRONG_UNIT < ratio < _WRONG_UNIT or names[0].casefold().startswith("elongation"):
        raise InputError(
            f"{place}: {differ} differ, ranges {1e3 * ranges[0]:.4g} and {1e3 * ranges[1]:.4g} mm: check the units and "
            "keep the column of the extensometer, between whose marks the initial length is"
        )
    note = (
        f"elongation is {shown(names[1])} times the initial length, as of an extensometer; {shown(names[0])} is "
        f"{ratio:.3g} times as large, as of a crosshead, and not used"
    )
    return strain, (note,)


def _column(name: str, cells: Sequence[str], place: str, quantity: Dimension) -> Column | None:
    """Return the column of a quantity, by its name or else by those of testing machines. Raises `InputError`."""
    own = find_column((name,), cells, place, quantity)
    return own or find_column((name, *_ALSO.get(name, ())), cells, place, quantity)


def _strain(cells: Sequence[str], place: str, gauge: float | None) -> Column | None:
    """Return the column of an extensometer's strain as one of elongation, of a specimen of length *gauge*, m.

    Strains of the crosshead by their names, rates, and strains across the specimen are none. Raises `InputError` for
    two, or an unknown unit.
    """
    names = [(at, cell, cell[:_LONGEST_NAME].casefold()) for at, cell in enumerate(cells)]
    found = [(at, cell) for at, cell, name in names if "strain" in name and not any(w in name for w in _OTHER_STRAINS)]
    if not found or gauge is None:
        return None
    if len(found) > 1:
        raise InputError(
            f"{place}: more than one column 'strain': {' and '.join(shown(c) for _, c in found[:2])}; keep one"
        )
    at, cell = found[0]
    unit = re.split(r"[(\[_ ]", cell.rstrip(")] "))[-1].strip()
    if unit not in _STRAIN.units:
        units = f"give its unit, {units_wanted('strain', _STRAIN)}"
        raise InputError(f"{place}: column {shown(cell)}: {units}")
    return Column(at, float(_STRAIN.units[unit]) * gauge)
