"""Reader of one MCAP file of a log, as far as it is intact; messages are not decoded."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import Final, NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import CRCValidationError, StreamReader

from cablewright.foundation.errors import InputError

MAX_RECORD: Final = 64 << 20
"""Limit of a record, of an uncompressed chunk, and of the messages of one step, bytes."""

HEAD: Final = "cablewright"
"""Name of the metadata record of a log."""

_RECORD: Final = struct.Struct("<BQ")  # opcode and length
_MESSAGE: Final = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
BROKEN: Final = (
    McapError,
    CRCValidationError,
    zstandard.ZstdError,
    struct.error,
    EOFError,
    MemoryError,
    OverflowError,
    RuntimeError,
    ValueError,
)
"""What mcap and the decompressors raise for damaged data: ValueError also of text that is not UTF-8."""


class RawMessage(NamedTuple):
    """A message of a log as stored; times in ns."""

    topic: str
    logged: int
    measured: int
    data: bytes


class LogFile:
    """An MCAP file open for reading, as far as it is intact. ``cut``: the byte before which it is cut or damaged."""

    def __init__(self, path: Path) -> None:
        """Open the file and read the log's metadata. Raises `InputError` for a file that is no log of a machine."""
        self.path, self.cut = path, 0
        self._topics: dict[int, str] = {}
        self._excluded: Collection[str] = ()
        try:
            if not path.is_file():
                raise InputError(f"{path}: {'not a regular file' if path.exists() else 'no such file'}")
            self._file = path.open("rb")
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise InputError(f"{path}: cannot be read: {reason}") from None
        self._records = self._read()
        try:
            self.head: Mapping[str, str] = self._read_head()
        except InputError:
            self.close()
            raise

    @property
    def position(self) -> int:
        """Bytes of the log file read so far."""
        return self._file.tell()

    def close(self) -> None:
        """Close the log file."""
        self._file.close()

    def messages(self, without: Collection[str] = ()) -> Iterator[RawMessage]:
        """Yield the messages in order, once, leaving out the topics *without*."""
        self._excluded = without
        for each in self._records:
            if isinstance(each, RawMessage):
                yield each

    def _read_head(self) -> Mapping[str, str]:
        for each in self._records:
            if isinstance(each, RawMessage):
                break
            if each.name == HEAD:
                return each.metadata
        why = f"cut or damaged before byte {self.cut}" if self.cut else "it has no metadata of one at its beginning"
        raise InputError(f"{self.path}: this file is not a log of a machine: {why}")

    def _read(self) -> Iterator[RawMessage | Metadata]:
        """Yield messages and metadata, up to where the file is cut or damaged."""
        reader = StreamReader(self._file, emit_chunks=True, record_size_limit=MAX_RECORD)
        try:
            for record in reader.records:
                if isinstance(record, Chunk):
                    yield from self._chunk(record)
                elif isinstance(record, Footer):
                    return
                else:
                    yield from self._plain(record)
        except BROKEN:
            self.cut = self._file.tell()

    def _plain(self, record: McapRecord) -> Iterator[RawMessage | Metadata]:
        """Yield the message or metadata of a record outside chunks."""
        if isinstance(record, Channel):
            self._topics[record.id] = record.topic
        elif isinstance(record, Metadata):
            yield record
        elif isinstance(record, Message) and record.channel_id in self._topics:
            topic = self._topics[record.channel_id]
            if topic not in self._excluded:
                yield RawMessage(topic, record.log_time, record.publish_time, record.data)

    def _chunk(self, chunk: Chunk) -> Iterator[RawMessage]:
        """Yield the messages of a chunk, five times as fast as mcap's own reader, which also decodes excluded ones."""
        if chunk.uncompressed_size > MAX_RECORD:
            found = chunk.uncompressed_size
            raise InputError(f"{self.path}: a chunk of {found} bytes; at most {MAX_RECORD} are read")
        data, at = unpacked(chunk), 0
        size = len(data)
        while at < size:
            opcode, length = _RECORD.unpack_from(data, at)
            at, end = at + _RECORD.size, at + _RECORD.size + length
            if end > size:
                raise struct.error("a record that is longer than its chunk")
            if opcode == Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(BytesIO(data[at:end])))
                self._topics[channel.id] = channel.topic
            elif opcode == Opcode.MESSAGE:
                number, _, logged, measured = _MESSAGE.unpack_from(data, at)
                topic = self._topics.get(number)
                if topic is not None and topic not in self._excluded:
                    yield RawMessage(topic, logged, measured, data[at + _MESSAGE.size : end])
            at = end


def unpacked(chunk: Chunk) -> bytes:
    """Return the records of a chunk: never more bytes than it declares, whatever its packed data would become.

    Raises one of `BROKEN` for other data than declared.
    """
    size, packed = chunk.uncompressed_size, BytesIO(chunk.data)
    if chunk.compression == "zstd":
        with zstandard.ZstdDecompressor(max_window_size=MAX_RECORD).stream_reader(packed) as stream:
            data = stream.read(size + 1)
    elif chunk.compression == "lz4":
        with lz4.frame.LZ4FrameFile(packed) as stream:
            data = stream.read(size + 1)
    elif not chunk.compression:
        data = chunk.data
    else:
        raise McapError(f"compression {chunk.compression!r}")
    if len(data) != size:
        raise struct.error("a chunk of another size than it declares")
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise CRCValidationError(expected=chunk.uncompressed_crc, actual=zlib.crc32(data), record=chunk)
    return data
