"""Writes snapshots in a background thread, so that a control loop does not wait for the disk."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from threading import Condition, Thread
from types import TracebackType
from typing import Self

from cablewright.errors import EnvironmentFault
from cablewright.machine.simulated.snapshot import Snapshot, write_snapshots


class SnapshotWriter:
    """Writes snapshots to *path* in its own thread: always the newest, each whole. A context manager.

    The last one is on the disk when the block ends.
    """

    def __init__(self, path: Path) -> None:
        """Start the thread."""
        self._path = path
        self._next: Mapping[str, Snapshot] | None = None
        self._fault: EnvironmentFault | None = None
        self._over = False
        self._changed = Condition()
        self._thread = Thread(target=self._work, name="snapshots", daemon=True)
        self._thread.start()

    def put(self, snapshots: Mapping[str, Snapshot]) -> None:
        """Write *snapshots* soon, in place of any that wait. Raises the `EnvironmentFault` of earlier ones."""
        with self._changed:
            if self._fault is not None:
                raise self._fault
            self._next = snapshots
            self._changed.notify()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._over)
                snapshots, self._next = self._next, None
            if snapshots is None:
                return
            try:
                write_snapshots(self._path, snapshots)
            except EnvironmentFault as fault:
                with self._changed:
                    self._fault = fault
                return

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for the last. Raises `EnvironmentFault` if it could not be written and the block raised nothing."""
        with self._changed:
            self._over = True
            self._changed.notify()
        self._thread.join()
        if self._fault is not None and error is None:
            raise self._fault
