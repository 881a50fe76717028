"""Encoder counts of winches, continued over the wrap of their counters and kept over a loss of power.

Counts on disk are valid only between a standstill, with all brakes closed for a while, and the next motion: the mark is
removed on disk before winches are switched on, and when one turns without a command. The file also has the raw
counters, and an epoch: a number that changes whenever counts begin again, so that lengths of another epoch are never
used with them. A program that finds the mark compares the counters. Where they are the same, nothing has turned. Where
all begin at zero, they have lost power: the counts go on, and only its lengths can show whether a drum was turned
meanwhile. Anything else is an uncounted motion: a new epoch begins.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.signals import (
    Command,
    Condition,
    Drives,
    DriveState,
    Encoders,
    Notice,
    Reading,
    SensorFrame,
    WinchMode,
)
from cablewright.foundation.toml_input import read_bytes
from cablewright.machine.interface import Abilities, Machine

BITS: Final = 32
"""Bits of a counter."""

STILL: Final = 1.0
"""Time without a change of counts, s, after which held winches are taken to stand."""

GRAIN: Final = 2
"""Counts by which an encoder at rest may flicker."""

_ZERO: Final = 16  # counts of a counter that has begun at zero with its power

_MAX_FILE: Final = 1 << 20  # bytes


class Unwrapped:
    """Totals of counters that wrap around; each must be read before it turns by half its range."""

    def __init__(self, totals: NDArray[np.int64] | None = None, raw: NDArray[np.int64] | None = None) -> None:
        """Begin with the first reading as totals, or with known *totals* (m,) at the *raw* counts (m,) of then."""
        self._totals, self._raw = totals, raw

    def total(self, raw: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the totals (m,) for *raw* counts (m,), of `BITS` bits, signed or not."""
        if self._totals is None or self._raw is None:
            self._totals = raw.copy()
        else:
            half = 1 << (BITS - 1)
            self._totals = self._totals + ((raw - self._raw + half) % (1 << BITS) - half)
        self._raw = raw.copy()
        return self._totals.copy()


_Count = Annotated[int, Field(ge=-(2**62), le=2**62)]


class CountsFile(BaseModel):
    """Common content of all files of counts: robot, lines and epoch."""

    model_config = ConfigDict(extra="forbid", strict=True)

    schema_number: Annotated[int, Field(alias="schema", ge=2, le=2)]
    robot: str
    lines: tuple[str, ...]
    epoch: Annotated[int, Field(ge=0, le=2**62)]
    counts: tuple[_Count, ...]


class _File(CountsFile):
    """Content of the file of counts: also the raw counters, and whether the counts are valid."""

    raw: tuple[_Count, ...]
    valid: bool


@dataclass(frozen=True, eq=False)
class SavedCounts:
    """Saved total counts (m,) in an *epoch*, raw counters (m,) of that time, and whether no drum has turned since."""

    epoch: int
    counts: NDArray[np.int64]
    raw: NDArray[np.int64]
    valid: bool

    def turned(self, raw: NDArray[np.int64]) -> bool:
        """Return whether, by the counters *raw* (m,), a drum has turned without being counted."""
        half = 1 << (BITS - 1)
        apart = (raw - self.raw + half) % (1 << BITS) - half
        return bool(np.abs(apart).max() > GRAIN) and bool(np.abs(raw).max() > _ZERO)


class CountFile:
    """The file of a machine's counts on disk."""

    def __init__(self, path: Path, robot: str, lines: Sequence[str]) -> None:
        """Use the file at *path*, which need not exist, for the winches of *robot* for *lines*."""
        self.path, self._robot, self._lines = path, robot, tuple(lines)

    def read(self) -> SavedCounts | None:
        """Return the saved counts; None without a file. Raises `InputError` for a damaged or foreign file."""
        if not self.path.exists():
            return None
        try:
            found = _File.model_validate_json(read_bytes(self.path, _MAX_FILE, "saved counts"))
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            where = ".".join(map(str, first["loc"])) or "the file"
            raise InputError(f"{self.path}: {where}: {first['msg']}; home the machine again") from None
        if (found.robot, found.lines) != (self._robot, self._lines) or {len(found.counts), len(found.raw)} != {
            len(self._lines)
        }:
            raise InputError(f"{self.path}: holds counts of {found.robot!r}, lines {', '.join(found.lines)}")
        counts, raw = (np.array(each, dtype=np.int64) for each in (found.counts, found.raw))
        return SavedCounts(found.epoch, counts, raw, found.valid)

    def write(self, saved: SavedCounts) -> None:
        """Write counts, synced to disk. Raises `EnvironmentFault`."""
        content: dict[str, Any] = {"schema": 2, "robot": self._robot, "lines": self._lines, "epoch": saved.epoch}
        content |= {"counts": saved.counts.tolist(), "raw": saved.raw.tolist(), "valid": saved.valid}
        write_whole(self.path, json.dumps(content).encode() + b"\n")


@dataclass
class Remembering:
    """A machine that keeps its encoder counts on disk; its frames have total counts.

    Totals continue over wraps of the counters and over a loss of power. ``epoch``: identifies the series of totals; a
    new epoch begins where the totals on disk were not valid any more. If the file cannot be written at a standstill,
    frames have the notice NOT_SAVED. ``power_lost``: counters have begun again since the last saved totals.
    """

    machine: Machine
    file: CountFile
    epoch: int = 0
    power_lost: bool = False
    _unwrapped: Unwrapped = field(default_factory=Unwrapped, repr=False)
    _saved: SavedCounts | None = field(default=None, repr=False)  # valid on disk, before the first reading
    _totals: NDArray[np.int64] | None = field(default=None, repr=False)  # of the last reading
    _raw: NDArray[np.int64] | None = field(default=None, repr=False)  # of the last reading
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
        """Abilities of the machine."""
        return self.machine.abilities

    def open(self) -> None:
        """Connect to the machine; see `Machine.open`.

        Reads the saved counts. Raises `InputError` for a damaged file or one of another machine.
        """
        saved = self.file.read()
        self._saved = saved if saved is not None and saved.valid else None
        self._marked = None if self._saved is None else self._saved.counts
        self._unwrapped, self._totals, self._raw, self._still = Unwrapped(), None, None, None
        self.epoch, self.power_lost = time.time_ns() if self._saved is None else self._saved.epoch, False
        self.machine.open()

    def step(self, command: Command) -> SensorFrame:
        """Send *command*, wait for the step, and return the readings that arrived; see `Machine.step`.

        Raises `EnvironmentFault` where the mark of the saved counts cannot be removed: no command is sent then.
        """
        rests = self._is_rest(command)
        if not rests:
            self._unmark()
        self._time = command.time
        frame = self.machine.step(command)
        readings = tuple(self._counted(each, frame.time) for each in frame.readings)
        rests = rests and not any(DriveState.ENABLED in each.states for each in frame.of(Drives))
        notices = frame.notices
        try:
            self._keep(frame.time, rests)
        except EnvironmentFault:
            notices = (*notices, Notice(Condition.NOT_SAVED))
        return SensorFrame(frame.time, readings, notices)

    def stop(self) -> None:
        """Stop and hold all winches; see `Machine.stop`."""
        self.machine.stop()

    def close(self) -> None:
        """Disconnect from the machine; see `Machine.close`.

        Before that it waits, with brakes closed, until the counts can be saved as valid.
        """
        try:
            if WinchMode.OFF in self.abilities.modes and self._totals is not None:
                self._stand()
        finally:
            self.machine.close()

    def _is_rest(self, command: Command) -> bool:
        """Whether a command leaves all winches braked, or at rest where there are no brakes."""
        if WinchMode.OFF in self.abilities.modes:
            return bool(command.modes) and all(mode is WinchMode.OFF for mode in command.modes)
        return not command.winch_speeds.any() and WinchMode.TENSION not in command.modes

    def _stand(self) -> None:
        """Keep all winches off until their counts are saved, or for at most three times `STILL`."""
        m = self.abilities.winches
        for _ in range(round(3.0 * STILL / self.period)):
            if self._marked is not None and self._still is not None and self._read_time - self._still[0] >= STILL:
                return
            self.step(Command(self._time, np.zeros(m), modes=(WinchMode.OFF,) * m))

    def _counted(self, reading: Reading, now: float) -> Reading:
        """Return the *reading*; a reading of the encoders has total counts in place of raw counts."""
        if not isinstance(reading, Encoders):
            return reading
        if self._totals is None and self._saved is not None:
            self._go_on(self._saved, reading.counts)
        self._totals, self._read_time = self._unwrapped.total(reading.counts), now
        self._raw = reading.counts.copy()
        totals = self._totals.copy()
        totals.flags.writeable = False
        return replace(reading, counts=totals)

    def _go_on(self, saved: SavedCounts, raw: NDArray[np.int64]) -> None:
        """Continue from the saved counts, or begin a new epoch where a drum has turned since."""
        if saved.turned(raw):
            self.epoch, self._saved, self._marked = time.time_ns(), None, None
            return
        self.power_lost = bool(np.abs(raw - saved.raw).max() > GRAIN)
        self._unwrapped = Unwrapped(saved.counts, raw)

    def _keep(self, now: float, rests: bool) -> None:
        """Mark the counts on disk as valid once all drums have stood for `STILL`, and as invalid if a drum turns."""
        totals = self._totals
        if not rests or totals is None:
            self._still = None
            return
        if self._marked is not None and np.abs(totals - self._marked).max() > GRAIN:
            self._unmark()
        if self._still is None or np.abs(totals - self._still[1]).max() > GRAIN:
            self._still = now, totals
        if self._marked is None and self._read_time - self._still[0] >= STILL - 1e-9:
            self._write(totals, valid=True)
            self._marked = totals

    def _unmark(self) -> None:
        if self._marked is not None:
            self._write(self._marked if self._totals is None else self._totals, valid=False)
            self._marked = None

    def _write(self, totals: NDArray[np.int64], *, valid: bool) -> None:
        raw = self._raw
        if raw is None:
            assert self._saved is not None  # it is marked
            raw = self._saved.raw
        self.file.write(SavedCounts(self.epoch, totals, raw, valid))
