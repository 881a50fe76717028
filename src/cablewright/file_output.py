"""Writing files so that each is there whole or not at all, whatever ends the program or stands in its place."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from cablewright.errors import EnvironmentFault


@contextmanager
def whole_file(path: Path, *, parents: bool = False) -> Iterator[IO[bytes]]:
    """A file to write to, which takes the place of *path* when the block ends well, and is on the disk by then.

    On an error *path* is as it was and nothing is left beside it. With *parents* missing folders are made. Raises
    `EnvironmentFault` where the file cannot be written.
    """
    folder = path.absolute().parent
    part = folder / f".{secrets.token_hex(8)}.part"  # a name that nobody can guess and put a link there
    try:
        if parents:
            folder.mkdir(parents=True, exist_ok=True)
        with part.open("xb") as file:  # x: a new file, or an error; no link is followed
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        _sync(folder)
    except OSError as reason:
        raise cannot_write(path, reason) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_whole(path: Path, content: bytes, *, parents: bool = False) -> None:
    """Write *content* to *path*, see `whole_file`. Raises `EnvironmentFault`."""
    with whole_file(path, parents=parents) as file:
        file.write(content)


def open_no_link(path: Path) -> IO[bytes]:
    """Open *path* to write from its beginning, for files that others read while they grow. Raises `EnvironmentFault`.

    A symbolic link there is refused, not followed, where the system can tell (not on Windows).
    """

    def opener(name: str, flags: int) -> int:
        return os.open(name, flags | getattr(os, "O_NOFOLLOW", 0), 0o666)

    try:
        return open(path, "wb", opener=opener)
    except OSError as reason:
        raise cannot_write(path, reason) from None


def cannot_write(path: Path | str, reason: OSError) -> EnvironmentFault:
    """What to raise where *path* cannot be written or removed: one line, with the system's *reason*."""
    return EnvironmentFault(f"{path}: cannot be written: {reason.strerror or reason}")


def _sync(folder: Path) -> None:
    """Have the names in *folder* on the disk; only POSIX opens folders."""
    if os.name == "posix":
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
