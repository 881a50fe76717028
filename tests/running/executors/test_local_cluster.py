"""A local cluster takes nothing from a network: while it computes, none of its processes listens anywhere."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from cablewright.foundation.errors import InputError
from cablewright.running.executors.choice import chosen
from cablewright.running.executors.stored_results import KeptResults
from cablewright.running.executors.study import evaluate
from cablewright.running.executors.task import Task
from executor_work import numbers

TASK = Task(numbers, {"factor": 1.1, "pause": 0.02}, "number")
LISTENS = "0A"


def family(process: int) -> list[int]:
    """The process and all that it started, and these started."""
    children = [
        int(each)
        for thread in Path(f"/proc/{process}/task").iterdir()
        for each in (thread / "children").read_text().split()
    ]
    return [process, *(one for child in children for one in family(child))]


def listening() -> set[str]:
    """Local addresses at which this process or one below it listens for TCP."""
    sockets = set[str]()
    for process in family(os.getpid()):
        for number in Path(f"/proc/{process}/fd").iterdir():
            try:
                sockets.add(str(number.readlink()))
            except OSError:  # closed meanwhile
                continue
    rows = [line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()[1:]]
    return {row[1] for row in rows if row[3] == LISTENS and f"socket:[{row[9]}]" in sockets}


@pytest.mark.skipif(sys.platform != "linux", reason="looks at sockets in /proc")
def test_local_cluster_opens_no_port() -> None:
    before, heard, sizes = listening(), set[str](), list[int]()

    def look(_stage: str, _done: int, _total: int) -> None:
        heard.update(listening() - before)
        sizes.append(len(family(os.getpid())))

    with chosen(2, "local") as executor:
        assert executor.workers == 2
        outcomes = evaluate(TASK, list(range(20, 32)), executor, KeptResults(), look)
    assert [each.value["third"] for each in outcomes] == [item / 3.0 for item in range(20, 32)]
    assert max(sizes) >= 3  # two workers were there
    assert heard == set()


def test_local_cluster_has_a_worker_for_each_core_by_default() -> None:
    with chosen(None, "local") as executor:
        assert executor.workers == os.cpu_count()
    with pytest.raises(InputError, match="--workers = 0: must be from 1"), chosen(0, "local"):
        pass
