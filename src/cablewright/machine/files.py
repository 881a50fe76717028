"""Files that survive what happens to the program: they appear whole, by rename, and are on the disk when they do."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from cablewright.errors import EnvironmentFault

__all__ = ["appearing", "refused"]


@contextmanager
def appearing(path: Path) -> Iterator[IO[bytes]]:
    """A file to write to that takes the place of *path* when the block ends well.

    File and folder are on the disk by then. On an error nothing is left and *path* is as it was; raises
    `EnvironmentFault` where it cannot be written.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        with part.open("wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        if os.name == "posix":  # elsewhere a folder cannot be opened
            folder = os.open(path.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)
    except OSError as reason:
        raise refused(path, reason) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def refused(path: Path | str, reason: OSError) -> EnvironmentFault:
    """What to raise where *path* cannot be written or removed: one line, with the system's *reason*."""
    return EnvironmentFault(f"{path}: cannot be written: {reason.strerror or reason}")
