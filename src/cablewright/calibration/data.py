"""The measurements of a calibration in and out of CSV: capped, and refused in one line that says where."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.problem import Measured
from cablewright.csv_input import cells_of, find_column, read_number, separator_of, shown, text_lines
from cablewright.errors import InputError, suggestion
from cablewright.robot import Robot
from cablewright.units import ANGLE, FORCE, LENGTH, Dimension

MAX_BYTES: Final = 32 << 20
MAX_POSES: Final = 5_000

_LARGEST: Final = 1e9
_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")


class _DataColumns(NamedTuple):
    """How rows are to be read: the cells in a row, and the position and the unit's size of each known column."""

    separator: str
    width: int
    columns: dict[str, tuple[int, float]]


def read_measured(path: str | Path, robot: Robot) -> Measured:
    """Read a CSV with a column ``dl_1`` .. ``dl_m`` for each line: the change of its length since home.

    Optional: ``x,y,z`` (and ``rx,ry,rz`` of a rigid platform), guesses of the poses, or with ``sigma_x`` ..
    measurements of them; ``f_1`` .., tensions; ``swivel_1`` .., azimuths; ``tilt_x,tilt_y``. A unit may follow a name:
    ``dl_1 (mm)``; without it numbers are SI. Cells are apart by tab, semicolon or comma. Comments begin with ``#``.

    Raises `InputError` where it is no such file: a column missing, unknown or there twice, part of a group missing, a
    row of another width, a cell that is no finite number.
    """
    path = Path(path)
    rows = text_lines(path, MAX_BYTES, "table of measurements")
    number, text = next(rows, (0, ""))
    if not number:
        raise InputError(f"{path}: empty; a header with columns dl_1 to dl_{robot.m}, and rows of numbers are wanted")
    table = _header(text, f"{path}, line {number}", robot)
    values = {name: array("d") for name in table.columns}
    places = array("q")
    for number, text in rows:
        if len(places) == MAX_POSES:
            raise InputError(f"{path}, line {number}: more than {MAX_POSES} poses, the most that are taken")
        cells = text.split(table.separator)
        if len(cells) != table.width:
            raise InputError(f"{path}, line {number}: {len(cells)} cells; the header has {table.width}")
        for name, (position, size) in table.columns.items():
            value = read_number(cells[position], f"{path}, line {number}: {name}")
            if abs(value) > _LARGEST:
                raise InputError(f"{path}, line {number}: {name} = {value:g}: must be at most {_LARGEST:g} in size")
            values[name].append(value * size)
        places.append(number)
    if not places:
        raise InputError(f"{path}: a header, but no poses")
    columns = {name: np.array(column) for name, column in values.items()}

    def group(names: Sequence[str]) -> Array | None:
        return np.column_stack([columns[name] for name in names]) if names[0] in columns else None

    pose = _POSE[: robot.n]
    guess = group(pose[:3])
    if guess is not None and robot.n == 6:  # the position alone means unrotated
        turned = group(pose[3:])
        guess = np.column_stack([guess, np.zeros_like(guess) if turned is None else turned])
    counted = group(_numbered("dl", robot))
    assert counted is not None
    sigma = group([f"sigma_{name}" for name in pose])
    if sigma is not None and not (sigma > 0.0).all():
        row = int(np.argmin((sigma > 0.0).all(axis=1)))
        raise InputError(f"{path}, line {places[row]}: sigma_{pose[int(np.argmin(sigma[row]))]}: must be over 0")
    return Measured(
        counted,
        guess,
        sigma,
        group(_numbered("f", robot)),
        group(_numbered("swivel", robot)),
        group(["tilt_x", "tilt_y"]),
        places,
        str(path),
    )


def _numbered(name: str, robot: Robot) -> list[str]:
    return [f"{name}_{i + 1}" for i in range(robot.m)]


def _known(robot: Robot) -> dict[str, Dimension]:
    """Columns and what they hold."""
    pose = {name: LENGTH if at < 3 else ANGLE for at, name in enumerate(_POSE[: robot.n])}
    return (
        dict.fromkeys(_numbered("dl", robot), LENGTH)
        | pose
        | {f"sigma_{name}": quantity for name, quantity in pose.items()}
        | dict.fromkeys(_numbered("f", robot), FORCE)
        | dict.fromkeys((*_numbered("swivel", robot), "tilt_x", "tilt_y"), ANGLE)
    )


def _header(text: str, place: str, robot: Robot) -> _DataColumns:
    separator = separator_of(text)
    cells = cells_of(text, separator)
    known, columns = _known(robot), dict[str, tuple[int, float]]()
    for name, quantity in known.items():
        found = find_column((name,), cells, place, quantity)
        if found is not None:
            columns[name] = found.position, 1.0 if found.size is None else found.size
    taken = {position for position, _ in columns.values()}
    for position, cell in enumerate(cells):
        if position not in taken:
            raise InputError(f"{place}: unknown column {shown(cell)}; {_hint(cell[:60].casefold(), known, robot)}")
    _check_groups(columns, place, robot)
    return _DataColumns(separator, len(cells), columns)


def _hint(name: str, known: dict[str, Dimension], robot: Robot) -> str:
    head, _, digits = name.rpartition("_")
    if head in ("dl", "f", "swivel") and digits.isdecimal():
        return f"{robot.name!r} has {robot.m} lines"
    return suggestion(name, known, limit=20)


def _check_groups(columns: dict[str, tuple[int, float]], place: str, robot: Robot) -> None:
    """Raise `InputError` unless groups of columns are whole."""
    pose = _POSE[: robot.n]
    for wanted, names in (
        (True, _numbered("dl", robot)),
        (False, pose[:3]),
        (False, pose[3:]),
        (False, [f"sigma_{name}" for name in pose]),
        (False, _numbered("f", robot)),
        (False, _numbered("swivel", robot)),
        (False, ["tilt_x", "tilt_y"]),
    ):
        missing = [name for name in names if name not in columns]
        if missing and (wanted or len(missing) < len(names)):
            told = f"{names[0]} to {names[-1]}" if len(names) > 2 else " and ".join(names)
            raise InputError(f"{place}: no column {missing[0]!r}; {told} are wanted, one of each line or axis")
    for name in pose:
        if f"sigma_{name}" in columns and name not in columns:
            raise InputError(f"{place}: sigma_{name}, but no column {name!r} that it is of")
    if "rx" in columns and "x" not in columns:
        raise InputError(f"{place}: rx, ry and rz, but no column 'x'")


def write_measured(measured: Measured, robot: Robot, comments: Sequence[str] = ()) -> str:
    """Return the CSV of all that was measured, SI, to the last digit."""
    pose = _POSE[: robot.n]
    groups = (
        (_numbered("dl", robot), measured.counted),
        (pose, measured.guess),
        ([f"sigma_{name}" for name in pose], measured.pose_sigma),
        (_numbered("f", robot), measured.tensions),
        (_numbered("swivel", robot), measured.swivel),
        (["tilt_x", "tilt_y"], measured.tilt),
    )
    names = [name for group, values in groups if values is not None for name in group]
    columns = [values for _, values in groups if values is not None]
    lines = [*(f"# {comment}" for comment in comments), ",".join(names)]
    lines += [",".join(map(repr, row)) for row in np.column_stack(columns).tolist()]
    return "\n".join(lines) + "\n"
