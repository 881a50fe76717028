"""A machine's log: an MCAP file with all frames, commands and, of a simulation, the truth; read as far as it goes."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Final, Self, TypeVar

import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk
from mcap.writer import CompressionType, IndexType, Writer
from pydantic import ValidationError

from cablewright.errors import InputError
from cablewright.machine.messages import Signal, decode, encode, encode_frame
from cablewright.machine.settings import MachineSettings
from cablewright.machine.topics import TOPICS
from cablewright.robot import Robot
from cablewright.signals import Command, Condition, Estimate, Notice, Progress, SensorFrame, Truth

__all__ = ["MOST_RECORD", "Entry", "Log", "LogHead", "LogWriter", "read_log"]

MOST_RECORD: Final = 64 << 20
"""The longest record, and the largest chunk once unpacked, that is read, bytes."""

NEWEST_SCHEMA: Final = 1
_CHUNK: Final = 256 << 10  # bytes: a second or two; what a crash loses
_HEAD: Final = "cablewright"
_BESIDE: Final = (Command, Truth, Estimate, Progress)  # what is no reading
_BROKEN: Final = (McapError, CRCValidationError, zstandard.ZstdError, struct.error, UnicodeDecodeError, MemoryError)


_Kind = TypeVar("_Kind")


@dataclass(frozen=True)
class LogHead:
    """What a log says of itself: whose it is and how it was made. ``robot`` is the description, not the truth."""

    robot: Robot
    settings: MachineSettings
    period: float  # s
    plant: str
    seed: int


@dataclass(frozen=True, eq=False)
class Entry:
    """One step: what was commanded, what came back, and what was true after it, where the log has that."""

    frame: SensorFrame
    command: Command | None
    truth: Truth | None
    estimate: Estimate | None = None
    progress: Progress | None = None


class LogWriter:
    """Writes a log step by step; a context manager that ends the file."""

    def __init__(self, file: IO[bytes], head: LogHead) -> None:
        """Begin a log in *file*, open for writing."""
        self.head = head
        self._lines = tuple(line.name for line in head.robot.lines)
        self._writer = Writer(
            file, chunk_size=_CHUNK, compression=CompressionType.ZSTD, index_types=IndexType.ALL, enable_crcs=True
        )
        self._writer.start(profile="", library="cablewright")
        about = {
            "schema": NEWEST_SCHEMA,
            "robot": head.robot.model_dump(mode="json"),
            "settings": head.settings.model_dump(mode="json"),
            "period": head.period,
            "plant": head.plant,
            "seed": head.seed,
        }
        self._writer.add_metadata(_HEAD, {key: json.dumps(value) for key, value in about.items()})
        self._channels: dict[str, int] = {}
        for topic in TOPICS:
            schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": topic.schema}
            number = self._writer.register_schema(
                topic.schema, "jsonschema", json.dumps(schema | topic.content).encode()
            )
            self._channels[topic.topic] = self._writer.register_channel(topic.topic, "json", number)

    def write(
        self,
        frame: SensorFrame,
        command: Command | None = None,
        truth: Truth | None = None,
        estimate: Estimate | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Write one step: the command that it began with, its readings, the truth at its end, what was made of them."""
        now = round(frame.time * 1e9)
        counts = self.head.settings.winch.counts
        told: tuple[Signal | None, ...] = (command, *frame.readings, truth, estimate, progress)
        for signal in told:
            if signal is None:
                continue
            self._add(*encode(signal, self._lines, counts), now, round(max(signal.time, 0.0) * 1e9))
        self._add(*encode_frame(frame), now, now)

    def _add(self, topic: str, data: bytes, now: int, measured: int) -> None:
        self._writer.add_message(self._channels[topic], log_time=now, data=data, publish_time=measured)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the file, so that it is whole as far as it goes, whatever happened."""
        self._writer.finish()  # type: ignore[no-untyped-call]


class Log:
    """A log open for reading. ``notes`` grows while frames are read: what is wrong with the file, a sentence each."""

    def __init__(self, path: Path, file: BufferedReader) -> None:
        """Read the head. Raises `InputError` for a file that is no log of a machine."""
        self.path, self.notes = path, list[str]()
        self._file = file
        self._topics: dict[int, str] = {}
        self._records = self._unpacked()
        self.head = self._read_head()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    @property
    def position(self) -> int:
        """Bytes of the file that have been read."""
        return self._file.tell()

    def entries(self) -> Iterator[Entry]:
        """Yield the steps in order, once. What a cut or damaged file still holds is yielded, and a note says the rest.

        A frame whose clock is not past the one before is left out, with a notice in the next good one. Raises
        `InputError` for a message that is whole but wrong.
        """
        told: list[Signal] = []
        last, skipped = -1.0, 0
        for record in self._records:
            if not isinstance(record, Message):
                continue
            signal = decode(self._topics.get(record.channel_id, ""), record.data, str(self.path))
            if signal is None:
                continue
            if not isinstance(signal, SensorFrame):
                told.append(signal)
                continue
            if signal.time > last:
                notices = signal.notices + ((Notice(Condition.CLOCK_BACK),) if skipped else ())
                last, skipped = signal.time, 0
                yield _entry(signal.time, notices, told)
            else:
                if not skipped:
                    self.notes.append(f"the clock jumps back from {last:g} to {signal.time:g} s: frames left out")
                skipped += 1
            told = []
        if told:
            self.notes.append(f"the step after {max(last, 0.0):g} s is not whole: left out")

    def _unpacked(self) -> Iterator[McapRecord]:
        """Yield all records, those in chunks too, up to where the file is cut or damaged."""
        reader = StreamReader(self._file, emit_chunks=True, record_size_limit=MOST_RECORD)
        try:
            for record in reader.records:
                if isinstance(record, Chunk):
                    if record.uncompressed_size > MOST_RECORD:
                        raise InputError(
                            f"{self.path}: a chunk of {record.uncompressed_size} bytes; at most {MOST_RECORD} are read"
                        )
                    yield from map(self._noted, breakup_chunk(record, validate_crc=True))
                else:
                    yield self._noted(record)
                    if isinstance(record, Footer):
                        return
        except _BROKEN:
            self.notes.append(f"cut or damaged before byte {self._file.tell()}: read up to there")

    def _noted(self, record: McapRecord) -> McapRecord:
        """Remember the topic of a channel."""
        if isinstance(record, Channel):
            self._topics[record.id] = record.topic
        return record

    def _read_head(self) -> LogHead:
        for record in self._records:
            if isinstance(record, Metadata) and record.name == _HEAD:
                return _head(record.metadata, str(self.path))
            if isinstance(record, Message):
                break
        why = self.notes[0] if self.notes else "it does not begin as one"
        raise InputError(f"{self.path}: no log of a machine: {why}")


def _entry(time: float, notices: tuple[Notice, ...], told: list[Signal]) -> Entry:
    """A step of what was *told* in it."""
    readings = tuple(each for each in told if not isinstance(each, _BESIDE))
    beside = (_last(told, Command), _last(told, Truth), _last(told, Estimate), _last(told, Progress))
    return Entry(SensorFrame(time, readings, notices), *beside)


def _last(told: list[Signal], kind: type[_Kind]) -> _Kind | None:
    return next((each for each in reversed(told) if isinstance(each, kind)), None)


def read_log(path: str | Path) -> Log:
    """Open the log at *path*; use it in a ``with``. Raises `InputError` where there is none."""
    path = Path(path)
    try:
        if not path.is_file():
            raise InputError(f"{path}: {'not a regular file' if path.exists() else 'no such file'}")
        file = path.open("rb")
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None
    try:
        return Log(path, file)
    except InputError:
        file.close()
        raise


def _head(texts: dict[str, str], origin: str) -> LogHead:
    """Read the log's own metadata. Raises `InputError`."""
    try:
        values: dict[str, Any] = {key: json.loads(text) for key, text in texts.items()}
    except (ValueError, RecursionError):
        raise InputError(f"{origin}: the head is no JSON") from None
    schema = values.get("schema")
    if type(schema) is not int or not 1 <= schema <= NEWEST_SCHEMA:
        raise InputError(f"{origin}: schema {schema!r} of the log: this cablewright reads 1 to {NEWEST_SCHEMA}")
    try:
        robot = Robot.model_validate(values.get("robot"))
        settings = MachineSettings.model_validate(values.get("settings"))
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise InputError(f"{origin}: the head's {where or 'robot'}: {first['msg']}") from None
    period, seed = values.get("period"), values.get("seed")
    if not isinstance(period, float) or not 0.0 < period < 1e6 or type(seed) is not int:
        raise InputError(f"{origin}: the head has no period and seed")
    return LogHead(robot, settings, period, str(values.get("plant"))[:60], seed)
