"""Calibration measurements at poses and their CSV files: size limits, one-line errors, writing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from itertools import chain
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.calibration.plan import SIGMAS
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.csv_input import (
    Column,
    cells_of,
    find_column,
    header_of,
    number_rows,
    separator_of,
    shown,
    text_lines,
)
from cablewright.foundation.errors import InputError, suggestion
from cablewright.foundation.units import ANGLE, FORCE, LENGTH, Dimension
from cablewright.models.coil import TURN
from cablewright.models.drum import drum_of
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot

SENSORS: Final = {"tension": ("tensions", "f_1"), "swivel": ("swivel", "swivel_1"), "tilt": ("tilt", "tilt_x"),
                  "yaw": ("yaw", "yaw")}  # fmt: skip
"""Sensors that have a zero: the field of their measurements, and the first of the columns."""

MAX_BYTES: Final = 32 << 20
MAX_POSES: Final = 5_000
_MAX_SIZE: Final = 1e9  # SI
_OF_LINES: Final = ("dl", "f", "swivel", "hz")
_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")
_OF_DRUM: Final = re.compile(
    r"(?P<name>(?i:dl)_[0-9]+) *[(\[](?P<unit>turns|rad|deg|counts(?:/(?P<counts>[1-9][0-9]{0,8}))?)[)\]]"
)
_UNIT: Final = re.compile(r"[(\[].*")
_COUNTS: Final = "counts/4096"  # one such unit, in messages
_FREQUENCY: Final = Dimension("frequency", {"Hz": Decimal(1)})
_CELLS: Final = (*SENSORS.values(), ("frequencies", "hz_1"))
_MAY_BE_BLANK: Final = ("guess", "pose_sigma", *(name for name, _ in _CELLS))


@dataclass(frozen=True, eq=False)
class Measured:
    """The measurements for a calibration at N poses.

    `guess`: start values of the poses, or measured poses where `pose_sigma` has their standard deviations. A row of
    `guess` is NaN if the pose is unknown, a row of `pose_sigma` if the pose was not measured, and a cell of another
    sensor if that was not read. `near`: poses at which the equations of tensions are linearised, if not at the start
    values.
    """

    counted: Array  # (N, m) m: length changes since home, by encoders; of lines on one drum by its encoder, 0 of others
    guess: Array | None = None  # (N, n) m and rad
    pose_sigma: Array | None = None  # (N, n) m and rad
    tensions: Array | None = None  # (N, m) N
    swivel: Array | None = None  # (N, m) rad: azimuth of each free cable, 0 is world +x
    tilt: Array | None = None  # (N, 2) rad: of the platform against the plumb line, about x and y
    yaw: Array | None = None  # (N, 1) rad: azimuth of the platform's x axis, 0 is world +x
    places: Sequence[int] = field(default=())  # (N,) line number of each pose in the file
    origin: str = "the data"  # the name in messages
    near: Array | None = None  # (N, n) m and rad
    by_drum: Sequence[bool] = field(default=())  # (m,) lines with the counts of a drum that has a build-up
    frequencies: Array | None = None  # (N, m) Hz: of the free cables' first lateral vibration
    tension_sigma: Array | None = None  # (N, m) N: of tensions by frequencies; NaN: by a load cell
    sightings: Sightings | None = None  # of tags in pictures, one at a pose

    def has(self, sensor: str) -> bool:
        """Return whether the data have measurements by a sensor, one of `SENSORS`."""
        return getattr(self, SENSORS[sensor][0]) is not None

    def without_open_zeros(self, unknowns: Sequence[str]) -> Measured:
        """Return the data without sensors whose zero is among the *unknowns*: they are useless until it is known."""
        silent: dict[str, Any] = {name: None for sensor, (name, _) in SENSORS.items() if f"{sensor}_offset" in unknowns}
        return replace(self, **silent)

    def only(self, poses: Mask) -> Measured:
        """Return the measurements at some *poses* (N,)."""
        kept: dict[str, Any] = {
            name: value[poses]
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray) and value.ndim == 2
        }
        places = [self.places[at] for at in np.flatnonzero(poses).tolist()] if len(self.places) else ()
        seen = None if self.sightings is None else self.sightings.only(poses)
        return replace(self, places=places, sightings=seen, **kept)

    def lengths_alone(self) -> Measured:
        """Return the lengths, and the start values of the poses, without measurements of other sensors."""
        return Measured(self.counted, self.guess, places=self.places, origin=self.origin, by_drum=self.by_drum)

    @property
    def positioned(self) -> int:
        """The number of poses whose position is measured."""
        return 0 if self.pose_sigma is None else int(np.isfinite(self.pose_sigma).all(axis=1).sum())

    def place(self, pose: int) -> str:
        """Return where a pose (counted from 0) is: ``line 7`` of the file, or ``pose 7``."""
        return f"line {self.places[pose]}" if len(self.places) else f"pose {pose + 1}"


def read_measured(path: str | Path, robot: Robot) -> Measured:
    """Read a CSV with a column ``dl_1`` .. ``dl_m`` for each line: the change of its length since the home pose.

    A line with a counterweight or on the drum of another has no such column.

    Optional columns: ``x,y,z`` (and ``rx,ry,rz`` of a rigid platform), start values of the poses, or measured poses
    where ``sigma_x`` .. are given; ``f_1`` .., tensions; ``swivel_1`` .., azimuths of the free cables;
    ``tilt_x,tilt_y``; ``yaw``; ``hz_1`` .., frequencies of the free cables, Hz. Their cells may be blank. A unit may
    follow a name, ``dl_1 (mm)``; without it numbers are SI. Encoders may also give what the drum turned, ``turns``,
    ``deg``, ``rad``, or ``counts/4096``, counts of an encoder that has 4096 a turn of the drum. The separator is tab,
    semicolon or comma. Comments begin with ``#``.

    Raises `InputError` for a missing, unknown or repeated column, an incomplete group of columns, a row that is shorter
    or longer than the header, and a cell that is not a finite number.
    """
    path = Path(path)
    number, header, rows = header_of(text_lines(path, MAX_BYTES, "table of measurements"))
    if not number:
        expected = _listed(_groups(robot)["counted"])
        raise InputError(f"{path}: empty; expected a header with columns {expected}, then rows of numbers")
    columns = _columns(header, f"{path}, line {number}", robot)
    blank = set(chain.from_iterable(names for field, names in _groups(robot).items() if field in _MAY_BE_BLANK))
    found = number_rows(path, rows, header, columns, MAX_POSES, "poses", blank=blank)
    table = [(number, numbers) for number, _, numbers in found]
    if not table:
        raise InputError(f"{path}: a header, but no poses")
    lines = [number for number, _ in table]
    values = dict(zip(columns, np.array([numbers for _, numbers in table]).T, strict=True))
    for name, column in values.items():
        row = int(np.argmax(np.abs(np.nan_to_num(column))))
        if abs(column[row]) > _MAX_SIZE:
            raise InputError(
                f"{path}, line {lines[row]}: {name} = {column[row]:g}: must be at most {_MAX_SIZE:g} in size"
            )
    for name in _POSE[3 : robot.n]:  # a position without an orientation means unrotated
        values.setdefault(name, np.where(np.isnan(values.get("x", np.zeros(1))), np.nan, np.zeros(len(table))))
    fields: dict[str, Any] = {
        field: np.column_stack([values[name] for name in names])
        for field, names in _groups(robot).items()
        if names[0] in values
    }
    _check_blanks(fields, f"{path}, line", lines)
    winches = WinchLines.of(robot)
    fields["counted"] = winches.sense * fields["counted"][:, np.maximum(winches.winch, 0)]
    if (fields.get("pose_sigma", np.ones(1)) < SIGMAS[0]).any():
        row, axis = np.argwhere(fields["pose_sigma"] < SIGMAS[0])[0]
        raise InputError(f"{path}, line {lines[row]}: sigma_{_POSE[axis]}: must be at least {SIGMAS[0]:g}")
    wound = {
        found["name"].casefold() for found in map(_OF_DRUM.fullmatch, cells_of(header, separator_of(header))) if found
    }
    by_drum = [f"dl_{i + 1}" in wound and line.winch.build_up is not None for i, line in enumerate(robot.lines)]
    return Measured(**fields, places=lines, origin=str(path), by_drum=by_drum if any(by_drum) else ())


def _check_blanks(fields: dict[str, Array], where: str, lines: Sequence[int]) -> None:
    """Raise `InputError` for a position of which only a part is blank, or a sigma without one.

    *where*: place of the row, for messages. And for a sensor whose cells are all blank.
    """
    blank = {name: np.isnan(values) for name, values in fields.items()}
    for name, column in _CELLS:
        if name in blank and blank[name].all():
            raise InputError(f"{where} {lines[0]}: {column} and all others of it are blank; leave the columns out")
    if "guess" not in blank:
        return
    for name, what in (("guess", "position"), ("pose_sigma", "sigma of the position")):
        partly = blank.get(name, np.zeros((1, 1), dtype=bool))
        odd = np.flatnonzero(partly.any(axis=1) & ~partly.all(axis=1))
        if len(odd):
            raise InputError(f"{where} {lines[odd[0]]}: a part of the {what} is blank; give all of it or nothing")
    if blank["guess"].all():
        raise InputError(f"{where} {lines[0]}: x, y, z are blank in all rows; leave the columns out")
    if "pose_sigma" in blank:
        odd = np.flatnonzero(blank["guess"].all(axis=1) & ~blank["pose_sigma"].all(axis=1))
        if len(odd):
            raise InputError(f"{where} {lines[odd[0]]}: sigma_x without x")
        if blank["pose_sigma"].all():
            raise InputError(f"{where} {lines[0]}: sigma_x is blank in all rows; leave the columns out")


def _groups(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Return the names of the columns of each field of `Measured`."""
    pose = _POSE[: robot.n]
    tension, swivel, frequency = (tuple(f"{name}_{i + 1}" for i in range(robot.m)) for name in _OF_LINES[1:])
    return {
        "counted": tuple(f"dl_{i + 1}" for i in robot.hosts),
        "guess": pose,
        "pose_sigma": tuple(f"sigma_{name}" for name in pose),
        "tensions": tension,
        "swivel": swivel,
        "tilt": ("tilt_x", "tilt_y"),
        "yaw": ("yaw",),
        "frequencies": frequency,
    }


def _dimension(name: str, robot: Robot, cells: Sequence[str], place: str) -> Dimension:
    """Return the dimension of a column; that of encoders has units of the drum's turn too, if the header uses one."""
    if name.startswith("dl_"):
        return _of_drum(name, robot, cells, place)
    if name.startswith(("f_", "hz_")):
        return FORCE if name.startswith("f_") else _FREQUENCY
    angle = name.startswith(("swivel_", "tilt_", "yaw")) or name.removeprefix("sigma_") in _POSE[3:]
    return ANGLE if angle else LENGTH


def _of_drum(name: str, robot: Robot, cells: Sequence[str], place: str) -> Dimension:
    """Return lengths, and turns of the drum of a column's line, as far as its radius in the file would wind.

    Raises `InputError` for a header with turns of a drum that has no radius, and for counts of no size.
    """
    given = [each for each in map(_OF_DRUM.fullmatch, cells) if each and each["name"].casefold() == name]
    line = robot.lines[int(name.removeprefix("dl_")) - 1]
    drum = drum_of(line)
    if drum is None:
        if not given:
            return LENGTH
        why = "gives no winch.drum_radius; give lengths"
        raise InputError(f"{place}: column {shown(given[0][0])}: line {line.name!r} {why}")
    if any(each["unit"] == "counts" for each in given):
        raise InputError(
            f"{place}: column {shown(given[0][0])}: say how many a turn of the drum, as in '{name} ({_COUNTS})'"
        )
    turn = TURN * drum.radius
    sizes = {"turns": turn, "rad": drum.radius, "deg": turn / 360.0, _COUNTS: turn / int(_COUNTS.partition("/")[2])}
    sizes |= {each["unit"]: turn / int(each["counts"]) for each in given if each["counts"]}
    return Dimension("length", {**LENGTH.units, **{unit: Decimal(size) for unit, size in sizes.items()}})


def _columns(header: str, place: str, robot: Robot) -> dict[str, Column]:
    """Return the known columns by name. Raises `InputError` for an unknown column or an incomplete group."""
    cells = cells_of(header, separator_of(header))
    known = list(chain.from_iterable(_groups(robot).values()))
    found = {name: find_column((name,), cells, place, _dimension(name, robot, cells, place)) for name in known}
    columns = {name: column for name, column in found.items() if column is not None}
    positions = {column.position for column in columns.values()}
    for position, cell in enumerate(cells):
        if position not in positions:
            head, _, digits = _UNIT.sub("", cell[:60].casefold()).rstrip(" ").rpartition("_")
            of_line = head in _OF_LINES and digits.isdecimal()
            hint = suggestion(cell[:60].casefold(), known, limit=20)
            if of_line:
                hint = (head == "dl" and _of_no_winch(robot, digits)) or f"{robot.name!r} has {robot.m} lines"
            raise InputError(f"{place}: unknown column {shown(cell)}; {hint}")
    for group, names in _groups(robot).items():
        missing = [name for name in names if name not in columns]
        position_only = group == "guess" and missing == list(_POSE[3:])
        if missing and not position_only and (group == "counted" or len(missing) < len(names)):
            each = "winch" if group == "counted" and len(names) < robot.m else "line or axis"
            raise InputError(f"{place}: no column {missing[0]!r}; expected {_listed(names)}, one for each {each}")
    for name in _POSE[: robot.n]:
        if f"sigma_{name}" in columns and name not in columns:
            raise InputError(f"{place}: column 'sigma_{name}' without a column {name!r}")
    return columns


def _listed(names: Sequence[str]) -> str:
    """Return names of columns in words: ``dl_1 to dl_8``, or each where numbers are missing between."""
    first, _, start = names[0].rpartition("_")
    in_order = len(names) > 2 and (not start.isdecimal() or names[-1] == f"{first}_{int(start) + len(names) - 1}")
    return f"{names[0]} to {names[-1]}" if in_order else " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _of_no_winch(robot: Robot, digits: str) -> str:
    """Return why the line of a number (counted from 1) has no count of its own; empty if it has one, or is none."""
    at = int(digits) - 1
    if at in robot.hosts or not 0 <= at < robot.m:
        return ""
    line = robot.lines[at]
    if line.shared_winch is None:
        return f"line {line.name!r} has a counterweight, and no encoder: leave the column out"
    return f"line {line.name!r} is on the drum of {line.shared_winch.line!r}, which is counted once: leave it out"


def write_measured(measured: Measured, robot: Robot, comments: Sequence[str] = ()) -> str:
    """Return the CSV of all that was measured, in SI, with all digits; counts of drums with a build-up in rad."""
    given = {field: names for field, names in _groups(robot).items() if getattr(measured, field) is not None}
    counted = measured.counted.copy()
    for at in np.flatnonzero(measured.by_drum):
        counted[:, at] /= robot.lines[at].winch.drum_radius or 1.0
    own = {"counted": counted[:, list(robot.hosts)]}
    table = np.column_stack([own.get(field, getattr(measured, field)) for field in given])
    wound = {f"dl_{at + 1}": f"dl_{at + 1} (rad)" for at in np.flatnonzero(measured.by_drum)}
    header = (wound.get(name, name) for name in chain.from_iterable(given.values()))
    lines = [*(f"# {comment}" for comment in comments), ",".join(header)]
    lines += [",".join("" if np.isnan(cell) else repr(cell) for cell in row) for row in table.tolist()]
    return "\n".join(lines) + "\n"
