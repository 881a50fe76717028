"""Executor of worker processes on this machine: one thread each, replaced when they die."""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Iterable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Final

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.running.executors.task import Chunk, Computed, run_chunk

ATTEMPTS: Final = 2
"""How often a single item is begun before it has failed, if its worker dies each time."""

MAX_WORKERS: Final = 256
_ENDED: Final = "its worker ended twice without an answer (killed, or out of memory)"
_SPAWN: Final = get_context("spawn")  # a forked child would have locks of threads that it does not have


class Processes:
    """Executor of worker processes on this machine."""

    def __init__(self, workers: int) -> None:
        if not 1 <= workers <= MAX_WORKERS:
            raise InputError(f"--workers = {workers}: must be from 1 to {MAX_WORKERS}")
        self.workers = workers
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, Chunk]] = {}

    def run(self, chunks: Iterable[Chunk]) -> Iterator[Computed]:
        """Yield each chunk as it is done. Raises `EnvironmentFault` of workers that cannot compute."""
        source, again, deaths = iter(chunks), deque[Chunk](), dict[tuple[int, ...], int]()
        while True:
            while len(self._busy) < self.workers:
                chunk = again.popleft() if again else next(source, None)
                if chunk is None:
                    break
                self._give(chunk)
            if not self._busy:
                return
            for pipe in wait(list(self._busy)):
                assert isinstance(pipe, Connection)
                worker, chunk = self._busy.pop(pipe)
                answer = worker.answer()
                if isinstance(answer, EnvironmentFault):
                    raise answer
                if answer is not None:
                    self._idle.append(worker)
                    yield answer
                    continue
                if len(chunk.items) > 1:
                    again += chunk.parts()
                    continue
                deaths[chunk.numbers] = deaths.get(chunk.numbers, 0) + 1
                if deaths[chunk.numbers] < ATTEMPTS:
                    again.append(chunk)
                else:
                    yield chunk.failed(_ENDED)

    def _give(self, chunk: Chunk) -> None:
        """Let a worker begin the chunk."""
        worker = self._idle.pop() if self._idle else _Worker()
        if not worker.begin(chunk):  # it died while it was idle
            worker = _Worker()
            worker.begin(chunk)
        self._busy[worker.pipe] = worker, chunk

    def close(self) -> None:
        """End all workers, also in the middle of a chunk."""
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            worker.end()
        self._idle.clear()
        self._busy.clear()


class _Worker:
    """A process, and the pipe to it."""

    def __init__(self) -> None:
        self.pipe, other = _SPAWN.Pipe()
        self._process: SpawnProcess = _SPAWN.Process(target=_work, args=(other,), daemon=True)
        self._process.start()
        other.close()  # or its end would not be seen here

    def begin(self, chunk: Chunk) -> bool:
        """Send a chunk to the worker; return whether it is alive."""
        try:
            self.pipe.send(chunk)
        except OSError:
            self.end()
            return False
        return True

    def answer(self) -> Computed | EnvironmentFault | None:
        """Return the worker's answer; None if it died."""
        try:
            answer: Computed | EnvironmentFault = self.pipe.recv()
        except (EOFError, OSError):
            self.end()
            return None
        return answer

    def end(self) -> None:
        """End the worker process."""
        self.pipe.close()
        self._process.kill()
        self._process.join()


def _work(pipe: Connection) -> None:
    """Answer chunks until the pipe is closed at its other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the client is asked, and ends its workers
    while True:
        try:
            chunk: Chunk = pipe.recv()
        except EOFError:
            return
        answer: Computed | EnvironmentFault
        try:
            answer = run_chunk(chunk)
        except EnvironmentFault as fault:
            answer = fault
        try:
            pipe.send(answer)
        except OSError:  # the client was killed
            return
