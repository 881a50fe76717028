"""Joining of a log's segments into one file that other programs can read."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from cablewright.foundation.file_output import cannot_write, whole_file
from cablewright.machine.log.log import SCHEMAS
from cablewright.machine.log.mcap_writer import McapWriter
from cablewright.machine.log.segments import JOINED_NAME, Segments, log_files

_MIN_CHUNK: Final = 1 << 20  # bytes
_MAX_CHUNK: Final = 32 << 20  # bytes
_MAX_CHUNKS: Final = 1000  # of a log up to 32 GB: the index of all chunks is held in memory


def join_log(folder: Path) -> Path:
    """Make one indexed file, ``log.mcap``, of the segments of the log in *folder*; return its path.

    Only once it is complete are the segments removed, first to last, so that a join interrupted anywhere leaves a log
    that reads the same. Superseded steps are left out. Raises `InputError` where there is no log, `EnvironmentFault`
    where it cannot be written.
    """
    path, files = folder / JOINED_NAME, log_files(folder)
    if files == [path]:
        return path
    segments = Segments(files)
    try:
        with whole_file(path) as file:
            chunk = min(max(_MIN_CHUNK, segments.size // _MAX_CHUNKS), _MAX_CHUNK)
            writer = McapWriter(file, segments.files[0].head, SCHEMAS, chunk)
            for step in segments.steps():
                for message in step:
                    if message.topic in SCHEMAS:
                        writer.add(*message)
            writer.end_chunk()
            writer.finish()
    finally:
        segments.close()
    for each in files:
        if each != path:
            try:
                each.unlink()
            except OSError as reason:
                raise cannot_write(each, reason) from None
    return path
