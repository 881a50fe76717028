"""What a total station measured: shots at markers, from a GSI file or a CSV, capped and refused in one line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.calibration.survey.gsi import looks_like_gsi, read_blocks
from cablewright.csv_input import (
    Column,
    cells_of,
    find_column,
    no_column,
    read_number,
    separator_of,
    shown,
    text_lines,
    units_wanted,
)
from cablewright.errors import InputError
from cablewright.units import ANGLE, LENGTH, Dimension

Vector = tuple[float, float, float]

MAX_BYTES: Final = 4 << 20
MAX_SHOTS: Final = 5000
FARTHEST: Final = 1000.0
"""How far a marker may be from the station, m. Farther than this is a number in the wrong unit."""

_LONGEST_NAME: Final = 40

# Names that a column may have, the first of them for messages.
_POINT: Final = ("point", "point id", "point_id", "pt", "id", "name", "marker")
_CARTESIAN: Final = (("x", "east", "easting", "e"), ("y", "north", "northing", "n"), ("z", "height", "elevation", "h"))
_POLAR: Final = (
    ("hz", "horizontal angle", "horizontal", "azimuth"),
    ("v", "zenith angle", "zenith", "vertical"),
    ("slope", "slope distance", "distance", "sd"),
)


@dataclass(frozen=True)
class Shot:
    """One measurement of one marker.

    ``position``: m, z up, x east and y north of the instrument's own grid. ``sight``: m, from the instrument to the
    marker, None where the instrument's place is not known from the file.
    """

    point: str
    line: int  # of the file
    position: Vector
    sight: Vector | None = None


class Shots(NamedTuple):
    """What a file holds: the shots, and sentences on what was left out."""

    shots: tuple[Shot, ...]
    notes: tuple[str, ...]
    origin: str  # names the file in messages


def read_shots(path: str | Path) -> Shots:
    """Read a Leica GSI-8 or GSI-16 file, or a CSV with a header.

    A CSV has a column ``point`` and either ``x, y, z`` (also ``east, north, height``; m unless a unit follows) or
    ``hz, v, slope``: horizontal circle, clockwise; zenith angle; slope distance. Angles must name their unit.

    Raises `InputError` where the file cannot be read, is over `MAX_BYTES` or `MAX_SHOTS`, or holds what is no number.
    """
    path = Path(path)
    lines = text_lines(path, MAX_BYTES, "survey")
    number, text = next(lines, (0, ""))
    if not number:
        raise InputError(f"{path}: empty; a GSI file, or a CSV with columns point,x,y,z or point,hz,v,slope is wanted")
    if looks_like_gsi(text):
        return _of_gsi(path, _with_first(number, text, lines))
    return Shots(tuple(_of_csv(path, number, text, lines)), (), str(path))


def _with_first(number: int, text: str, rest: Iterator[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    yield number, text
    yield from rest


def of_polar(hz: float, v: float, slope: float) -> Vector:
    """Return east, north and up (m) of a sight: circle ``hz`` clockwise from north and zenith angle ``v`` in rad.

    The second face (a zenith angle over half a turn, the circle half a turn on) gives the same point.
    """
    level = slope * math.sin(v)
    return level * math.sin(hz), level * math.cos(hz), slope * math.cos(v)


def _of_csv(path: Path, number: int, header: str, lines: Iterator[tuple[int, str]]) -> Iterator[Shot]:
    separator = separator_of(header)
    cells = cells_of(header, separator)
    place = f"{path}, line {number}"
    point = _point_column(cells, place)
    columns, build = _columns(cells, place)
    for count, (number, text) in enumerate(lines):
        row, place = cells_of(text, separator), f"{path}, line {number}"
        if len(row) != len(cells):
            raise InputError(f"{place}: {len(row)} cells; the header has {len(cells)}")
        if count == MAX_SHOTS:
            raise InputError(f"{place}: more than {MAX_SHOTS} shots, the most a survey may have")
        values = [read_number(row[c.position], f"{place}: {name}") * (c.size or 1.0) for name, c in columns.items()]
        position, sight = build(values)
        yield _checked(Shot(_name(row[point], place), number, position, sight), place)


def _point_column(cells: Sequence[str], place: str) -> int:
    found = [i for i, cell in enumerate(cells) if cell.casefold() in _POINT]
    if len(found) != 1:
        many = "more than one column" if found else "no column"
        raise InputError(f"{place}: {many} 'point', the markers' names (also called {', '.join(_POINT[1:])})")
    return found[0]


def _columns(
    cells: Sequence[str], place: str
) -> tuple[Mapping[str, Column], Callable[[list[float]], tuple[Vector, Vector | None]]]:
    """Find the three columns of numbers, and how a row of them becomes position and sight."""
    polar = _found(_POLAR, cells, place)
    cartesian = _found(_CARTESIAN, cells, place)
    if len(cartesian) == 3:
        return cartesian, _as_cartesian
    if len(polar) < 3:
        wanted, others = (_POLAR, polar) if len(polar) > len(cartesian) else (_CARTESIAN, cartesian)
        missing = next(names for names in wanted if names[0] not in others)
        quantity = _dimension(missing[0])
        raise no_column(missing[0], cells, place, quantity, [names[0] for names in wanted])
    for name in ("hz", "v"):
        if polar[name].size is None:
            units = units_wanted(name, ANGLE).replace("may", "must")
            raise InputError(f"{place}: column {cells[polar[name].position]!r}: {units}")
    return polar, _as_polar


def _found(wanted: Sequence[Sequence[str]], cells: Sequence[str], place: str) -> dict[str, Column]:
    columns = {names[0]: find_column(names, cells, place, _dimension(names[0])) for names in wanted}
    return {name: column for name, column in columns.items() if column is not None}


def _dimension(name: str) -> Dimension:
    return ANGLE if name in ("hz", "v") else LENGTH


def _as_cartesian(values: list[float]) -> tuple[Vector, Vector | None]:
    x, y, z = values
    return (x, y, z), None


def _as_polar(values: list[float]) -> tuple[Vector, Vector | None]:
    sight = of_polar(*values)
    return sight, sight


def _of_gsi(path: Path, lines: Iterator[tuple[int, str]]) -> Shots:
    """Turn blocks into shots: coordinates where the block has them, else from angles and distance."""
    shots: list[Shot] = []
    notes: list[str] = []
    station: Vector | None = None
    instrument = None  # its height over the station's mark, m
    polar_seen: int | None = None
    for block in read_blocks(path, lines):
        place = f"{path}, line {block.line}"
        words = block.words
        moved = _station(words, station), words.get(88, instrument)
        if polar_seen is not None and moved != (station, instrument):
            once = "survey from one station, or export coordinates (words 81 to 83)"
            raise InputError(f"{place}: the station is another than at line {polar_seen}; {once}")
        station, instrument = moved
        if block.point is None or not {21, 22, 31, 81, 82, 83} & words.keys():
            continue
        if len(shots) == MAX_SHOTS:
            raise InputError(f"{place}: more than {MAX_SHOTS} shots, the most a survey may have")
        name = _name(block.point, place)
        if {81, 82, 83} <= words.keys():
            position = words[81], words[82], words[83]
            sight = None if station is None else _minus(position, (*station[:2], station[2] + (instrument or 0.0)))
        elif {21, 22, 31} <= words.keys() and words[31] > 0:
            polar_seen = block.line
            sight = of_polar(words[21], words[22], words[31])
            position = (sight[0], sight[1], sight[2] + (instrument or 0.0) - words.get(87, 0.0))
        else:
            notes.append(f"{name} at line {block.line} is left out: angles without a distance give no place")
            continue
        shots.append(_checked(Shot(name, block.line, position, sight), place))
    return Shots(tuple(shots), tuple(notes), str(path))


def _station(words: Mapping[int, float], before: Vector | None) -> Vector | None:
    return (words[84], words[85], words[86]) if {84, 85, 86} <= words.keys() else before


def _minus(one: Vector, other: Vector) -> Vector:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def _name(text: str, place: str) -> str:
    if not text or len(text) > _LONGEST_NAME or not text.isprintable():
        raise InputError(f"{place}: point = {shown(text)}: a name of 1 to {_LONGEST_NAME} letters is wanted")
    return text


def _checked(shot: Shot, place: str) -> Shot:
    away = math.hypot(*(shot.sight or (0.0, 0.0, 0.0)))
    if not away <= FARTHEST:
        what = f"point {shot.point!r} is {away:.6g} m from the instrument, {FARTHEST:g} m at most are sensible"
        raise InputError(f"{place}: {what}; check the units")
    return shot
