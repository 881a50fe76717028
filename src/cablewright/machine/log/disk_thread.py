"""Thread that writes a log, so that a control loop does not wait for the disk."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

MAX_WAITING: Final = 256
"""Writes that may wait for the disk; of chunks of 256 KiB, 64 MiB."""


class DiskThread:
    """Thread that makes the given calls in order.

    Once a call has failed, the later ones are left out, and fail too.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="log")
        self._waiting = deque[Future[None]]()
        self._failed = False

    @property
    def full(self) -> bool:
        """Whether `MAX_WAITING` calls wait. Raises the exception of a call that failed."""
        while self._waiting and self._waiting[0].done():
            self._waiting.popleft().result()
        return len(self._waiting) >= MAX_WAITING

    def put(self, write: Callable[[], None]) -> None:
        """Queue the call *write* for the thread that writes to the disk."""
        self._waiting.append(self._thread.submit(self._call, write))

    def last(self) -> Future[None] | None:
        """Return the last call that waits for the disk, or None."""
        return self._waiting[-1] if self._waiting else None

    def wait(self) -> None:
        """Wait until all calls are made. Raises the error of a call."""
        while self._waiting:
            self._waiting[0].result()  # it still waits where this is interrupted
            self._waiting.popleft()

    def close(self) -> None:
        """Wait for all calls, whatever they raise, and end the thread."""
        self._thread.shutdown()

    def _call(self, write: Callable[[], None]) -> None:
        if self._failed:
            raise OSError("a call before has failed")
        self._failed = True
        write()
        self._failed = False
