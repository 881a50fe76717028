"""Records of a free swing: a log of a machine, or a CSV file of positions of markers."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np

from cablewright.analyses.swing_identification import MIN_SAMPLES
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import SwingSignal
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
from cablewright.foundation.signals.inertial import Inertial
from cablewright.foundation.signals.tensions import Tensions
from cablewright.foundation.units import DURATION, LENGTH
from cablewright.machine.log.log import Entry, Log, read_log

STILL: Final = 5e-3
"""Speed of a cable, m/s, under which its winch counts as at rest."""

_MAX_BYTES: Final = 256 << 20
_MAX_ROWS: Final = 1_000_000
_MOST_MARKERS: Final = 20
_SIGNALS: Final[tuple[SwingSignal, ...]] = get_args(SwingSignal)


@dataclass(frozen=True, eq=False)
class SwingRecord:
    """The channels (N, c) of one kind of `signal` at `times` (N,), s; `pose`: mean estimate, or None."""

    times: Array
    channels: Array
    signal: SwingSignal
    pose: Array | None


def read_swing(
    path: Path, freedoms: int, signal: SwingSignal | None = None, span: tuple[float, float] | None = None
) -> SwingRecord:
    """Return the record in a log or a CSV file; *freedoms*: 3 or 6, the platform's degrees of freedom, for the pose.

    *signal*: sensor whose readings are used; by default the first of inertial unit, load cells and positions that the
    log has. *span*: the first and the last time, s; by default of a log the longest time for which the winches are at
    rest, of a CSV file all. Raises `InputError`.
    """
    if path.suffix.lower() == ".csv":
        if signal not in (None, "positions"):
            raise InputError(f"--signal {signal}: {path} has positions alone")
        times, channels = _read_positions(path)
        pose = channels[:, :3] if freedoms == 3 and channels.shape[1] == 3 else None
        signal = "positions"
    else:
        with read_log(path) as log:
            rows, speeds, poses = _collected(log, freedoms)
        signal = signal or next((each for each in _SIGNALS if rows[each]), None)
        if signal is None or not rows[signal]:
            what = " or ".join(_SIGNALS) if signal is None else signal
            raise InputError(f"{path}: no readings of {what}; a swing is identified from these")
        span = span or _at_rest(np.array(speeds))
        table = np.array(sorted(rows[signal]))
        times, channels = table[:, 0], table[:, 1:]
        pose = _within(np.array(poses), span)[:, 1:] if poses else None
    inside = np.ones(len(times), dtype=bool) if span is None else (times >= span[0]) & (times <= span[1])
    inside &= np.concatenate([[True], np.diff(times) > 0.0])
    if not inside.any():
        raise InputError(f"{path}: nothing was recorded within the span; it is from {times[0]:g} to {times[-1]:g} s")
    channels = channels[inside][:, ~np.isnan(channels[inside]).any(axis=0)]
    mean = None if pose is None or not len(pose) else pose.mean(axis=0)
    return SwingRecord(times[inside], channels if signal == "positions" else _by_noise(channels), signal, mean)


def _within(rows: Array, span: tuple[float, float] | None) -> Array:
    return rows if span is None else rows[(rows[:, 0] >= span[0]) & (rows[:, 0] <= span[1])]


def _collected(log: Log, freedoms: int) -> tuple[dict[str, list[list[float]]], list[list[float]], list[list[float]]]:
    """Return rows of time and channels by signal, of time and speeds of cables, m/s, and of time and valid poses."""
    radii = np.array([line.winch.drum_radius or 1.0 for line in log.head.robot.lines])
    rows: dict[str, list[list[float]]] = defaultdict(list)
    speeds, poses = [], []
    for entry in log.entries():
        _add_readings(entry, rows)
        if entry.command is not None:
            speeds.append([entry.command.time, float(abs(entry.command.winch_speeds * radii).max())])
        found = entry.estimate
        if found is not None and found.valid:
            rows["positions"].append([found.time, *found.position])
            poses.append([found.time, *found.position, *found.rotation][: 1 + freedoms])
    return rows, speeds, poses


def _add_readings(entry: Entry, rows: dict[str, list[list[float]]]) -> None:
    for reading in entry.frame.readings:
        if isinstance(reading, Inertial):
            rows["inertial"].append([reading.time, *reading.acceleration, *reading.rate])
        elif isinstance(reading, Tensions) and reading.source == "load_cells":
            rows["load-cells"].append([reading.time, *reading.tensions])


def _at_rest(speeds: Array) -> tuple[float, float] | None:
    """Return begin and end of the longest time in which no winch moves; None where nothing was commanded."""
    if not len(speeds):
        return None
    moving = np.flatnonzero(np.concatenate([[True], speeds[:, 1] > STILL, [True]]))
    longest = int(np.diff(moving).argmax())
    first, last = moving[longest], moving[longest + 1] - 2
    if last <= first:
        raise InputError(f"no swing: the winches are never at rest, under {1e3 * STILL:g} mm/s; give --span T0,T1")
    return float(speeds[first, 0]), float(speeds[last, 0])


def _by_noise(channels: Array) -> Array:
    """Return channels over the size of their noise, by second differences, so that all units have equal weight."""
    if len(channels) < MIN_SAMPLES:
        return channels
    noise = np.diff(channels, 2, axis=0).std(axis=0)
    return np.asarray(channels / np.where(noise > 0.0, noise, 1.0))


def _read_positions(path: Path) -> tuple[Array, Array]:
    """Return times (N,), s, and positions (N, 3 k), m, of k markers: columns t, x, y, z, x2, y2, z2 and so on."""
    number, header, rows = header_of(text_lines(path, _MAX_BYTES, "table of positions"))
    if not number:
        raise InputError(f"{path}: is empty; a header and rows of positions are needed")
    place, cells = f"{path}, line {number}", cells_of(header, separator_of(header))
    time = find_column(("time", "t"), cells, place, DURATION)
    if time is None:
        raise no_column(("t", "time"), cells, place, DURATION)
    columns: dict[str, Column] = {"t": time}
    for marker in range(_MOST_MARKERS):
        names = [f"{axis}{marker + 1 if marker else ''}" for axis in "xyz"]
        found = [find_column((name,), cells, place, LENGTH) for name in names]
        missing = [name for name, column in zip(names, found, strict=True) if column is None]
        if len(missing) == 3 and marker:
            break
        if missing:
            raise no_column((missing[0],), cells, place, LENGTH)
        columns |= {name: column for name, column in zip(names, found, strict=True) if column is not None}
    table = np.array([numbers for _, _, numbers in number_rows(path, rows, header, columns, _MAX_ROWS, "rows")])
    if len(table) < 2:
        raise InputError(f"{path}: fewer than 2 rows below its header")
    if (np.diff(table[:, 0]) <= 0.0).any():
        row = int(np.flatnonzero(np.diff(table[:, 0]) <= 0.0)[0]) + 2
        raise InputError(f"{path}: the time t does not rise in row {row}; sort the rows by time")
    return table[:, 0], table[:, 1:]
