"""Steps of a print as rows of a structured array, from the log's entries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Mask
from cablewright.foundation.signals import Barrier, Climate, Encoders, LineAngles, PrintState, Tensions
from cablewright.machine.log.log import Entry
from cablewright.machine.powder_load import PowderLoad
from cablewright.machine.settings import MachineSettings
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot

Rows = NDArray[np.void]
"""Rows (k,) of `row_type`: ``rows["position"]`` is (k, 3), ``rows["time"]`` (k,), ``rows["excess"]`` (k, m)."""

STATES: Final = tuple(PrintState)
"""A row's ``state`` is an index into this."""

ERRORS: Final = ("offset", "speed", "estimated_offset", "estimated_speed")
"""Columns that the record adds: cross-track error, m, and speed along the path, m/s, true and estimated."""

_SCALARS: Final = (
    "time", "step", "state", "layer", "distance", "valid", "clearance", "powder", "left", "valve",
    "temperature", "humidity", "broken", *ERRORS,
)  # fmt: skip
_VECTORS: Final = (
    "target", "position", "velocity", "rotation", "true_position", "true_velocity", "true_rotation",
)  # fmt: skip
_LINES: Final = (
    "excess", "slack", "lengths", "radii", "true_excess", "true_radii", "tensions", "measured", "turned",
    "true_lengths", "taut", "estimated_tensions", "read_tensions", "chosen_tensions",
)  # fmt: skip
_BOTH: Final = ("position", "velocity", "rotation", "excess", "lengths", "radii")
_OF_PROGRESS: Final = {name: name for name in ("layer", "distance", "target")} | {"tensions": "chosen_tensions"}
_OF_ESTIMATE: Final = {name: name for name in (*_BOTH, "clearance", "valid", "slack")}
_OF_TRUTH: Final = {name: f"true_{name}" for name in _BOTH} | {name: name for name in ("tensions", "powder")}


def row_type(m: int) -> np.dtype[np.void]:
    """Type of a row for *m* lines: scalars, vectors (3,) and values by line (m,), float64, SI. NaN: unknown.

    ``step``: time since the last row. ``measured``: the lines' angles, ``turned``: rotation of the winch drums by their
    encoders (rad), positive paid out, and ``read_tensions``: all three are the last readings. ``chosen_tensions``: at
    which the control holds the lines. ``powder``: true mass in the drum, ``left``: estimated by the valve's opening.
    ``broken``: whether the light barrier is interrupted. The record adds `ERRORS`, and for the rows that it keeps
    ``taut``: angles of the lines if they were taut, and ``estimated_tensions``.
    """
    widths = dict.fromkeys(_SCALARS, ()) | dict.fromkeys(_VECTORS, (3,)) | dict.fromkeys(_LINES, (m,))
    return np.dtype([(name, np.float64, width) for name, width in widths.items()])


def in_state(rows: Rows, state: PrintState) -> Mask:
    """Return a mask (k,) of the *rows* of steps in which the print was in a *state*."""
    return np.asarray(rows["state"] == STATES.index(state))


class StepsTable:
    """Converts log entries to rows; the last reading of each sensor is held."""

    def __init__(self, robot: Robot, settings: MachineSettings, period: float, capacity: int) -> None:
        """For a *robot* that steps every *period* (s), *capacity* rows at a time."""
        self._rows, self._winches = np.full(capacity, np.nan, row_type(robot.m)), WinchLines.of(robot)
        self._held: np.void = np.full(1, np.nan, row_type(robot.m))[0]  # a row with the last readings of sensors
        self._entries: list[Entry] = []
        self._turn = 2.0 * np.pi / (settings.winch.counts * settings.winch.ratio)
        self._last: float | None = None
        self._period = period
        self._full_powder, self._load = settings.carrier.powder, PowderLoad.of(settings.carrier)

    @property
    def left(self) -> float:
        """Powder in the drum, kg, estimated; 0 of a machine that carries none."""
        return self._full_powder - self._load.gone

    @property
    def full(self) -> bool:
        """Whether the table is full, so that `take` is due."""
        return len(self._entries) == len(self._rows)

    @property
    def temperature(self) -> float:
        """Last temperature reading, degrees Celsius."""
        return float(self._held["temperature"])

    @property
    def broken(self) -> bool:
        """Whether the light barrier is interrupted, by its last reading."""
        return bool(self._held["broken"] == 1.0)

    def take(self) -> Rows:
        """Return the rows of the table of steps and empty it."""
        rows, entries, self._entries = self._rows[: len(self._entries)].copy(), self._entries, []
        moves = [each.progress for each in entries]
        rows["state"] = [np.nan if each is None else STATES.index(each.state) for each in moves]
        _fill(rows, moves, _OF_PROGRESS)
        _fill(rows, [each.estimate for each in entries], _OF_ESTIMATE)
        _fill(rows, [each.truth for each in entries], _OF_TRUTH)
        rows["slack"] = np.where(np.isfinite(rows["excess"]), rows["slack"], np.nan)
        return rows

    def put(self, entry: Entry) -> None:
        """Add one step to the table."""
        self._hold(entry)
        now, at = entry.frame.time, len(self._entries)
        self._rows[at] = self._held
        row = self._rows[at]
        step = self._period if self._last is None else now - self._last
        self._load.follow(entry.orders, entry.command, step)
        row["time"], row["step"], row["left"], self._last = now, step, self.left, now
        row["valve"] = np.nan if entry.command is None else entry.command.valve
        self._entries.append(entry)

    def _hold(self, entry: Entry) -> None:
        for reading in entry.frame.readings:
            if isinstance(reading, LineAngles):
                self._held["measured"] = reading.angles
            elif isinstance(reading, Encoders):
                self._held["turned"] = self._winches.of_lines(reading.counts) * self._turn
            elif isinstance(reading, Tensions):
                self._held["read_tensions"] = reading.tensions
            elif isinstance(reading, Climate):
                self._held["temperature"], self._held["humidity"] = reading.temperature, reading.humidity
            elif isinstance(reading, Barrier):
                self._held["broken"] = reading.broken


def _fill(rows: Rows, parts: Sequence[object], columns: Mapping[str, str]) -> None:
    """Write attributes of the *parts* (k,), one for each step or None, to the columns that *columns* names for them."""
    for name, column in columns.items():
        known = [(i, getattr(part, name)) for i, part in enumerate(parts) if part is not None]
        found = [(i, value) for i, value in known if value is not None]
        if found:
            steps, values = zip(*found, strict=True)
            rows[column][list(steps)] = values
