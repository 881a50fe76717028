"""Counts of winches over the wrap of their counters, and kept over a loss of power.

Counts on disk are valid only between a standstill, with the winches held, and the next motion: the mark is taken away
on disk before the first command that turns a winch, and when one turns without a command. So whoever finds the mark
knows that nothing has moved since, as long as the machine had power; whether somebody turned a drum without power, only
its lengths can tell. Counters are taken to begin anew with the power.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cablewright.errors import EnvironmentFault, InputError
from cablewright.file_output import write_whole
from cablewright.machine.interface import Abilities, Machine
from cablewright.signals import Command, Condition, Encoders, Notice, Reading, SensorFrame, WinchMode
from cablewright.toml_input import read_bytes

BITS: Final = 32
"""Bits of a counter."""

STILL: Final = 1.0
"""Time without a change of counts, s, after which held winches are taken to stand."""

GRAIN: Final = 2
"""Counts by which an encoder at rest may flicker."""

_MAX_FILE: Final = 1 << 20  # bytes


class Unwrapped:
    """Totals of counters that wrap: each is read before it turns by half its range."""

    def __init__(self, totals: NDArray[np.int64] | None = None, raw: NDArray[np.int64] | None = None) -> None:
        """Begin with the first reading as totals, or with known *totals* (m,) at the *raw* counts (m,) of then."""
        self._totals, self._raw = totals, raw

    def total(self, raw: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the totals (m,) at *raw* counts (m,), of `BITS` bits, signed or not."""
        if self._totals is None or self._raw is None:
            self._totals = raw.copy()
        else:
            half = 1 << (BITS - 1)
            self._totals = self._totals + ((raw - self._raw + half) % (1 << BITS) - half)
        self._raw = raw.copy()
        return self._totals.copy()


class _File(BaseModel):
    """What the file holds."""

    model_config = ConfigDict(extra="forbid", strict=True)

    schema_number: Annotated[int, Field(alias="schema", ge=1, le=1)]
    robot: str
    lines: tuple[str, ...]
    counts: tuple[Annotated[int, Field(ge=-(2**62), le=2**62)], ...]
    valid: bool


@dataclass(frozen=True, eq=False)
class SavedCounts:
    """Counts of the winches of *robot*, by line, and whether they were still so when they were written."""

    robot: str
    lines: tuple[str, ...]
    counts: NDArray[np.int64]
    valid: bool


class CountFile:
    """The counts of a machine on disk."""

    def __init__(self, path: Path, robot: str, lines: Sequence[str]) -> None:
        """The file at *path*, which need not be there, of the winches of *robot* for *lines*."""
        self.path, self._robot, self._lines = path, robot, tuple(lines)

    def read(self) -> SavedCounts | None:
        """Return what was saved; None without a file. Raises `InputError` for one that is damaged or of another."""
        if not self.path.exists():
            return None
        try:
            found = _File.model_validate_json(read_bytes(self.path, _MAX_FILE, "saved counts"))
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            where = ".".join(map(str, first["loc"])) or "the file"
            raise InputError(f"{self.path}: {where}: {first['msg']}; home the machine anew") from None
        if (found.robot, found.lines) != (self._robot, self._lines) or len(found.counts) != len(self._lines):
            raise InputError(f"{self.path}: holds counts of {found.robot!r}, lines {', '.join(found.lines)}")
        return SavedCounts(found.robot, found.lines, np.array(found.counts, dtype=np.int64), found.valid)

    def write(self, counts: NDArray[np.int64], *, valid: bool) -> None:
        """Write counts (m,), synced to disk. Raises `EnvironmentFault`."""
        content: dict[str, Any] = {"schema": 1, "robot": self._robot, "lines": self._lines}
        content |= {"counts": counts.tolist(), "valid": valid}
        write_whole(self.path, json.dumps(content).encode() + b"\n")


@dataclass
class Remembering:
    """A machine whose counts are kept on disk; its frames have totals, over wraps and over a loss of power.

    ``restored``: whether the saved counts were valid, so that the totals go on from them. Where a file cannot be
    written at a standstill, frames have the notice NOT_SAVED.
    """

    machine: Machine
    file: CountFile
    restored: bool = False
    _unwrapped: Unwrapped = field(default_factory=Unwrapped, repr=False)
    _saved: NDArray[np.int64] | None = field(default=None, repr=False)  # before the first reading
    _totals: NDArray[np.int64] | None = field(default=None, repr=False)  # of the last reading
    _marked: NDArray[np.int64] | None = field(default=None, repr=False)  # valid on disk
    _still: tuple[float, NDArray[np.int64]] | None = field(default=None, repr=False)  # s, since when, and the totals
    _time: float = field(default=-math.inf, repr=False)  # s, of the last command
    _read_time: float = field(default=-math.inf, repr=False)  # s, of the frame with the last reading

    @property
    def period(self) -> float:
        """Time of one step, s."""
        return self.machine.period

    @property
    def abilities(self) -> Abilities:
        """Those of the machine."""
        return self.machine.abilities

    def open(self) -> None:
        """As `Machine`; reads the saved counts. Raises `InputError` for a file that is damaged or of another."""
        saved = self.file.read()
        self._saved = self._marked = saved.counts if saved is not None and saved.valid else None
        self._unwrapped, self._totals, self._still = Unwrapped(), None, None
        self.restored = self._saved is not None
        self.machine.open()

    def step(self, command: Command) -> SensorFrame:
        """As `Machine`. Raises `EnvironmentFault` where the mark cannot be taken away: nothing is sent then."""
        moves = bool(command.winch_speeds.any()) or WinchMode.TENSION in command.modes
        if moves:
            self._unmark()
        self._time = command.time
        frame = self.machine.step(command)
        readings = tuple(self._counted(each, frame.time) for each in frame.readings)
        notices = frame.notices
        try:
            self._keep(frame.time, moves)
        except EnvironmentFault:
            notices = (*notices, Notice(Condition.NOT_SAVED))
        return SensorFrame(frame.time, readings, notices)

    def stop(self) -> None:
        """As `Machine`."""
        self.machine.stop()

    def close(self) -> None:
        """As `Machine`; before that it waits, with brakes closed, until the counts can be saved as valid."""
        try:
            if WinchMode.OFF in self.abilities.modes and self._totals is not None:
                self._stand()
        finally:
            self.machine.close()

    def _stand(self) -> None:
        """Keep all winches off until their counts are saved, or for twice the time that it takes."""
        m = self.abilities.winches
        for _ in range(round(2.0 * STILL / self.period)):
            if self._marked is not None:
                return
            self.step(Command(self._time, np.zeros(m), modes=(WinchMode.OFF,) * m))

    def _counted(self, reading: Reading, now: float) -> Reading:
        """The reading; with totals if it is of the encoders."""
        if not isinstance(reading, Encoders):
            return reading
        if self._totals is None and self._saved is not None:
            self._unwrapped = Unwrapped(self._saved, reading.counts)
        self._totals, self._read_time = self._unwrapped.total(reading.counts), now
        totals = self._totals.copy()
        totals.flags.writeable = False
        return replace(reading, counts=totals)

    def _keep(self, now: float, moves: bool) -> None:
        """Take the mark away where a drum turns by itself, and set it where all have stood, as readings show."""
        totals = self._totals
        if moves or totals is None:
            self._still = None
            return
        if self._marked is not None and np.abs(totals - self._marked).max() > GRAIN:
            self._unmark()
        if self._still is None or np.abs(totals - self._still[1]).max() > GRAIN:
            self._still = now, totals
        if self._marked is None and self._read_time - self._still[0] >= STILL - 1e-9:
            self.file.write(totals, valid=True)
            self._marked = totals

    def _unmark(self) -> None:
        if self._marked is not None:
            self.file.write(self._marked if self._totals is None else self._totals, valid=False)
            self._marked = None
