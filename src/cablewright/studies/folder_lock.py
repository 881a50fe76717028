"""One program at a time: a file that the system lets go of when the program ends, however it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cablewright.errors import EnvironmentFault
from cablewright.file_output import cannot_write

if sys.platform == "win32":
    import msvcrt

    def _lock(number: int) -> None:
        msvcrt.locking(number, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(number: int) -> None:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)


__all__ = ["held"]


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold the file at *path*. Raises `EnvironmentFault` where another program does, or it cannot be made."""
    try:
        file = path.open("wb")
    except OSError as reason:
        raise cannot_write(path, reason) from None
    with file:
        try:
            _lock(file.fileno())
        except OSError:
            raise EnvironmentFault(f"{path.parent}: another program works in this folder") from None
        yield
