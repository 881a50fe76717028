"""Throughput of executors on this machine, and what that says of larger ones: ``python tools/executor_throughput.py``.

The same candidates of a design are judged serially on one thread, by two processes and, where dask is installed, by two
of its workers; results must be equal to the bit. Then items that take no time show the overhead of a chunk.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from operator import getitem

from cablewright.models.job_poses import sampled
from cablewright.printing.job import Job
from cablewright.robot import load
from cablewright.running.executors import study
from cablewright.running.executors.choice import chosen
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.stored_results import KeptResults
from cablewright.running.executors.study import evaluate
from cablewright.running.executors.task import Task
from cablewright.solvers.row_threads import use_threads
from cablewright.studies.design.problem import DesignProblem, Variable, places_of
from cablewright.studies.design.search import judged

CANDIDATES = 300
CHUNKS = 200  # of one item each that takes no time
WORKERS = 2
JOB = {"name": "column", "helix": {"radius": 3.0, "layers": 40, "layer_height": 0.05, "first_height": 0.05}}


def problem() -> DesignProblem:
    """A house printer for a column."""
    robot, job = load("house-printer"), Job.model_validate(JOB)
    samples, _ = sampled(robot, job, job.toolpath())
    return DesignProblem(robot, (Variable.read("exit_point.z=6:15"),), ("expected_error", "lowest_frequency"),
                  job=job, places=places_of(samples))  # fmt: skip


def measured(executor: Executor, task: Task, count: int) -> tuple[float, list[str]]:
    """Return the time, s by the wall clock, and the results."""
    items = [(8.0 + 6.0 * k / count,) for k in range(count)] if task.noun == "candidate" else list(range(count))
    with use_threads(1):
        evaluate(task, items[: 2 * executor.workers], executor, KeptResults())  # workers are there, kernels loaded
        begin = time.perf_counter()
        found = evaluate(task, items, executor, KeptResults())
    return time.perf_counter() - begin, [each.text for each in found]


@contextmanager
def executor_of(workers: int | None, dask: bool) -> Iterator[Executor]:
    """Hold an executor, with *dask* on a scheduler of this machine, which is open to all its users meanwhile."""
    if not dask:
        with chosen(workers) as executor:
            yield executor
        return
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
        chosen(None, cluster.scheduler_address) as executor,
    ):
        yield executor


def main() -> None:
    """Print the table."""
    task, empty = Task(judged, problem(), "candidate"), Task(getitem, tuple(range(CHUNKS)), "item")
    alone, expected = measured(Serial(), task, CANDIDATES)
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"{'executor':<22}{'candidates/s':>14}{'times serial':>14}{'equal to the bit':>18}{'a chunk, ms':>13}")
    for name, workers, dask in (("serial, one thread", None, False), ("2 processes", WORKERS, False),
                                ("dask, 2 workers", WORKERS, True)):  # fmt: skip
        if dask and find_spec("distributed") is None:
            continue
        with executor_of(workers, dask) as executor:
            seconds, found = (alone, expected) if workers is None else measured(executor, task, CANDIDATES)
            before, study.MAX_ITEMS = study.MAX_ITEMS, 1
            each = 1e3 * measured(executor, empty, CHUNKS)[0] / CHUNKS
            study.MAX_ITEMS = before
        print(f"{name:<22}{CANDIDATES / seconds:>14.1f}{alone / seconds:>14.2f}{found == expected!s:>18}{each:>13.2f}")


if __name__ == "__main__":
    main()
