"""Log of events at a machine for the operator's page, and of every order in a file."""

from __future__ import annotations

import json
import os
import time
from collections import deque
from dataclasses import dataclass, field
from datetime import UTC, datetime
from io import FileIO
from pathlib import Path
from typing import Any, Final

from cablewright.foundation.file_output import cannot_write

KEPT: Final = 60
"""Number of answers and events that are sent."""


@dataclass(eq=False)
class Events:
    """Events, the latest last, and a file of all orders: a line of JSON each."""

    path: Path
    file: FileIO
    told: deque[tuple[int, float, str, str]] = field(default_factory=lambda: deque(maxlen=KEPT))
    answers: deque[tuple[int, str, str]] = field(default_factory=lambda: deque(maxlen=KEPT))
    _count: int = 0

    @classmethod
    def at(cls, path: Path) -> Events:
        """Return events with orders written to *path*, after existing ones. Raises `EnvironmentFault`."""
        try:
            return cls(path, _opened(path))
        except OSError as reason:
            raise cannot_write(path, reason) from None

    def tell(self, kind: str, text: str) -> None:
        """Record an event for the operator's page; repetitions count once."""
        if self.told and self.told[-1][2:] == (kind, text):
            return
        self._count += 1
        self.told.append((self._count, time.time(), kind, text))

    def keep(self, order: dict[str, Any]) -> None:
        """Write an order with its UTC to the file of orders.

        On an error an event reports it, and the work continues.
        """
        stamp = {"utc": datetime.now(UTC).isoformat(timespec="milliseconds")}
        try:
            if not os.fstat(self.file.fileno()).st_nlink:  # it was removed: writes to it are lost
                removed, self.file = self.file, _opened(self.path)
                removed.close()
            end = os.fstat(self.file.fileno()).st_size
            torn = end > 0 and os.pread(self.file.fileno(), 1, end - 1) != b"\n"  # by a kill, or a disk that was full
            line = b"\n" * torn + json.dumps(stamp | order).encode() + b"\n"
            if self.file.write(line) != len(line):
                raise OSError("no space is left for the whole line")
        except OSError as reason:
            fault = cannot_write(self.path, reason)
            self.tell("fault", f"{fault}: this order is not kept; make room, or put the folder back")

    def close(self) -> None:
        """Close the file that records the operators' orders."""
        self.file.close()


def _opened(path: Path) -> FileIO:
    """The file, to read and append to without a buffer, whatever its last line; a link is not followed."""

    def no_link(name: str, flags: int) -> int:
        return os.open(name, flags | os.O_NOFOLLOW, 0o600)

    return FileIO(path, "ab+", opener=no_link)
