"""Steps of a print as rows of a structured array, from the log's entries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
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
_OF_ESTIMATE: Final = ("position", "velocity", "rotation", "clearance", "excess", "lengths", "radii")
_OF_TRUTH: Final = ("position", "velocity", "rotation", "excess", "lengths", "radii")
_TRUE: Final = {name: f"true_{name}" for name in _OF_TRUTH}
"""Columns of the truth that the estimate has too."""
_CHOSEN: Final = {"tensions": "chosen_tensions"}
_SAME: Final[Mapping[str, str]] = {}


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
        moves, shown = [each.progress for each in entries], [each.estimate for each in entries]
        _fill(rows, moves, ("layer", "distance", "target", "tensions"), _CHOSEN)
        rows["state"] = [np.nan if each is None else STATES.index(each.state) for each in moves]
        _fill(rows, shown, (*_OF_ESTIMATE, "valid", "slack"))
        _fill(rows, [each.truth for each in entries], (*_OF_TRUTH, "tensions", "powder"), _TRUE)
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
        if entry.command is not None:
            row["valve"] = entry.command.valve
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


def _fill(rows: Rows, parts: Sequence[object], names: Iterable[str], columns: Mapping[str, str] = _SAME) -> None:
    """Write what is known of the *parts* (k,) of the steps, to the *columns* of other names or their own."""
    for name in names:
        found = [(i, value) for i, part in enumerate(parts) if (value := getattr(part, name, None)) is not None]
        if found:
            known, values = zip(*found, strict=True)
            rows[columns.get(name, name)][list(known)] = values
