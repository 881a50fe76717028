"""Choice of the executor by two options: how many processes, or a cluster's address."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from cablewright.foundation.errors import InputError
from cablewright.running.executors.executor import Executor, Serial

LOCAL: Final = "local"
"""The cluster that is this machine: processes on pipes, without a scheduler and without a port."""


@contextmanager
def chosen(workers: int | None = None, cluster: str | None = None) -> Iterator[Executor]:
    """Context with the executor: *workers* of this machine, those of a *cluster*, or by default this program alone.

    *cluster*: the address of a dask scheduler, or ``local`` for so many *workers* of this machine (by default one for
    each core). Raises `InputError` for a contradiction, `EnvironmentFault` where no worker is available.
    """
    if cluster == LOCAL:
        cluster, workers = None, (os.cpu_count() or 1) if workers is None else workers
    if cluster is not None and workers is not None:
        raise InputError(
            "--workers and --cluster: the cluster decides the number of its workers; give one of them, not both"
        )
    executor: Executor
    if cluster is not None:
        from cablewright.running.executors.cluster import Cluster

        executor = Cluster(cluster)
    elif workers is not None and workers != 1:
        from cablewright.running.executors.processes import Processes

        executor = Processes(workers)
    else:
        executor = Serial()
    try:
        yield executor
    finally:
        executor.close()
