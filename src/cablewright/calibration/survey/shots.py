"""The measurements of a total station: shots at markers, read from a GSI file or a CSV with limits on size."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple

from cablewright.calibration.survey.gsi import looks_like_gsi, read_blocks
from cablewright.calibration.survey.gsi_setup import MEASURED, GsiSetup, Vector
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
_REFLECTOR, _INSTRUMENT, _STATION = "reflector height", "instrument height", "station"
_HEIGHT = "height|hohe|hauteur|altura|altezza|hgt|ht$"
_ROD = "refle[ck]t|target|ziel|prism|spiegel|rod|pole|staff|stab"
_TRIPOD = "inst|strument|appare|kippachs|theodolit|ta[ck]h|tripod|stativ"
_OF_SIGHTS: Final = {
    _REFLECTOR: re.compile(
        f"^([hrt]h|h[rt]|hot)$|^h({_ROD})|({_ROD})(or)?h$|({_ROD}).*({_HEIGHT})|({_HEIGHT}).*({_ROD})"
    ),
    _INSTRUMENT: re.compile(
        f"^(hi|ih|hoi)$|^h({_TRIPOD})|({_TRIPOD})(r|rument)?h$|({_TRIPOD}).*({_HEIGHT})|({_HEIGHT}).*({_TRIPOD})"
    ),
    _STATION: re.compile("station|standpunkt|setup|occup|^(from|von)$|^(stn|sta|stat|stp|stand)(nr|no|id|pt|name)?$"),
}
"""Columns of sights by their letters, of a name up to `_LONGEST_NAME`, without marks above them and its unit."""
_LEVEL: Final = re.compile(r"^(?:hd(?![a-z])|hdist|hori[a-z]*[ _.-]*dist|dist[a-z]*[ _.,-]*hori)")
"""Distances that are no slope distances."""
_TALLEST: Final = 20.0  # m, of a reflector's rod or a tripod
_LARGEST: Final = 1e300  # of a finite number
_MOST_NAMED: Final = 6  # columns in a note


@dataclass(frozen=True)
class Shot:
    """One measurement of one marker.

    ``position``: m, x east, y north and z up in the instrument's own grid. ``sight``: m, from the instrument to the
    marker, None where the file does not give the instrument's position. ``reflector``: m, height over the marker at
    which the sight ends.
    """

    point: str
    line: int  # of the file
    position: Vector
    sight: Vector | None = None
    reflector: float = 0.0


class Shots(NamedTuple):
    """The shots of a file, and sentences on omitted shots."""

    shots: tuple[Shot, ...]
    notes: tuple[str, ...]
    origin: str  # the file's name in messages


def read_shots(path: str | Path) -> Shots:
    """Read a Leica GSI-8 or GSI-16 file, or a CSV with a header.

    A CSV has a column ``point`` and either ``x, y, z`` (also ``east, north, height``; m unless a unit follows) or
    ``hz, v, slope``: horizontal circle, clockwise; zenith angle; slope distance. Angles must name their unit.
    Sights may have columns of the heights of reflector and instrument, and of the station. A note lists other columns.

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
    is_polar = "hz" in columns
    heights, stations = _of_sights(cells, place) if is_polar else ({}, [])
    columns |= heights
    known = {point[0], *stations, *(each.position for each in columns.values())}
    unread = [shown(cell) for at, cell in enumerate(cells) if cell and at not in known]
    if unread:
        more = f" and {len(unread) - _MOST_NAMED} more" if len(unread) > _MOST_NAMED else ""
        notes.append(f"columns that are not read: {', '.join(unread[:_MOST_NAMED])}{more}")
    before: dict[int, tuple[str, int]] = {}
    for number, row, values in number_rows(path, lines, header, columns, MAX_SHOTS, "shots", blank=columns):
        place = f"{path}, line {number}"
        for at in stations:
            text = bare(row[at])
            if text.strip("-") and text != before.setdefault(at, (text, number))[0]:
                was, line = before[at]
                raise InputError(
                    f"{place}: {shown(cells[at])} is {shown(text)}, {shown(was)} at line {line}: sights from one "
                    "station are allowed; survey from one, or export coordinates x, y, z in one grid"
                )
        given = dict(zip(columns, values, strict=True))
        missing = next((name for name, value in given.items() if math.isnan(value)), None)
        if missing is not None:
            notes.append(f"{_name(bare(row[point[0]]), place)} at line {number} is left out: {missing} has no value")
            continue
        wrong = next((n for n, v in given.items() if abs(v) > (_TALLEST if n in heights else _LARGEST)), None)
        if wrong is not None:
            most = f"at most {_TALLEST:g} m; give its unit in the header" if wrong in heights else "a finite number"
            raise InputError(f"{place}: {wrong}: must be {most}")
        sight = of_polar(*values[:3]) if is_polar else None
        x, y, z = sight or values[:3]
        reflector = given.get(_REFLECTOR, 0.0)
        z += given.get(_INSTRUMENT, 0.0) - reflector
        yield _checked(Shot(_name(bare(row[point[0]]), place), number, (x, y, z), sight, reflector), place)


def _of_sights(cells: Sequence[str], place: str) -> tuple[dict[str, Column], list[int]]:
    """Return the columns of the heights of sights, and positions of all columns that have one value at a station.

    Coordinates have the heights in them. Raises `InputError` for two heights of one kind, or an unknown unit.
    """
    heights: dict[str, Column] = {}
    stations: list[int] = []
    for at, cell in enumerate(cells):
        name, mark, unit = cell[:_LONGEST_NAME].replace("[", "(").partition("(")
        words = re.findall("[a-z]+", unicodedata.normalize("NFKD", name).casefold().replace("oe", "o"))
        if not mark and words and words[-1] in LENGTH.units:
            mark, unit = "(", words.pop()
        kind = next((kind for kind, pattern in _OF_SIGHTS.items() if pattern.search("".join(words))), None)
        if kind in heights:
            raise InputError(f"{place}: more than one column {kind!r}, {shown(cell)} is one; keep one")
        if kind in (_REFLECTOR, _INSTRUMENT):
            found = find_column((kind,), [f"{kind} ({unit.strip(')] ')})" if mark else kind], place, LENGTH)
            heights[kind] = Column(at, None if found is None else found.size)
        if kind in (_STATION, _INSTRUMENT):
            stations.append(at)
    return heights, stations


def _columns(cells: Sequence[str], place: str) -> dict[str, Column]:
    """Return the three columns of numbers by name: Cartesian ones if the header has them, else polar ones."""
    cartesian, polar = _found(_CARTESIAN, cells, place), _found(_POLAR, cells, place)
    if len(cartesian) == 3:
        return cartesian
    level = [cell for cell in cells if _LEVEL.search(cell[:_LONGEST_NAME].casefold())]
    if "slope" not in polar and {"hz", "v"} <= polar.keys() and level:
        raise InputError(
            f"{place}: {shown(level[0])} is no slope distance: export slope distances, 'slope', or coordinates x, y, z"
        )
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
    setup = GsiSetup(str(path))
    coordinates: int | None = None  # the first line with some
    for block in read_blocks(path, lines):
        place, words = f"{path}, line {block.line}", block.words
        setup.follow(block)
        if block.point is None or MEASURED.isdisjoint(words.keys() | block.blank):
            continue
        if len(shots) == MAX_SHOTS:
            raise InputError(f"{place}: more than {MAX_SHOTS} shots, the maximum of a survey; split the file")
        name, reflector = _name(block.point, place), 0.0
        is_polar = {21, 22, 31} <= words.keys() and words[31] > 0
        sight = of_polar(words[21], words[22], words[31]) if is_polar else None
        if {81, 82, 83} <= words.keys():
            position, coordinates = (words[81], words[82], words[83]), coordinates or block.line
            if sight is not None:
                setup.compare(block, position, sight)
            axis = setup.axis
            sight = axis and (position[0] - axis[0], position[1] - axis[1], position[2] - axis[2])
        elif sight is not None:
            position, reflector = setup.sight(block, sight)
        else:
            notes.append(f"{name} at line {block.line} is left out: no coordinates, nor angles with a slope distance")
            continue
        shots.append(_checked(Shot(name, block.line, position, sight, reflector), place))
    if setup.sighted and coordinates is not None:
        notes.append(setup.require_one_grid(coordinates))
    if setup.remarks:
        count, line = len(setup.remarks), setup.remarks[0].line
        notes.append(
            f"{count} block{'s' * (count > 1)} of codes, the first at line {line}: taken for remarks on points"
        )
    return Shots(tuple(shots), tuple(notes), str(path))


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
