"""Results of a study on disk, by key: a file that grows by a line for each, so that a study can be resumed."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Final

from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import cannot_write
from cablewright.running.locks import locked

log = logging.getLogger(__name__)

HEAD: Final = b'{"cablewright": "results of a study, by key", "schema": 1}\n'
MAX_BYTES: Final = 1 << 29


class KeptResults:
    """Results of earlier calls by their keys; those that are added are on disk before the next chunk begins."""

    def __init__(self, path: Path = Path(), file: IO[bytes] | None = None, known: dict[str, str] | None = None) -> None:
        self._path, self._file = path, file
        self._known = {} if known is None else known  # the dictionary of `kept_in`
        self._unused = len(self._known)  # of the file, until one of them is used

    def get(self, key: str) -> str | None:
        """Return the JSON text of a result; None if it is not known."""
        found = self._known.get(key)
        if found is not None:
            self._unused = 0
        return found

    def tell_unused(self) -> None:
        """Warn once if the file has results and none of them is of this study."""
        if self._file is not None and self._unused:
            what = f"none of its {self._unused} results is of these inputs and this version"
            log.warning("%s: %s; the study starts again", self._path, what)
            self._unused = 0

    def add(self, results: Mapping[str, str]) -> None:
        """Add JSON texts of results by key. Raises `EnvironmentFault` where the disk is full or not writable."""
        self._known.update(results)
        if self._file is None:
            return
        lines = [f'{{"key": "{key}", "value": {text}}}\n' for key, text in results.items()]
        try:
            self._file.write("".join(lines).encode())
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as reason:
            raise cannot_write(self._path, reason) from None


@contextmanager
def kept_in(path: Path | None) -> Iterator[KeptResults]:
    """Context with the results in the file at *path*, created if missing; None: in memory alone.

    A last line that is not complete, as a killed program leaves, is dropped. Raises `InputError` for a file of another
    kind, `EnvironmentFault` where it cannot be written or another program uses it.
    """
    if path is None:
        yield KeptResults()
        return
    new_folder = not path.parent.exists()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as reason:
        raise cannot_write(path.parent, reason) from None
    name = path.with_name(f".{path.name}.lock")
    try:
        with locked(name, f"{path}: another program uses it", path):
            try:
                known, end = _read(path)
                try:
                    with _opened(path, end) as file:
                        yield KeptResults(path, file, known)
                finally:
                    if not known:  # a study that is rejected leaves nothing behind
                        path.unlink(missing_ok=True)
            finally:
                with suppress(OSError):  # Windows removes no file that is open
                    name.unlink()
    finally:
        if new_folder:
            with suppress(OSError):  # it holds results
                path.parent.rmdir()


@contextmanager
def _opened(path: Path, end: int) -> Iterator[IO[bytes]]:
    """Open the file to add lines after its first *end* bytes."""
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
    try:
        number = os.open(path, flags, 0o666)
    except OSError as reason:
        raise cannot_write(path, reason) from None
    with os.fdopen(number, "r+b") as file:
        file.truncate(end)
        file.seek(end)
        if not end:
            file.write(HEAD)
        yield file


def _read(path: Path) -> tuple[dict[str, str], int]:
    """Return the results in a file and how many bytes its complete lines have."""
    if not path.exists():
        return {}, 0
    if not path.is_file() or path.stat().st_size > MAX_BYTES:
        raise InputError(f"{path}: no results of a study, or more than {MAX_BYTES} bytes; choose another --out")
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    head, *lines = whole.splitlines(keepends=True) or [b""]
    if content and head != HEAD and not HEAD.startswith(content):
        raise InputError(f"{path}: holds no results of a study; remove it or choose another --out")
    known: dict[str, str] = {}
    for number, line in enumerate(lines, 2):
        entry = _entry(line)
        if entry is None:
            raise InputError(f"{path}: line {number} is no result of a study; remove the file or choose another --out")
        known[entry[0]] = entry[1]
    return known, len(whole)


def _entry(line: bytes) -> tuple[str, str] | None:
    """Return key and JSON text of a line; None if it is no result."""
    try:
        entry: Any = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(entry, dict) or entry.keys() != {"key", "value"} or not isinstance(entry["key"], str):
        return None
    return entry["key"], json.dumps(entry["value"])
