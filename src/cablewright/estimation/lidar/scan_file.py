"""Reads a planar lidar's scan from a CSV or JSON file of any origin: size capped, errors in one line.

Units that the file does not name are guessed from the size of its numbers, and the guess is reported.
"""

from __future__ import annotations

import json
import math
from array import array
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.csv_input import Column, cells_of, find_column, separator_of, shown, text_lines
from cablewright.errors import InputError
from cablewright.toml_input import read_bytes
from cablewright.units import ANGLE, LENGTH

MAX_BYTES: Final = 8 << 20
MAX_POINTS: Final = 100_000
LARGEST_IN_M: Final = 60.0
"""Median range above which lengths without a unit are taken for mm: no room's lidar sees as far in m."""

_MAX_MEDIAN: Final = 1000.0  # m, of a room's ranges
_DISTANCE: Final = ("distance", "range", "ranges", "distances", "dist", "r")
_ANGLE: Final = ("angle", "bearing", "angles", "theta")
_NAMES: Final = {"x": ("x",), "y": ("y",), "angle": _ANGLE, "distance": _DISTANCE}
_EXPECTED: Final = "columns x,y or angle,distance"


class FileScan(NamedTuple):
    """A scan as read: bearings (rad, counter-clockwise) and ranges (m), NaN without an echo."""

    angles: Array  # (n,)
    ranges: Array  # (n,)
    length_unit: str  # of the file, or guessed
    angle_unit: str | None  # None for x and y
    guessed: tuple[str, ...]  # sentences on units that were guessed


class _Raw(NamedTuple):
    """Two columns as the file has them, and the size of their units in SI, None where it names none."""

    kind: str  # "xy" or "polar"
    first: Array  # x, or bearing
    second: Array  # y, or range
    sizes: tuple[float | None, float | None]


def read_scan(
    path: str | Path,
    unit: str | None = None,
    angle_unit: str | None = None,
    clockwise: bool = False,
    columns: Sequence[str] | None = None,
) -> FileScan:
    """Read a scan. ``unit`` (m, mm, ..) and ``angle_unit`` (rad, deg, ..): where the file does not name them.

    CSV: a header with columns ``x, y`` or ``angle, distance``, or none and ``columns``; cells separated by comma,
    semicolon, tab or blanks. JSON: a list of pairs x, y; of objects with these names; an object of such lists; or the
    laser scan of ROS (``angle_min, angle_increment, ranges``) or Foxglove (``start_angle, end_angle, ranges``). A
    range without an echo is 0, NaN, inf, null or an empty cell.

    Raises `InputError` where the file cannot be read, is over `MAX_BYTES` or `MAX_POINTS`, or holds no such points.
    """
    path = Path(path)
    raw = _of_json(path) if path.suffix.lower() == ".json" else _of_csv(path, columns)
    if not len(raw.first):
        raise InputError(f"{path}: no points; {_EXPECTED} are expected")
    given = _size(unit, LENGTH.units, "--unit"), _size(angle_unit, ANGLE.units, "--angle-unit")
    return _in_si(path, raw, given, clockwise)


def _size(unit: str | None, units: Mapping[str, Any], option: str) -> float | None:
    if unit is None:
        return None
    if unit not in units:
        raise InputError(f"{option} = {unit!r}: must be one of {', '.join(units)}")
    return float(units[unit])


def _in_si(path: Path, raw: _Raw, given: tuple[float | None, float | None], clockwise: bool) -> FileScan:
    """Turn columns into bearings and ranges; units that are neither named nor given are guessed."""
    length, angle = given
    guesses: list[str] = []
    if raw.kind == "xy":
        own = raw.sizes[0] if raw.sizes[0] == raw.sizes[1] else None
        if own is None and raw.sizes != (None, None):
            raise InputError(f"{path}: x and y have different units; give both the same")
        far = np.hypot(raw.first, raw.second)
    else:
        own, far = raw.sizes[1], raw.second
    size = _length_size(path, far, own if length is None else length, guesses)
    ranges = np.where(far > 0, far, math.nan) * size
    angle_unit = None
    if raw.kind == "xy":
        angles = np.arctan2(raw.second, raw.first)
    else:
        turn = _angle_size(raw.first, raw.sizes[0] if angle is None else angle, guesses)
        angles = raw.first * turn
        angle_unit = _name(turn, ANGLE.units)
    return FileScan(-angles if clockwise else angles, ranges, _name(size, LENGTH.units), angle_unit, tuple(guesses))


def _length_size(path: Path, far: Array, size: float | None, guesses: list[str]) -> float:
    seen = far[np.isfinite(far) & (far > 0)]
    typical = float(np.median(seen)) if len(seen) else 0.0
    if size is None:
        size = 1.0 if typical <= LARGEST_IN_M else 1e-3
        guesses.append(
            f"lengths taken as {'m' if size == 1 else 'mm'}: their median is {typical:.4g}; else give --unit"
        )
    if not typical * size <= _MAX_MEDIAN:
        raise InputError(f"{path}: the median range is {typical * size:.4g} m, too large for a room; check the unit")
    return size


def _angle_size(angles: Array, size: float | None, guesses: list[str]) -> float:
    if size is not None:
        return size
    finite = angles[np.isfinite(angles)]
    largest = float(np.abs(finite).max()) if len(finite) else 0.0
    unit = "rad" if largest <= math.tau + 0.1 else "deg"
    guesses.append(f"angles taken as {unit}: the largest is {largest:.4g}; else give --angle-unit")
    return float(ANGLE.units[unit])


def _name(size: float, units: Mapping[str, Any]) -> str:
    return next(unit for unit, own in units.items() if float(own) == size)


def _of_csv(path: Path, columns: Sequence[str] | None) -> _Raw:
    lines = text_lines(path, MAX_BYTES, "scan")
    number, text = next(lines, (0, ""))
    if not number:
        raise InputError(f"{path}: empty; {_EXPECTED} are expected")
    blanks = not any(mark in text for mark in ",;\t")
    separator = separator_of(text)

    def split(row: str) -> list[str]:
        return (row.split() or [""]) if blanks else cells_of(row, separator)

    header, place = split(text), f"{path}, line {number}"
    if _is_number(header[0]):
        if columns is None:
            raise InputError(f"{place}: no header; name the columns, as in --columns angle,distance")
        lines = chain([(number, text)], lines)
    header = header if columns is None else list(columns)
    kind, chosen = _chosen(header, place)
    values = array("d")
    for row, text in lines:
        cells = split(text)
        if len(cells) < len(header):
            raise InputError(f"{path}, line {row}: {len(cells)} cells; {len(header)} are expected")
        if len(values) == 2 * MAX_POINTS:
            raise InputError(f"{path}, line {row}: more than {MAX_POINTS} points; a scan may have no more")
        values.extend(_cell(cells[each.position], path, row, header[each.position]) for each in chosen)
    first, second = np.array(values).reshape(-1, 2).T
    return _Raw(kind, first, second, (chosen[0].size, chosen[1].size))


def _chosen(header: Sequence[str], place: str) -> tuple[str, tuple[Column, Column]]:
    """Find x and y, or bearing and range."""
    quantities = {"x": LENGTH, "y": LENGTH, "angle": ANGLE, "distance": LENGTH}
    found = {name: find_column(names, header, place, quantities[name]) for name, names in _NAMES.items()}
    for kind, (one, other) in (("xy", ("x", "y")), ("polar", ("angle", "distance"))):
        a, b = found[one], found[other]
        if a is not None and b is not None:
            return kind, (a, b)
    raise InputError(
        f"{place}: {_EXPECTED} are expected (a unit may follow, as in 'x (mm)'), not {shown(', '.join(header))}"
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cell(cell: str, path: Path, row: int, name: str) -> float:
    """Return a number, NaN for an empty cell."""
    if not cell:
        return math.nan
    if len(cell) <= 40 and _is_number(cell):
        return float(cell)
    raise InputError(f"{path}, line {row}: {name[:40]} = {shown(cell)}: must be a number; nan or nothing for no echo")


def _of_json(path: Path) -> _Raw:
    """Read lists of numbers, or a laser scan as ROS or Foxglove write it; these are SI by their own schemas."""
    data = read_bytes(path, MAX_BYTES, "scan")
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        why = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(f"{path}: not JSON: {why}") from None
    if isinstance(found, dict) and "points" in found:
        found = found["points"]
    found = _lists_by_name(path, found) if isinstance(found, list) else found
    if not isinstance(found, dict):
        raise InputError(f"{path}: a list of points or an object with lists is expected; {_EXPECTED}")
    for begin, end, per_step in (("angle_min", "angle_increment", True), ("start_angle", "end_angle", False)):
        if begin in found and end in found and "ranges" in found:
            ranges = _numbers(path, found["ranges"], "ranges")
            a, b = _numbers(path, [found[begin], found[end]], f"{begin} and {end}")
            angles = a + b * np.arange(len(ranges)) if per_step else np.linspace(a, b, len(ranges))
            return _Raw("polar", angles, ranges, (1.0, 1.0))
    lists = [key for key, value in found.items() if isinstance(value, list)]
    kind, chosen = _chosen(lists, str(path))
    keys = [lists[column.position] for column in chosen]
    first, second = (_numbers(path, found[key], key) for key in keys)
    if len(first) != len(second):
        raise InputError(f"{path}: {len(first)} of {keys[0]}, but {len(second)} of {keys[1]}")
    return _Raw(kind, first, second, (chosen[0].size, chosen[1].size))


def _lists_by_name(path: Path, points: list[Any]) -> dict[str, list[Any]]:
    """Turn a list of objects, or of pairs x, y, into lists of numbers by name."""
    if points and all(isinstance(one, dict) for one in points):
        return {key: [one.get(key) for one in points] for key in points[0]}
    for i, one in enumerate(points):
        if not isinstance(one, list) or len(one) < 2:
            raise InputError(f"{path}: point {i + 1} = {shown(json.dumps(one))}: a pair of numbers is expected")
    return {"x": [one[0] for one in points], "y": [one[1] for one in points]}


def _numbers(path: Path, values: Any, name: str) -> Array:
    """Return a list of numbers, NaN for null."""
    if not isinstance(values, list):
        raise InputError(f"{path}: {name} = {shown(json.dumps(values))}: a list of numbers is expected")
    if len(values) > MAX_POINTS:
        raise InputError(f"{path}: more than {MAX_POINTS} points; a scan may have no more")
    for i, value in enumerate(values):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise InputError(f"{path}: {name} {i + 1} = {shown(json.dumps(value))}: a number or null is expected")
    try:
        return np.array([math.nan if value is None else float(value) for value in values], dtype=np.float64)
    except OverflowError:
        raise InputError(f"{path}: {name}: a whole number of hundreds of digits; ranges are expected") from None
