"""Writing files so that each is complete or absent, even if the program is interrupted."""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import rmtree
from typing import IO

from cablewright.foundation.errors import EnvironmentFault


@contextmanager
def whole_file(path: Path, *, parents: bool = False) -> Iterator[IO[bytes]]:
    """Open a temporary file that replaces *path*, synced to disk, when the block ends without an error.

    On an error *path* does not change and the temporary file is removed. With *parents* missing folders are made.
    Raises `EnvironmentFault` where the file cannot be written.
    """
    folder = path.absolute().parent
    part = folder / f".{secrets.token_hex(8)}.part"  # not guessable, so that no other program can put a link there
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


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Make a temporary folder that becomes *path* when the block ends without an error.

    *path* must not exist, or be an empty folder: nothing is replaced. On an error the temporary folder is removed.
    Raises `EnvironmentFault` where the folder cannot be made, or is there.
    """
    part = path.absolute().parent / f".{secrets.token_hex(8)}.part"
    try:
        part.mkdir()
        yield part
        part.rename(path)
    except OSError as reason:
        raise cannot_write(path, reason) from None
    finally:
        rmtree(part, ignore_errors=True)


def is_unfinished(path: Path) -> bool:
    """Whether *path* has the name of a temporary file, such as a killed program leaves."""
    return re.fullmatch(r"\.[0-9a-f]{16}\.part", path.name) is not None


def write_whole(path: Path, content: bytes, *, parents: bool = False) -> None:
    """Write *content* to *path* as `whole_file` does. Raises `EnvironmentFault`."""
    with whole_file(path, parents=parents) as file:
        file.write(content)


def open_no_link(path: Path) -> IO[bytes]:
    """Open *path* to write from its start, for files that others read while they grow. Raises `EnvironmentFault`.

    A symbolic link is rejected, not followed (except on Windows).
    """

    def opener(name: str, flags: int) -> int:
        return os.open(name, flags | getattr(os, "O_NOFOLLOW", 0), 0o666)

    try:
        return open(path, "wb", opener=opener)
    except OSError as reason:
        raise cannot_write(path, reason) from None


def cannot_write(path: Path | str, reason: OSError) -> EnvironmentFault:
    """Return the error for a *path* that cannot be written or removed, with the system's *reason*."""
    return EnvironmentFault(f"{path}: cannot be written: {reason.strerror or reason}")


def _sync(folder: Path) -> None:
    """Sync the names in *folder* to disk; only POSIX can open folders."""
    if os.name == "posix":
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
