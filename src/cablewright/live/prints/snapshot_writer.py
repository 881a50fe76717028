"""Thread that writes snapshots of a print, so that a control loop does not wait for the disk."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Self

from cablewright.foundation.saved_state import Sign, Snapshot, write_snapshots


class SnapshotWriter:
    """Writes snapshots to *path* in its own thread: always the newest, each whole. A context manager.

    *sign*: see `write_snapshots`.
    The last one is on the disk when the block ends.
    """

    def __init__(self, path: Path, sign: Sign | None = None) -> None:
        self._path, self._sign, self._last = path, sign, Future[None]()
        self._last.set_result(None)
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="snapshots")

    def put(self, snapshots: Mapping[str, Snapshot], after: Future[None] | None = None) -> None:
        """Write *snapshots* soon, in place of any that wait, once *after* has ended.

        Raises the error of the last write.
        """
        if not self._last.cancel() and self._last.done():
            self._last.result()
        self._last = self._thread.submit(self._write, snapshots, after)

    def _write(self, snapshots: Mapping[str, Snapshot], after: Future[None] | None) -> None:
        if after is None or after.exception() is None:  # a checkpoint is never ahead of its log
            write_snapshots(self._path, snapshots, sign=self._sign)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for the last. Raises `EnvironmentFault` if it could not be written and the block raised nothing."""
        self._thread.shutdown()
        if error is None:
            self._last.result()
