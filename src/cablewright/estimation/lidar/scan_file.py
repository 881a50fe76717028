"""Reads a planar lidar's scan from a CSV, JSON or text file of any origin: size capped, errors in one line.

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

from cablewright.estimation.lidar.ros_scan_text import BEGINS, read_dumps
from cablewright.foundation.arrays import Array
from cablewright.foundation.csv_input import Column, cells_of, find_column, separator_of, shown, text_lines
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.units import ANGLE, LENGTH

MAX_BYTES: Final = 8 << 20
MAX_POINTS: Final = 100_000
LARGEST_IN_M: Final = 60.0
"""Median range above which lengths without a unit are taken for mm: no room's lidar sees as far in m."""

_MAX_MEDIAN: Final = 1000.0  # m, of a room's ranges
_MIN_MEDIAN: Final = 0.02  # m, likewise
_MAX_TURNS: Final = 10.0  # of a scan's bearings
_NARROW: Final = math.radians(15.0)  # bearings of a whole scan that are so near each other are in a wrong unit, or odd
_DISTANCE: Final = ("distance", "range", "ranges", "distances", "dist", "r")
_ANGLE: Final = ("angle", "bearing", "angles", "theta")
_NAMES: Final = {"x": ("x",), "y": ("y",), "angle": _ANGLE, "distance": _DISTANCE}
_EXPECTED: Final = "columns x,y or angle,distance"
_DEVICE: Final = ("device", "device_id", "lidar", "sensor", "sensor_id", "topic", "frame", "frame_id")
_SCANS: Final = (("angle_min", "angle_increment", True), ("start_angle", "end_angle", False))
_NOT_FINITE: Final = {"nan": math.nan, "inf": math.inf, "infinity": math.inf, "-inf": -math.inf, "-infinity": -math.inf}


class FileScan(NamedTuple):
    """A scan as read from a file: bearings (rad, counter-clockwise) and ranges (m), NaN without an echo."""

    angles: Array  # (n,)
    ranges: Array  # (n,)
    length_unit: str  # of the file, or guessed
    angle_unit: str | None  # None for x and y
    guessed: tuple[str, ...]  # sentences on guessed units, and on other choices
    device: str | None = None  # column, topic or frame that names it in the file


class _Raw(NamedTuple):
    """Two columns as the file has them, and the size of their units in SI, None where it names none."""

    kind: str  # "xy" or "polar"
    first: Array  # x, or bearing
    second: Array  # y, or range
    sizes: tuple[float | None, float | None]
    device: str | None = None
    has_quality: bool = False  # each point has one, as RPLIDARs give it


def read_scan(
    path: str | Path,
    unit: str | None = None,
    angle_unit: str | None = None,
    clockwise: bool = False,
    columns: Sequence[str] | None = None,
    device: str | None = None,
) -> FileScan:
    """Read a planar lidar's scan from a file.

    ``unit`` (m, mm, ..) and ``angle_unit`` (rad, deg, ..): where the file does not name them. CSV: a header with
    columns ``x, y`` or ``angle, distance``, or none and ``columns``; cells separated by comma, semicolon, tab or
    blanks. JSON: a list of pairs x, y; of objects with these names, those with ``quality`` 0 left out; an object of
    such lists; or the laser scan of ROS (``angle_min, angle_increment, ranges``) or Foxglove (``start_angle, end_angle,
    ranges``), or several in a list or by name. YAML: scans as ROS prints them. A range without an echo is 0, NaN, inf,
    null or an empty cell. ``device`` chooses among several in one file by the name in a column ``device``, ``lidar``,
    ``sensor``, ``topic`` or ``frame_id``, or in a key of that name. Of several scans of one device the first is read.

    Raises `InputError` where the file cannot be read, is over `MAX_BYTES` or `MAX_POINTS`, holds no such points, or
    several devices and none is chosen.
    """
    path = Path(path)
    raw, chosen = _of_device(path, _parts(path, columns), device)
    if not len(raw.first):
        raise InputError(f"{path}: no points; {_EXPECTED} are expected")
    given = _size(unit, LENGTH.units, "--unit"), _size(angle_unit, ANGLE.units, "--angle-unit")
    return _in_si(path, raw, given, clockwise, chosen)


def _parts(path: Path, columns: Sequence[str] | None) -> list[_Raw]:
    """Read the scans in a file, by its name's end or, where that says nothing, by its first characters."""
    end = path.suffix.lower()
    begin = (
        b"" if end in (".csv", ".tsv") else read_bytes(path, MAX_BYTES, "scan")[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    )
    if end == ".json" or (end not in (".yaml", ".yml") and begin[:1] in (b"{", b"[")):
        return _of_json(path)
    if end in (".yaml", ".yml") or BEGINS.match(begin):
        return [part for one in read_dumps(path, read_bytes(path, MAX_BYTES, "scan")) for part in _of_found(path, one)]
    return _of_csv(path, columns)


def _of_device(path: Path, parts: Sequence[_Raw], device: str | None) -> tuple[_Raw, list[str]]:
    """Return the scan of a device, and what was chosen in sentences."""
    names = sorted({part.device for part in parts if part.device is not None})
    listed = ", ".join(shown(name) for name in names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
    if device is not None and device not in names:
        has = f"must be one of {listed}" if names else "the file names no device"
        raise InputError(f"{path}: --device = {shown(device)}: {has}")
    if device is None and len({part.device for part in parts}) > 1:
        raise InputError(f"{path}: scans of {len(names)} devices: {listed}; choose one with --device")
    own = [part for part in parts if device is None or part.device == device]
    if not own:
        raise InputError(f"{path}: no points; {_EXPECTED} are expected")
    return own[0], [f"the first of {len(own)} scans in the file is used"] if len(own) > 1 else []


def _size(unit: str | None, units: Mapping[str, Any], option: str) -> float | None:
    if unit is None:
        return None
    if unit not in units:
        raise InputError(f"{option} = {unit!r}: must be one of {', '.join(units)}")
    return float(units[unit])


def _in_si(
    path: Path, raw: _Raw, given: tuple[float | None, float | None], clockwise: bool, guesses: list[str]
) -> FileScan:
    """Turn columns into bearings and ranges; units that are neither named nor given are guessed."""
    length, angle = given
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
        turn = raw.sizes[0] if angle is None else angle
        if turn is None and raw.has_quality and _name(size, LENGTH.units) == "mm":
            turn = float(ANGLE.units["deg"])
            guesses.append("angles taken as deg, as RPLIDARs give them with a quality; else give --angle-unit")
        turn = _angle_size(raw.first, turn, guesses)
        if raw.has_quality and not clockwise:
            guesses.append("angles taken as counter-clockwise; RPLIDARs count clockwise: then give --clockwise")
        angles = raw.first * turn
        angle_unit = _name(turn, ANGLE.units)
        _check_bearings(path, angles, angle_unit, guesses)
    chosen = -angles if clockwise else angles
    return FileScan(chosen, ranges, _name(size, LENGTH.units), angle_unit, tuple(guesses), raw.device)


def _check_bearings(path: Path, angles: Array, unit: str, guesses: list[str]) -> None:
    finite = angles[np.isfinite(angles)]
    span = float(np.ptp(finite)) if len(finite) else 0.0
    if span > _MAX_TURNS * math.tau:
        raise InputError(f"{path}: angles in {unit} span {span / math.tau:.4g} turns; check the unit, --angle-unit")
    if len(finite) >= 90 and 0.0 < span < _NARROW:
        guesses.append(f"angles in {unit} span {math.degrees(span):.3g} deg only; check the unit, --angle-unit")


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
    if 0.0 < typical * size < _MIN_MEDIAN:
        raise InputError(f"{path}: the median range is {typical * size:.4g} m, too small for a room; check the unit")
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


def _of_csv(path: Path, columns: Sequence[str] | None) -> list[_Raw]:
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
    device = next((i for i, name in enumerate(header) if name.casefold() in _DEVICE), None)
    values, rows_of = array("d"), dict[str | None, list[int]]()
    for row, text in lines:
        cells = split(text)
        if len(cells) < len(header):
            raise InputError(f"{path}, line {row}: {len(cells)} cells; {len(header)} are expected")
        if len(values) == 2 * MAX_POINTS:
            raise InputError(
                f"{path}, line {row}: more than {MAX_POINTS} points, the maximum of a scan; give a single scan"
            )
        rows_of.setdefault(None if device is None else cells[device], []).append(len(values) // 2)
        values.extend(_cell(cells[each.position], path, row, header[each.position]) for each in chosen)
    table = np.array(values).reshape(-1, 2)
    sizes = chosen[0].size, chosen[1].size
    return [_Raw(kind, table[some, 0], table[some, 1], sizes, name) for name, some in rows_of.items()]


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


def _of_json(path: Path) -> list[_Raw]:
    """Read lists of numbers, or laser scans."""
    data = read_bytes(path, MAX_BYTES, "scan")
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        why = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(f"{path}: not JSON: {why}") from None
    if isinstance(found, list) and found and all(isinstance(one, dict) and _is_scan(one) for one in found):
        return [part for one in found for part in _of_found(path, one)]
    if isinstance(found, dict) and found and not _is_scan(found) and all(map(_is_part, found.values())):
        return [part._replace(device=name) for name, one in found.items() for part in _of_found(path, one)]
    return _of_found(path, found)


def _is_scan(found: Mapping[str, Any]) -> bool:
    """Whether it is a laser scan, or a message with one."""
    return "ranges" in found or any(isinstance(found.get(key), dict) for key in ("message", "msg"))


def _is_part(found: object) -> bool:
    """Whether it can be all that one of several devices has seen."""
    if isinstance(found, dict):
        return _is_scan(found) or "points" in found
    return isinstance(found, list) and bool(found) and isinstance(found[0], dict | list)


def _of_found(path: Path, found: Any, device: str | None = None) -> list[_Raw]:
    """Read one object or list; laser scans as ROS and Foxglove write them are SI by their own schemas."""
    if isinstance(found, dict):
        device = device or _device_of(found)
        for key in ("message", "msg"):
            if isinstance(found.get(key), dict):
                return _of_found(path, found[key], device)
    if isinstance(found, dict) and "points" in found:
        found = found["points"]
    if isinstance(found, list) and found and all(isinstance(one, dict) for one in found):
        return _of_objects(path, found, device)
    found = _lists_by_name(path, found) if isinstance(found, list) else found
    if not isinstance(found, dict):
        raise InputError(f"{path}: a list of points or an object with lists is expected; {_EXPECTED}")
    for begin, end, per_step in _SCANS:
        if begin in found and end in found and "ranges" in found:
            ranges = _within(found, _numbers(path, found["ranges"], "ranges"))
            a, b = _numbers(path, [found[begin], found[end]], f"{begin} and {end}")
            angles = a + b * np.arange(len(ranges)) if per_step else np.linspace(a, b, len(ranges))
            return [_Raw("polar", angles, ranges, (1.0, 1.0), device)]
    return [_of_lists(path, found, device)]


def _of_lists(path: Path, found: Mapping[str, Any], device: str | None) -> _Raw:
    lists = [key for key, value in found.items() if isinstance(value, list)]
    kind, chosen = _chosen(lists, str(path))
    keys = [lists[column.position] for column in chosen]
    first, second = (_numbers(path, found[key], key) for key in keys)
    if len(first) != len(second):
        raise InputError(f"{path}: {len(first)} of {keys[0]}, but {len(second)} of {keys[1]}")
    raw = _Raw(kind, first, second, (chosen[0].size, chosen[1].size), device, "quality" in lists and kind == "polar")
    if not raw.has_quality:
        return raw
    quality = _numbers(path, found["quality"], "quality")
    if len(quality) != len(second):
        raise InputError(f"{path}: {len(second)} of {keys[1]}, but {len(quality)} of quality")
    return raw._replace(second=np.where(quality == 0.0, math.nan, second)) if quality.any() else raw


def _of_objects(path: Path, points: Sequence[dict[str, Any]], device: str | None) -> list[_Raw]:
    """Read points that are objects, apart by the device that they name."""
    by_device: dict[str | None, list[dict[str, Any]]] = {}
    for one in points:
        by_device.setdefault(device or _device_of(one), []).append(one)
    lists = {name: {key: [one.get(key) for one in own] for key in own[0]} for name, own in by_device.items()}
    return [_of_lists(path, own, name) for name, own in lists.items()]


def _device_of(found: Mapping[str, Any]) -> str | None:
    """Return the device that an object names, itself or in its header."""
    header = found.get("header")
    named = (*(found.get(key) for key in _DEVICE), header.get("frame_id") if isinstance(header, dict) else None)
    return next((name for name in named if isinstance(name, str) and name), None)


def _within(found: Mapping[str, Any], ranges: Array) -> Array:
    """Return *ranges*, NaN outside the limits that a ROS message gives: those are no echoes."""
    low, high = found.get("range_min"), found.get("range_max")
    if not (isinstance(low, int | float) and isinstance(high, int | float) and low < high):
        return ranges
    return np.where((ranges >= low) & (ranges <= high), ranges, math.nan)


def _lists_by_name(path: Path, points: list[Any]) -> dict[str, list[Any]]:
    """Turn a list of pairs x, y into lists of numbers by name."""
    for i, one in enumerate(points):
        if not isinstance(one, list) or len(one) < 2:
            raise InputError(f"{path}: point {i + 1} = {shown(json.dumps(one))}: a pair of numbers is expected")
    return {"x": [one[0] for one in points], "y": [one[1] for one in points]}


def _numbers(path: Path, values: Any, name: str) -> Array:
    """Return a list of numbers, NaN for null; texts such as "inf" and "NaN" are numbers too."""
    if not isinstance(values, list):
        raise InputError(f"{path}: {name} = {shown(json.dumps(values))}: a list of numbers is expected")
    if len(values) > MAX_POINTS:
        raise InputError(f"{path}: more than {MAX_POINTS} points, the maximum of a scan; give a single scan")
    values = [_NOT_FINITE.get(each.casefold(), each) if isinstance(each, str) else each for each in values]
    for i, value in enumerate(values):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise InputError(f"{path}: {name} {i + 1} = {shown(json.dumps(value))}: a number or null is expected")
    try:
        return np.array([math.nan if value is None else float(value) for value in values], dtype=np.float64)
    except OverflowError:
        raise InputError(f"{path}: {name}: a whole number of hundreds of digits; ranges are expected") from None
