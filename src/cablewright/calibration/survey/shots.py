"""The measurements of a total station: shots at markers, read from a GSI file or a CSV with limits on size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.calibration.survey.gsi import Block, looks_like_gsi, read_blocks
from cablewright.foundation.csv_input import (
    Column,
    bare,
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
from cablewright.foundation.units import ANGLE, LENGTH, Dimension

Vector = tuple[float, float, float]

MAX_BYTES: Final = 4 << 20
MAX_SHOTS: Final = 5000
FARTHEST: Final = 1000.0
"""Max distance of a marker from the station, m. A larger number is in the wrong unit."""

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

    ``position``: m, x east, y north and z up in the instrument's own grid. ``sight``: m, from the instrument to the
    marker, None where the file does not give the instrument's position.
    """

    point: str
    line: int  # of the file
    position: Vector
    sight: Vector | None = None


class Shots(NamedTuple):
    """The shots of a file, and sentences on omitted shots."""

    shots: tuple[Shot, ...]
    notes: tuple[str, ...]
    origin: str  # the file's name in messages


def read_shots(path: str | Path) -> Shots:
    """Read a Leica GSI-8 or GSI-16 file, or a CSV with a header.

    A CSV has a column ``point`` and either ``x, y, z`` (also ``east, north, height``; m unless a unit follows) or
    ``hz, v, slope``: horizontal circle, clockwise; zenith angle; slope distance. Angles must name their unit.

    Raises `InputError` for a file that cannot be read, is over `MAX_BYTES` or `MAX_SHOTS`, or has a cell or word that
    is not a number.
    """
    path = Path(path)
    lines = text_lines(path, MAX_BYTES, "survey", longest=MAX_BYTES)  # GSI may be one line
    number, text, lines = header_of(lines)
    if not number:
        raise InputError(f"{path}: empty; expected GSI, or a CSV with columns point,x,y,z or point,hz,v,slope")
    if looks_like_gsi(text):
        return _of_gsi(path, chain([(number, text)], lines))
    notes: list[str] = []
    return Shots(tuple(_of_csv(path, number, text, lines, notes)), tuple(notes), str(path))


def of_polar(hz: float, v: float, slope: float) -> Vector:
    """Return east, north and up (m) of a sight from horizontal circle, zenith angle and slope distance.

    Angles are in rad: circle ``hz`` clockwise from north, zenith angle ``v``. The second face (a zenith angle over half
    a turn, the circle half a turn on) gives the same point.
    """
    level = slope * math.sin(v)
    return level * math.sin(hz), level * math.cos(hz), slope * math.cos(v)


def _of_csv(path: Path, number: int, header: str, lines: Iterator[tuple[int, str]], notes: list[str]) -> Iterator[Shot]:
    """Yield the shots of the rows; a row without a value is left out, with a note."""
    cells = cells_of(header, separator_of(header))
    place = f"{path}, line {number}"
    point = [i for i, cell in enumerate(cells) if cell.casefold() in _POINT]
    if len(point) != 1:
        many = "more than one column" if point else "no column"
        raise InputError(f"{place}: {many} 'point', the markers' names (also called {', '.join(_POINT[1:])})")
    columns = _columns(cells, place)
    for number, row, values in number_rows(path, lines, header, columns, MAX_SHOTS, "shots", blank=columns):
        place = f"{path}, line {number}"
        missing = [name for name, value in zip(columns, values, strict=True) if math.isnan(value)]
        if missing:
            notes.append(f"{_name(bare(row[point[0]]), place)} at line {number} is left out: {missing[0]} has no value")
            continue
        endless = next((name for name, value in zip(columns, values, strict=True) if math.isinf(value)), None)
        if endless is not None:
            raise InputError(f"{place}: {endless}: must be a finite number")
        sight = of_polar(*values) if "hz" in columns else None
        x, y, z = sight or values
        yield _checked(Shot(_name(bare(row[point[0]]), place), number, (x, y, z), sight), place)


def _columns(cells: Sequence[str], place: str) -> dict[str, Column]:
    """Return the three columns of numbers by name: Cartesian ones if the header has them, else polar ones."""
    cartesian, polar = _found(_CARTESIAN, cells, place), _found(_POLAR, cells, place)
    if len(cartesian) == 3:
        return cartesian
    if len(polar) < 3:
        names, found = (_POLAR, polar) if len(polar) > len(cartesian) else (_CARTESIAN, cartesian)
        missing = next(each for each in names if each[0] not in found)
        raise no_column(missing, cells, place, _dimension(missing[0]))
    for name in ("hz", "v"):
        if polar[name].size is None:
            units = units_wanted(name, ANGLE).replace("may", "must")
            raise InputError(f"{place}: column {cells[polar[name].position]!r}: {units}")
    return polar


def _found(names: Sequence[Sequence[str]], cells: Sequence[str], place: str) -> dict[str, Column]:
    columns = {each[0]: find_column(each, cells, place, _dimension(each[0])) for each in names}
    return {name: column for name, column in columns.items() if column is not None}


def _dimension(name: str) -> Dimension:
    return ANGLE if name in ("hz", "v") else LENGTH


def _of_gsi(path: Path, lines: Iterator[tuple[int, str]]) -> Shots:
    """Return the shots of the blocks: coordinates where a block has them, else from angles and distance."""
    shots: list[Shot] = []
    notes: list[str] = []
    station: Vector | None = None
    height: float | None = None  # of the instrument over the station's mark, m
    polar_line: int | None = None  # of the file, of the last polar shot
    setup: tuple[str, ...] = ()  # the codes before the first polar shot
    between: list[Block] = []  # blocks of codes after a polar shot
    for block in read_blocks(path, lines):
        place, words = f"{path}, line {block.line}", block.words
        if block.codes and polar_line is None:
            setup = block.codes
        elif block.codes:
            between.append(block)
        new_station, new_height = _station(words, station), words.get(88, height)
        if polar_line is not None and (new_station, new_height) != (station, height):
            raise InputError(
                f"{place}: the station differs from that of line {polar_line}; survey from one station, or export "
                "coordinates (words 81 to 83)"
            )
        station, height = new_station, new_height
        if block.point is None or not {21, 22, 31, 81, 82, 83} & words.keys():
            continue
        if len(shots) == MAX_SHOTS:
            raise InputError(f"{place}: more than {MAX_SHOTS} shots, the maximum of a survey; split the file")
        name, sight = _name(block.point, place), None
        if {81, 82, 83} <= words.keys():
            position = words[81], words[82], words[83]
            if station is not None:
                sight = position[0] - station[0], position[1] - station[1], position[2] - (station[2] + (height or 0.0))
        elif {21, 22, 31} <= words.keys() and words[31] > 0:
            _require_one_station(path, block, between, setup)
            polar_line = block.line
            sight = of_polar(words[21], words[22], words[31])
            position = sight[0], sight[1], sight[2] + (height or 0.0) - words.get(87, 0.0)
        else:
            notes.append(f"{name} at line {block.line} is left out: angles without a distance give no position")
            continue
        shots.append(_checked(Shot(name, block.line, position, sight), place))
    if between:
        count, line = len(between), between[0].line
        notes.append(
            f"{count} block{'s' * (count > 1)} of codes, the first at line {line}: taken for remarks on points"
        )
    return Shots(tuple(shots), tuple(notes), str(path))


def _require_one_station(path: Path, sight: Block, between: Sequence[Block], setup: tuple[str, ...]) -> None:
    """Raise `InputError` for a *sight* after codes *between* sights that may begin a station: a code with a text.

    A block like that before the first sight, *setup*, says nothing new; a code alone is of a point.
    """
    for block in between:
        if len(block.codes) > 1 and block.codes != setup:
            raise InputError(
                f"{path}, line {block.line}: a block of codes, {shown(', '.join(block.codes))}, before the sight at "
                f"line {sight.line} may begin another station; one station is allowed: survey from one, export "
                "coordinates (words 81 to 83), or delete the block where it is a remark"
            )


def _station(words: Mapping[int, float], before: Vector | None) -> Vector | None:
    return (words[84], words[85], words[86]) if {84, 85, 86} <= words.keys() else before


def _name(text: str, place: str) -> str:
    if not text or len(text) > _LONGEST_NAME or not text.isprintable():
        raise InputError(f"{place}: point = {shown(text)}: expected a name of 1 to {_LONGEST_NAME} characters")
    return text


def _checked(shot: Shot, place: str) -> Shot:
    away = math.hypot(*(shot.sight or (0.0, 0.0, 0.0)))
    if not away <= FARTHEST:
        raise InputError(
            f"{place}: point {shot.point!r} is {away:.6g} m from the instrument, over the limit of {FARTHEST:g} m; "
            "check the units"
        )
    return shot
