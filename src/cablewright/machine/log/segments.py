"""The files of one log in order. A run that was killed and resumed leaves several; each supersedes the end of the last.

In a run folder they are ``log.mcap``, if segments were joined before, then ``log-000.mcap``, ``log-001.mcap``, ...
Steps of a file at or after the first step of a later one are superseded by the later one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cablewright.foundation.errors import InputError
from cablewright.machine.log.head import VERSIONS, epoch_of
from cablewright.machine.log.mcap_file import MAX_RECORD, LogFile, RawMessage

JOINED_NAME: Final = "log.mcap"
"""Name of the log of a run folder, once its segments are joined."""

FIRST_SEGMENT: Final = "log-000.mcap"
"""Name of the first file of a log that no joined one precedes."""

CLOSING_TOPIC: Final = "/frame"
"""Topic of the message that comes last in each step."""

_NAME: Final = re.compile(r"log-(\d{3,9})\.mcap")


@dataclass(frozen=True)
class Segment:
    """One file of a log, and the time, ns, from which a later one supersedes it."""

    path: Path
    head: Mapping[str, str]
    size: int  # bytes
    end: float


def log_files(path: Path) -> list[Path]:
    """Return the files of the log at *path*: itself, or those of a run folder in order. Raises `InputError`."""
    if not path.is_dir():
        return [path]
    try:
        found = [path / JOINED_NAME] if (path / JOINED_NAME).exists() else []
        found += [path / name for _, name in sorted(_numbered(path))]
    except OSError as reason:
        raise InputError(f"{path}: cannot be read: {reason.strerror}") from None
    if not found:
        raise InputError(f"{path}: no log in this folder: neither {JOINED_NAME} nor {FIRST_SEGMENT}")
    return found


def next_segment(folder: Path) -> Path:
    """Return the path for the next segment of the log in *folder*."""
    return folder / f"log-{max((number for number, _ in _numbered(folder)), default=-1) + 1:03}.mcap"


def _numbered(folder: Path) -> list[tuple[int, str]]:
    matches = (_NAME.fullmatch(path.name) for path in folder.iterdir())
    return [(int(match[1]), match[0]) for match in matches if match]


class Segments:
    """The files of one log, read one after another. ``notes``: their faults so far, a sentence each."""

    def __init__(self, paths: Sequence[Path]) -> None:
        """Read the files' heads. Raises `InputError` where there is no log, or for files of different machines."""
        self.notes: list[str] = []
        found: list[Segment] = []
        until = math.inf
        for path in reversed(paths):
            try:
                head, first = _begin(path, alone=len(paths) == 1)
            except InputError as error:
                if len(paths) == 1:
                    raise
                self.notes.append(f"{error}: left out")
                continue
            found.append(Segment(path, head, path.stat().st_size, until))
            until = min(until, first)
        if not found:
            raise InputError(f"{paths[0]}: neither this file nor any of {len(paths)} segments is a log of a machine")
        self.files = tuple(reversed(found))
        for each in self.files[1:]:
            if _identity(each.head) != _identity(self.files[0].head):
                raise InputError(f"{each.path}: belongs to another machine or run than {self.files[0].path.name}")
        self.file = LogFile(self.files[0].path)
        """The file that is being read."""
        self._read = 0  # bytes of the files before it

    @property
    def position(self) -> int:
        """Bytes read so far of a log in several files."""
        return self._read + self.file.position

    @property
    def size(self) -> int:
        """Bytes of all files of the log."""
        return sum(each.size for each in self.files)

    def close(self) -> None:
        """Close the file of the log that is being read."""
        self.file.close()

    def steps(self, without: Collection[str] = ()) -> Iterator[list[RawMessage]]:
        """Yield the messages of each complete step in order, once, leaving out the topics *without*.

        Raises `InputError` for a step of over `MAX_RECORD` bytes.
        """
        for number, segment in enumerate(self.files):
            if number:
                self._read += self.files[number - 1].size
                self.file.close()
                self.file = LogFile(segment.path)
            step, size, begin = list[RawMessage](), 0, epoch_of(segment.head)
            last = begin
            for each in self.file.messages(without):
                size += len(each.data)
                if size > MAX_RECORD:
                    raise InputError(f"{segment.path}: a step of over {MAX_RECORD} bytes")
                step.append(each)
                if each.topic == CLOSING_TOPIC:
                    if each.logged >= segment.end:
                        break
                    yield step
                    step, size, last = [], 0, each.logged
            if segment is self.files[-1]:
                if self.file.cut:
                    self.notes.append(f"cut or damaged before byte {self.file.cut}: read up to that byte")
                if step:
                    self.notes.append(f"the step after {1e-9 * (last - begin):g} s is not complete: left out")


def _identity(head: Mapping[str, str]) -> dict[str, str]:
    """What segments of one run have in common: all of the head but the versions of the programs that wrote them."""
    return {key: text for key, text in head.items() if key != VERSIONS}


def _begin(path: Path, *, alone: bool) -> tuple[Mapping[str, str], float]:
    """Return the head of a file and the time of its first step, ns; infinite if it is *alone*. Raises `InputError`."""
    file = LogFile(path)
    try:
        if alone:
            return file.head, math.inf
        first = next((each.logged for each in file.messages() if each.topic == CLOSING_TOPIC), math.inf)
        return file.head, first
    finally:
        file.close()
