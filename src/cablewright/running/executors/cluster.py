"""Workers of a dask cluster, by the address of its scheduler.

The scheduler and the workers run what any client sends: they belong in a trusted network, or behind TLS.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any, Final

from cablewright.foundation.errors import EnvironmentFault
from cablewright.running.executors.task import Chunk, Computed, programs, run_chunk, unlike

CONNECT: Final = 10.0  # s, until a scheduler must have answered, and a worker be there
AHEAD: Final = 2
"""Chunks that are sent for each thread of the workers, so that none waits for the network."""

_ABSENT: Final = "--cluster: needs dask.distributed; pip install 'cablewright[cluster]'"


class Cluster:
    """Computes on the workers of a dask scheduler at an *address*."""

    def __init__(self, address: str) -> None:
        """Connect, and compare the programs of all workers. Raises `EnvironmentFault`."""
        try:
            import distributed
        except ImportError:
            raise EnvironmentFault(_ABSENT) from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # its warnings are reported here, in one line
        self._dask, self._address = distributed, address
        try:
            self._client = distributed.Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as reason:
            raise EnvironmentFault(f"--cluster = {address}: no scheduler answers ({reason})") from None
        try:
            self._hosts = self._compared()
        except EnvironmentFault:
            self.close()
            raise

    def _compared(self) -> list[str]:
        """Compare the programs of the workers with those here; return one worker's address of each host."""
        try:
            self._client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError:
            raise EnvironmentFault(f"--cluster = {self._address}: its scheduler has no workers") from None
        for worker, there in self._client.run(programs, on_error="return").items():
            if isinstance(there, Exception):
                raise EnvironmentFault(f"--cluster: {_refusal(worker, there)}")
            if difference := unlike(programs(), there):
                raise EnvironmentFault(f"--cluster: worker {worker} {difference}")
        known: dict[str, Any] = self._client.scheduler_info(n_workers=-1)["workers"]
        return list({each["host"]: name for name, each in known.items()}.values())

    @property
    def workers(self) -> int:
        """Present number of worker threads on all computers of the cluster."""
        return max(1, int(sum(self._client.nthreads().values())))

    def run(self, chunks: Iterable[Chunk]) -> Iterator[Computed]:
        """Yield each chunk as it is done; of each host one worker first, which compiles kernels for all there.

        Raises `EnvironmentFault` where the scheduler is lost, or a worker has other programs.
        """
        source = iter(chunks)
        first = {
            self._submitted(chunk, workers=[host], allow_other_workers=True): chunk
            for host, chunk in zip(self._hosts, source, strict=False)
        }
        yield from self._done(first, iter(()))
        sent = {self._submitted(chunk): chunk for chunk in islice(source, AHEAD * self.workers)}
        yield from self._done(sent, source)

    def _done(self, sent: dict[Any, Chunk], source: Iterator[Chunk]) -> Iterator[Computed]:
        """Yield what was *sent* as it is done; for each, one more of *source* is sent."""
        done = self._dask.as_completed(list(sent), loop=self._client.loop)
        for future in done:
            chunk = sent.pop(future)
            answer = self._answer(future, chunk)
            if answer is not None:
                yield answer
            for following in [*islice(source, 1), *(chunk.parts() if answer is None else ())]:
                sent[one := self._submitted(following)] = following
                done.add(one)

    def _submitted(self, chunk: Chunk, **where: Any) -> Any:
        return self._client.submit(run_chunk, chunk, pure=False, **where)

    def _answer(self, future: Any, chunk: Chunk) -> Computed | None:
        """Return what a worker answered; None for a chunk of several items of which one killed its workers."""
        if future.status == "finished":
            answer: Computed = future.result()
            return answer
        if future.status != "error":  # cancelled, lost
            raise EnvironmentFault(f"--cluster = {self._address}: its scheduler is gone; the same command resumes")
        reason = future.exception()
        if isinstance(reason, self._dask.KilledWorker):
            if len(chunk.items) > 1:
                return None
            return chunk.failed("its worker ended again and again without an answer (killed, or out of memory)")
        raise EnvironmentFault(f"--cluster: {_refusal('a worker', reason)}")

    def close(self) -> None:
        """Leave the cluster of computers."""
        self._client.close(timeout=1.0)


def _refusal(worker: str, reason: Exception) -> str:
    """Say why a worker cannot compute."""
    if isinstance(reason, EnvironmentFault):
        return str(reason)
    if "No module named 'cablewright" in str(reason):  # dask makes an exception of its own of it
        return f"worker {worker} has no cablewright, or another version of it; install there what is here"
    return f"{worker}: {type(reason).__name__}: {reason}"
