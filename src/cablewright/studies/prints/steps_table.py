"""Steps of a print as rows of numbers, from a log's entries, for the record of the print."""

from __future__ import annotations

from functools import cache
from typing import Final, Self

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.machine.log.log import Entry
from cablewright.machine.simulated.settings import MachineSettings
from cablewright.signals import Barrier, Climate, Encoders, LineAngles, PrintState

STATES: Final = tuple(PrintState)
"""A row's state is an index into this; NaN: unknown."""

_SCALARS: Final = (
    "time", "step", "state", "layer", "distance", "valid", "clearance", "powder", "left", "valve",
    "temperature", "humidity", "broken",
)  # fmt: skip
_VECTORS: Final = (
    "target", "position", "velocity", "rotation", "true_position", "true_velocity", "true_rotation",
)  # fmt: skip
_LINES: Final = (
    "excess", "slack", "lengths", "radii", "true_excess", "true_radii", "tensions", "measured", "turned",
    "true_lengths",
)  # fmt: skip


class Columns:
    """Rows (k, width) by name: `columns["position"]` is (k, 3), ``"time"`` (k,), ``"excess"`` by line (k, m). SI.

    ``step``: time since the last row. ``measured``: the lines' angles, and ``turned``: rotation of the winch drums by
    their encoders (rad), positive paid out; both are the last readings. ``powder``: true mass in the drum, ``left``:
    estimated by the valve's opening. ``broken``: of the light barrier.
    """

    def __init__(self, m: int, rows: Array) -> None:
        """Name the columns of *rows* for a robot of *m* lines."""
        self.m, self.rows = m, rows

    @staticmethod
    def width(m: int) -> int:
        """Number of columns."""
        return len(_SCALARS) + 3 * len(_VECTORS) + m * len(_LINES)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Array:
        found = self.rows[:, columns_of(self.m)[name]]
        return found[:, 0] if name in _SCALARS else found

    def where(self, chosen: Mask) -> Self:
        """Return the *chosen* rows."""
        return type(self)(self.m, self.rows[chosen])

    def then(self, after: Self) -> Self:
        """Return these rows followed by those *after*."""
        return type(self)(self.m, np.concatenate([self.rows, after.rows]))

    def in_state(self, state: PrintState) -> Mask:
        """Return which rows are in that state, (k,)."""
        return np.asarray(self["state"] == STATES.index(state))


@cache
def columns_of(m: int) -> dict[str, slice]:
    """Return the slice of each name in a row."""
    places: dict[str, slice] = {}
    at = 0
    for names, width in ((_SCALARS, 1), (_VECTORS, 3), (_LINES, m)):
        for name in names:
            places[name] = slice(at, at + width)
            at += width
    return places


class StepsTable:
    """Fills rows one by one; sensors' last readings are held."""

    def __init__(self, m: int, settings: MachineSettings, period: float, capacity: int) -> None:
        """For a robot of *m* lines that steps every *period* (s), *capacity* rows at a time."""
        self.m = m
        self._rows = np.full((capacity, Columns.width(m)), np.nan)
        self._count = 0
        self._at = columns_of(m)
        self._turn = 2.0 * np.pi / (settings.winch.counts * settings.winch.ratio)
        self._held_vectors: dict[str, Array] = {}
        self._held_scalars: dict[str, float] = {}
        self._last: float | None = None
        self._period = period
        self._drum, self._left, self._refilling = settings.drum, settings.drum.powder, False

    @property
    def full(self) -> bool:
        """Whether `take` is due."""
        return self._count == len(self._rows)

    @property
    def left(self) -> float:
        """Powder (kg) in the drum, estimated."""
        return self._left

    @property
    def temperature(self) -> float:
        """Degrees Celsius, last reading."""
        return self._held_scalars.get("temperature", float("nan"))

    @property
    def broken(self) -> bool:
        """Whether the light barrier is interrupted, last reading."""
        return self._held_scalars.get("broken") == 1.0

    def take(self) -> Columns:
        """Return the rows and start again."""
        taken = Columns(self.m, self._rows[: self._count].copy())
        self._rows[:] = np.nan
        self._count = 0
        return taken

    def put(self, entry: Entry) -> None:
        """Add one step."""
        now = entry.frame.time
        self._hold(entry)
        step = self._period if self._last is None else now - self._last
        progress, estimate, truth = entry.progress, entry.estimate, entry.truth
        if entry.command is not None:
            self._set(valve=entry.command.valve)
            self._left -= self._drum.flow * entry.command.valve * step if step > 0.0 else 0.0
        self._set(time=now, step=step, left=self._left, **self._held_vectors, **self._held_scalars)
        self._last = now
        if progress is not None:
            if self._refilling and progress.state is not PrintState.REFILLING:
                self._left = self._drum.powder  # refilled to its initial level
            self._refilling = progress.state is PrintState.REFILLING
            state = float(STATES.index(progress.state))
            self._set(state=state, layer=progress.layer, distance=progress.distance, target=progress.target)
        if estimate is not None:
            self._set(
                position=estimate.position,
                velocity=estimate.velocity,
                rotation=estimate.rotation,
                valid=float(estimate.valid),
                clearance=estimate.clearance,
                excess=estimate.excess,
                slack=np.where(np.isfinite(estimate.excess), estimate.slack, np.nan),
                lengths=estimate.lengths,
                radii=estimate.radii,
            )
        if truth is not None:
            self._set(
                true_position=truth.position,
                true_velocity=truth.velocity,
                true_rotation=truth.rotation,
                true_excess=truth.excess,
                true_radii=truth.radii,
                true_lengths=truth.lengths,
                tensions=truth.tensions,
                powder=truth.powder,
            )
        self._count += 1

    def _set(self, **values: Array | float) -> None:
        row = self._rows[self._count]
        for name, value in values.items():
            row[self._at[name]] = value

    def _hold(self, entry: Entry) -> None:
        for reading in entry.frame.readings:
            if isinstance(reading, LineAngles):
                self._held_vectors["measured"] = reading.angles
            elif isinstance(reading, Encoders):
                self._held_vectors["turned"] = np.asarray(reading.counts * self._turn, dtype=np.float64)
            elif isinstance(reading, Climate):
                self._held_scalars["temperature"], self._held_scalars["humidity"] = (
                    reading.temperature,
                    reading.humidity,
                )
            elif isinstance(reading, Barrier):
                self._held_scalars["broken"] = float(reading.broken)
