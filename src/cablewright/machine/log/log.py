"""A machine's log: an MCAP file with all frames, commands and, of a simulation, the truth; readable even if cut off."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Final, Self, TypeVar

from mcap.writer import CompressionType, IndexType, Writer

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
from cablewright.machine.log.head import LogHead, read_head, written_head
from cablewright.machine.log.mcap_file import HEAD, RawMessage
from cablewright.machine.log.messages import decode, encode, encode_frame
from cablewright.machine.log.segments import CLOSING_TOPIC, Segments, log_files
from cablewright.machine.log.topics import TOPICS, TOPICS_OF, Signal
from cablewright.machine.log.views import VIEWS, Views
from cablewright.robot import Robot

SCHEMAS: Final = {each.topic: (each.schema, each.content) for each in TOPICS} | VIEWS
"""Name and JSON schema of the messages of each topic that a log may have."""

_CHUNK: Final = 256 << 10  # bytes: a second or two

_Kind = TypeVar("_Kind")


@dataclass(frozen=True, eq=False)
class Entry:
    """One step: the command, the frame, and, where the log has them, truth, estimate and progress at its end."""

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
    ) -> None:
        """Begin a log in *file*, open for writing.

        With *flush_every* (s), by *clock* or else the machine's own, each step is handed to the operating system within
        that time, so that a killed program loses no more. Without it, a chunk of 256 KiB is written at a time.
        """
        self.head = head
        self._winches = head.robot.winch_names
        self._file, self._failed = file, False
        self._flush_every, self._clock, self._flushed = flush_every, clock, -math.inf
        with self._writing():
            self._writer, self._channels = begin_log(file, written_head(head), _CHUNK)
        self._views, self._epoch = Views(head), head.epoch_ns

    def write(
        self,
        frame: SensorFrame,
        command: Command | None = None,
        truth: Truth | None = None,
        estimate: Estimate | None = None,
        progress: Progress | None = None,
        orders: Sequence[Order] = (),
    ) -> None:
        """Write one step: its command, readings and orders, and the truth, estimate and progress at its end."""
        now = self._epoch + round(frame.time * 1e9)
        counts = self.head.settings.winch.counts
        signals: tuple[Signal | None, ...] = (command, *frame.readings, *orders, truth, estimate, progress)
        with self._writing():
            for signal in signals:
                if signal is not None:
                    measured = self._epoch + round(max(signal.time, 0.0) * 1e9)
                    self._add(*encode(signal, self._winches, counts, self._epoch), now, measured)
            for topic, data in self._views.messages(frame.time, truth, estimate, progress):
                self._add(topic, data, now, now)
            self._add(*encode_frame(frame), now, now)
        if self._flush_every is not None:
            since = frame.time if self._clock is None else self._clock()
            if since - self._flushed >= self._flush_every - 1e-9:
                self._flushed = since
                self.flush()

    def flush(self) -> None:
        """Hand all that was written to the operating system, which keeps it even if this program is killed."""
        with self._writing():
            self._writer.flush()  # type: ignore[no-untyped-call]

    def _add(self, topic: str, data: bytes, now: int, measured: int) -> None:
        self._writer.add_message(self._channels.number(topic), log_time=now, data=data, publish_time=measured)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn an `OSError` of the file into an `EnvironmentFault`."""
        if self._failed:
            raise EnvironmentFault(f"{self._name}: could not be written before")
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
        if self._failed:
            return
        with self._writing():
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.flush()


@contextmanager
def write_log(
    path: Path, head: LogHead, *, flush_every: float | None = 0.5, clock: Callable[[], float] | None = None
) -> Iterator[LogWriter]:
    """A log in a new file at *path*, as `LogWriter`. Raises `EnvironmentFault` where it cannot be written."""
    file = open_no_link(path)
    try:
        with LogWriter(file, head, flush_every=flush_every, clock=clock) as log:
            yield log
    finally:
        with suppress(OSError):  # the writer has reported it already
            file.close()


class Channels:
    """The channels of a file, each from its first message on: no topic is empty."""

    def __init__(self, writer: Writer) -> None:
        """For what *writer* writes."""
        self._writer = writer
        self._numbers: dict[str, int] = {}

    def number(self, topic: str) -> int:
        """The number of a topic's channel."""
        if topic not in self._numbers:
            name, content = SCHEMAS[topic]
            about = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": name}
            schema = self._writer.register_schema(name, "jsonschema", json.dumps(about | content).encode())
            self._numbers[topic] = self._writer.register_channel(topic, "json", schema)
        return self._numbers[topic]


def begin_log(file: IO[bytes], head: Mapping[str, str], chunk: int) -> tuple[Writer, Channels]:
    """Begin an MCAP file with the *head*; return its writer, and the channels that it will have."""
    writer = Writer(
        file, chunk_size=chunk, compression=CompressionType.ZSTD, index_types=IndexType.ALL, enable_crcs=True
    )
    writer.start(profile="", library="cablewright")
    writer.add_metadata(HEAD, dict(head))
    return writer, Channels(writer)


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
        """Faults of the file as far as it has been read, a sentence each."""
        return self._segments.notes

    @property
    def position(self) -> int:
        """Bytes read so far."""
        return self._segments.position

    @property
    def size(self) -> int:
        """Bytes in all."""
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
        last, skipped = -1.0, 0
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
                    if frame.time > last + 1.5 * self.head.period:
                        self.notes.append(f"nothing was logged from {last:g} to {frame.time:g} s")
                notices = frame.notices + ((Notice(Condition.CLOCK_BACK),) if skipped else ())
                last, skipped = frame.time, 0
                yield _entry(frame.time, notices, signals)
            else:
                if not skipped:
                    self.notes.append(f"the clock jumps back from {last:g} to {frame.time:g} s: frames left out")
                skipped += 1

    def scans_at(self, times: Sequence[float]) -> Iterator[tuple[Scan, ...]]:
        """Yield for each of *times*, s, which rise, the last scan of each lidar by then. Once, in place of `entries`.

        Only what is yielded is decoded. Raises `InputError` for a scan with invalid content.
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
