"""Interface of executors, which compute chunks of work; and the serial one, which computes in this program."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from cablewright.running.executors.task import Chunk, Computed, run_chunk


class Executor(Protocol):
    """Interface of an executor: each free worker takes the next chunk."""

    @property
    def workers(self) -> int:
        """Number of chunks that are computed at the same time."""
        ...

    def run(self, chunks: Iterable[Chunk]) -> Iterator[Computed]:
        """Yield each chunk as it is done, in any order. A chunk whose worker dies again and again has failed.

        Raises `EnvironmentFault` where no worker is available.
        """
        ...

    def close(self) -> None:
        """End the workers that this executor has started."""
        ...


class Serial:
    """Executor that computes in this program, with all threads."""

    workers = 1

    def run(self, chunks: Iterable[Chunk]) -> Iterator[Computed]:
        """Yield each chunk of a task as it is done, in this process."""
        for chunk in chunks:
            yield run_chunk(chunk, threads=None)

    def close(self) -> None:
        """Nothing to close: no process was started."""
