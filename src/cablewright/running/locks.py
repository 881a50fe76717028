"""Locks of files and folders that one program at a time may use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.file_output import cannot_write


@contextmanager
def locked(lock: Path, taken: str, file: Path | None = None) -> Iterator[None]:
    """Hold the file *lock*, which the system releases when the program ends, even if it is killed.

    Raises `EnvironmentFault`, which says *taken*, where another program holds the lock, and where it cannot be made,
    or *file* beside it cannot be written: a link is not followed.
    """
    held = FileLock(lock, blocking=False, fallback_to_soft=False)  # a soft lock outlives a killed program
    try:
        held.acquire()
    except Timeout:
        raise EnvironmentFault(taken) from None
    except OSError as reason:
        raise cannot_write(file or lock, reason) from None
    try:
        yield
    finally:
        held.release()
