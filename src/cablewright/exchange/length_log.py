"""Import of a log of cable lengths (CSV), or of a check's ``lengths.csv``, and its poses by forward solves.

Columns ``length NAME`` or ``length_NAME`` for every line, with a unit, and one ``time``. Only the header of a check,
which is SI, may leave the units out.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.csv_input import (
    Column,
    cells_of,
    find_column,
    header_of,
    no_column,
    number_rows,
    separator_of,
    text_lines,
)
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.units import DURATION, LENGTH, Dimension
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward

MAX_BYTES: Final = 256 << 20
MAX_ROWS: Final = 1_000_000


@dataclass(frozen=True, eq=False)
class LengthLog:
    """A log of lengths. ``time`` (k,), s, and ``lengths`` (k, m), m, in the order of a robot's lines."""

    time: Array
    lengths: Array


def read_lengths(path: Path, robot: Robot) -> LengthLog:
    """Return the log in a CSV file for the lines of *robot*. Raises `InputError`: file, line and column in one line."""
    number, header, rows = header_of(text_lines(path, MAX_BYTES, "table of lengths"))
    if not number:
        raise InputError(f"{path}: is empty; a header and rows of lengths are needed")
    place, cells = f"{path}, line {number}", cells_of(header, separator_of(header))
    names = [line.name for line in robot.lines]
    of_check = cells[: 1 + len(names)] == ["time", *(f"length {name}" for name in names)] and "laid" in cells
    columns = {"time": _column(("time",), cells, place, DURATION, of_check)}
    for name in names:
        keys = (f"length {name}".casefold(), f"length_{name}".casefold())
        columns[f"length {name}"] = _column(keys, cells, place, LENGTH, of_check)
    table = np.array([numbers for _, _, numbers in number_rows(path, rows, header, columns, MAX_ROWS, "rows")])
    if not len(table):
        raise InputError(f"{path}: has no rows below its header")
    time, lengths = table[:, 0], table[:, 1:]
    if (np.diff(time) < 0.0).any():
        raise InputError(
            f"{path}: the time in row {int(np.flatnonzero(np.diff(time) < 0.0)[0]) + 2} is before that of the row "
            f"above; sort the rows by time"
        )
    if not (lengths > 0.0).all():
        k, i = np.argwhere(~(lengths > 0.0))[0]
        raise InputError(f"{path}: row {k + 1}, length {names[i]} = {lengths[k, i]:g} m: must be over 0")
    return LengthLog(time, lengths)


def _column(keys: tuple[str, ...], cells: list[str], place: str, quantity: Dimension, of_check: bool) -> Column:
    """Return the column of one of these keys, with its unit. Raises `InputError`."""
    found = find_column(keys, cells, place, quantity)
    if found is None:
        raise no_column(keys[:1], cells, place, quantity)
    if found.size is None and not of_check:
        units = " or ".join(f"'{keys[0]} ({unit})'" for unit in list(quantity.units)[:2])
        raise InputError(f"{place}: column {cells[found.position]!r} has no unit; give that of its numbers: {units}")
    return found


@dataclass(frozen=True, eq=False, repr=False)
class LoggedPoses(Result):
    """Poses of the platform computed from a log of lengths."""

    FIGURES: ClassVar = (
        Figure("rows", "1", "Number of rows of the log."),
        Figure("solved", "1", "Number of rows for which an equilibrium was found."),
        Figure("highest_tension", "N", "Largest tension at a sheave in any of them.", shown="N"),
        Figure("time", "s", "Time of each row.", "log.time", along="row"),
        Figure("status", "", "Outcome of each row.", lambda of: [each.word for each in of.poses.status], along="row"),
        Figure("pose", "m, rad", "Pose of each row.", "poses.pose", along="row"),
        Figure("tensions", "N", "Tension of each line at its sheave, of each row.", "poses.tensions", along="row",
               detail=True),
    )  # fmt: skip

    log: LengthLog
    poses: Equilibrium

    @property
    def rows(self) -> int:
        """Number of rows of the log of lengths."""
        return len(self.log.time)

    @property
    def solved(self) -> int:
        """Number of rows of the log of lengths with an equilibrium."""
        return int(self.poses.holds.sum())

    @property
    def highest_tension(self) -> float:
        """The largest tension, N; NaN where nothing was solved."""
        return float(np.nanmax(self.poses.tensions[self.poses.holds])) if self.solved else float("nan")

    @property
    def refusal(self) -> str:
        """Sentence that explains why the command's answer is no (exit code 1); empty if the answer is yes."""
        if self.solved == self.rows:
            return ""
        first = int(np.flatnonzero(~self.poses.holds)[0])
        return f"{self.rows - self.solved} of {self.rows} rows, row {first + 1} first: {self.poses[first].sentence()}"


def forward_log(model: Model, log: LengthLog, guess: list[float] | None = None) -> LoggedPoses:
    """Return the poses of a log of lengths, each found from the one before; *guess*: a pose near the first."""
    first = solve_forward(model, log.lengths[0], guess=guess)
    start = np.where(np.isfinite(first.pose), first.pose, 0.0)
    guesses = np.tile(start, (len(log.time), 1))
    return LoggedPoses(log, solve_forward(model, log.lengths, guess=guesses, path=True))
