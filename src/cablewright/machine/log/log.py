"""A machine's log: an MCAP file with all frames, commands and, of a simulation, the truth; readable even if cut off."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import IO, Final, Self, TypeVar

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import cannot_write, open_no_link
from cablewright.foundation.signals import (
    Command,
    Condition,
    Estimate,
    Notice,
    Order,
    Progress,
    Reading,
    Scan,
    SensorFrame,
    Truth,
    miscounted,
)
from cablewright.machine.log.disk_thread import DiskThread
from cablewright.machine.log.foxglove_views import VIEWS, Views
from cablewright.machine.log.head import LogHead, read_head, written_head
from cablewright.machine.log.mcap_file import RawMessage
from cablewright.machine.log.mcap_writer import McapWriter
from cablewright.machine.log.messages import decode, encode, encode_frame
from cablewright.machine.log.segments import CLOSING_TOPIC, Segments, log_files
from cablewright.machine.log.thinned_steps import Logged, ThinnedSteps
from cablewright.machine.log.topics import TOPICS, TOPICS_OF, Signal
from cablewright.robot import Robot

SCHEMAS: Final = {each.topic: (each.schema, each.content) for each in TOPICS} | VIEWS
"""Name and JSON schema of the messages of each topic that a log may have."""

_CHUNK: Final = 256 << 10  # bytes: a second or two

_Kind = TypeVar("_Kind")


@dataclass(frozen=True, eq=False)
class Entry:
    """One step of a log: the command, the frame, and, where known, truth, estimate and progress at its end."""

    frame: SensorFrame
    command: Command | None
    truth: Truth | None
    estimate: Estimate | None = None
    progress: Progress | None = None
    orders: tuple[Order, ...] = ()


class LogWriter:
    """Writes a log step by step; a context manager that ends the file.

    Every method raises `EnvironmentFault` where the file cannot be written; nothing is written to it from then on.
    """

    def __init__(
        self,
        file: IO[bytes],
        head: LogHead,
        *,
        flush_every: float | None = None,
        clock: Callable[[], float] | None = None,
        threaded: bool = False,
        drops: bool = False,
    ) -> None:
        """Begin a log in *file*, open for writing.

        With *flush_every* (s), by *clock* or else the machine's own, each step is handed to the operating system within
        that time, so that a killed program loses no more. Without it, a chunk of 256 KiB is written at a time.
        *threaded*: the file is written in a thread, which may be 64 MiB behind. Then this waits for the disk, or, with
        *drops*, leaves steps out until there is room, and the next step has a notice that says how many.
        """
        self.head = head
        self._winches, self._counts = head.robot.winch_names, head.settings.winch.counts
        self._file, self._failed, self._drops = file, False, drops
        self._disk = DiskThread() if threaded else None
        self._flush_every, self._clock, self._flushed = flush_every, clock, -math.inf
        run = () if self._disk is None else (self._disk.put,)
        with self._writing():
            self._writer = McapWriter(file, written_head(head), SCHEMAS, _CHUNK, *run)
        self._views, self._epoch, self._thinned = Views(head), head.epoch_ns, ThinnedSteps(head.every)
        self._lost: Logged | None = None  # the last step, where it was dropped
        self._gap = 0  # steps dropped since the last that was written
        self.dropped = 0  # steps

    def write(
        self,
        frame: SensorFrame,
        command: Command | None = None,
        truth: Truth | None = None,
        estimate: Estimate | None = None,
        progress: Progress | None = None,
        orders: Sequence[Order] = (),
    ) -> None:
        """Write one step: its command, readings and orders, and the truth, estimate and progress at its end.

        Of a log that is thinned, see `LogHead.every`, the step may wait for the next that is written.
        """
        if self._failed:
            raise EnvironmentFault(f"{self._name}: could not be written before; begin a new log")
        step = self._thinned.take(Logged(frame, command, truth, estimate, progress, tuple(orders)))
        if step is None:
            return
        try:
            if self._disk is not None and self._disk.full:
                if self._drops:
                    self._lost, self.dropped, self._gap = step, self.dropped + 1, self._gap + 1
                    return
                self._disk.wait()
            self._put(step)
        except OSError as reason:
            self._failed = True
            raise cannot_write(self._name, reason) from None
        if self._flush_every is not None:
            since = frame.time if self._clock is None else self._clock()
            if since - self._flushed >= self._flush_every - 1e-9:
                self._flushed = since
                self.flush()

    def _put(self, step: Logged) -> None:
        """Write the messages of a step."""
        frame = step.frame
        if self._gap:
            notice = Notice(Condition.LOG_BEHIND, f"{self._gap} steps")
            frame, self._lost, self._gap = replace(frame, notices=(*frame.notices, notice)), None, 0
        epoch, add, winches, counts = self._epoch, self._writer.add, self._winches, self._counts
        time, now = frame.time, epoch + round(frame.time * 1e9)
        for signal in (step.command, *frame.readings, *step.orders, step.truth, step.estimate, step.progress):
            if signal is not None:
                topic, data = encode(signal, winches, counts, epoch)
                same = signal.time == time >= 0.0
                add(topic, now, now if same else epoch + round(max(signal.time, 0.0) * 1e9), data)
        for topic, data in self._views.messages(frame.time, step.truth, step.estimate, step.progress):
            add(topic, now, now, data)
        add(CLOSING_TOPIC, now, now, encode_frame(frame))

    def flush(self) -> Future[None] | None:
        """Pass all that was written to the operating system, which keeps it even if this program is killed.

        A log that drops steps does not wait for that: it returns a future that ends when it is done.
        """
        with self._writing():
            self._writer.flush()
            if self._disk is None:
                return None
            if self._drops:
                return self._disk.last()
            self._disk.wait()
        return None

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn an `OSError` of the file into an `EnvironmentFault`."""
        if self._failed:
            raise EnvironmentFault(f"{self._name}: could not be written before; begin a new log")
        try:
            yield
        except OSError as reason:
            self._failed = True
            raise cannot_write(self._name, reason) from None

    @property
    def _name(self) -> str:
        return str(getattr(self._file, "name", "the log"))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Complete the file, unless it could not be written."""
        try:
            if not self._failed:
                with self._writing():
                    if self._lost is not None:  # written after all
                        self.dropped, self._gap = self.dropped - 1, self._gap - 1
                    for step in (self._lost, self._thinned.last):
                        if step is not None:
                            self._put(step)
                    self._writer.end_chunk()
                    if self._disk is not None:
                        self._disk.wait()
                    self._writer.finish()
                    self._file.flush()
        finally:
            if self._disk is not None:
                self._disk.close()


@contextmanager
def write_log(
    path: Path,
    head: LogHead,
    *,
    flush_every: float | None = 0.5,
    clock: Callable[[], float] | None = None,
    threaded: bool = False,
    drops: bool = False,
) -> Iterator[LogWriter]:
    """Open a log for writing in a new file at *path*, as `LogWriter`.

    Raises `EnvironmentFault` where it cannot be written.
    """
    file = open_no_link(path)
    try:
        with LogWriter(file, head, flush_every=flush_every, clock=clock, threaded=threaded, drops=drops) as log:
            yield log
    finally:
        with suppress(OSError):  # the writer has reported it already
            file.close()


class Log:
    """A log open for reading; a context manager that closes the file."""

    def __init__(self, path: Path) -> None:
        """Read the head of the log in the file or run folder *path*. Raises `InputError` where there is none."""
        self.path = path
        self._segments = Segments(log_files(path))
        first = self._segments.files[0]
        try:
            self.head = read_head(first.head, str(first.path))
        except InputError:
            self._segments.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._segments.close()

    @property
    def notes(self) -> list[str]:
        """Faults of the log file as far as it has been read, a sentence each."""
        return self._segments.notes

    @property
    def position(self) -> int:
        """Bytes of the log read so far."""
        return self._segments.position

    @property
    def size(self) -> int:
        """Size of the log, bytes."""
        return self._segments.size

    def entries(self, without: Collection[type[Signal] | str] = ()) -> Iterator[Entry]:
        """Yield the steps in order, once. A cut or damaged file is read as far as possible, with a note.

        *without*: types of signals, or topics, to leave out, which is faster: ``entries(without={Scan, "/command"})``.
        A frame that is not later than the one before is left out, with a notice in the next good one. Raises
        `InputError` for a complete message with invalid content.
        """
        topics = {topic for each in without for topic in ((each,) if isinstance(each, str) else TOPICS_OF[each])}
        topics.discard(CLOSING_TOPIC)
        topics |= VIEWS.keys()
        if self.head.every > 1:
            self.notes.append(f"thinned to one of {self.head.every} steps: results are of these steps alone")
        last, skipped, behind = -1.0, 0, 0
        file = self._segments.file
        for step in self._segments.steps(topics):
            origin = str(self._segments.file.path)
            *signals, frame = (decode(each.topic, each.data, origin) for each in step)
            assert isinstance(frame, SensorFrame)  # it closes the step
            for each in signals:
                _require_lines(each, self.head.robot, origin)
            if frame.time > last:
                if self._segments.file is not file:
                    file = self._segments.file
                    if frame.time > last + 1.5 * self.head.every * self.head.period:
                        self.notes.append(f"nothing was logged from {last:g} to {frame.time:g} s")
                notices = frame.notices + ((Notice(Condition.CLOCK_BACK),) if skipped else ())
                last, skipped = frame.time, 0
                behind += any(each.condition is Condition.LOG_BEHIND for each in notices)
                yield _entry(frame.time, notices, signals)
            else:
                if not skipped:
                    self.notes.append(f"the clock jumps back from {last:g} to {frame.time:g} s: frames left out")
                skipped += 1
        if behind:
            self.notes.append(f"steps are left out in {behind} places: the disk was slower than the log")

    def scans_at(self, times: Sequence[float]) -> Iterator[tuple[Scan, ...]]:
        """Yield for each of *times*, s, which rise, the last scan of each lidar before it.

        Once, in place of `entries`. Only scans that are yielded are decoded. Raises `InputError` for a scan with
        invalid content.
        """
        topics, left = {*TOPICS_OF[Scan], CLOSING_TOPIC}, list(times)[::-1]
        newest: dict[str, RawMessage] = {}
        for step in self._segments.steps(SCHEMAS.keys() - topics):
            newest |= {each.topic: each for each in step[:-1]}
            now = 1e-9 * (step[-1].logged - self.head.epoch_ns)
            while left and left[-1] <= now + 1e-9:
                left.pop()
                found = (decode(each.topic, each.data, str(self.path)) for each in newest.values())
                yield tuple(each for each in found if isinstance(each, Scan))


def _entry(time: float, notices: tuple[Notice, ...], signals: Sequence[Signal | SensorFrame | None]) -> Entry:
    """Return the step with these *signals*."""
    readings = tuple(each for each in signals if isinstance(each, Reading))
    others = (_last(signals, Command), _last(signals, Truth), _last(signals, Estimate), _last(signals, Progress))
    orders = tuple(each for each in signals if isinstance(each, Order))
    return Entry(SensorFrame(time, readings, notices), *others, orders)


def _require_lines(signal: object, robot: Robot, origin: str) -> None:
    """Raise `InputError` where a signal has not a number for each line, or winch, of the *robot* of the head."""
    wrong = miscounted(signal, robot.m, robot.winches)
    if wrong is not None:
        name, given, right = wrong
        what = f"{right} {'lines' if right == robot.m else 'winches'}"
        kind = type(signal).__name__
        raise InputError(f"{origin}: {name} of a {kind}: {given} numbers; the robot of the log has {what}")


def _last(signals: Sequence[object], kind: type[_Kind]) -> _Kind | None:
    return next((each for each in reversed(signals) if isinstance(each, kind)), None)


def read_log(path: str | Path) -> Log:
    """Open the log in the file or run folder at *path*; use it in a ``with``. Raises `InputError` where there is none.

    A folder may hold several segments of interrupted runs: see `cablewright.machine.log.segments`.
    """
    return Log(Path(path))
