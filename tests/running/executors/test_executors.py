"""Executors: the same bytes here, in processes and on dask; deaths, faults, resumption, and who is rejected."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from cablewright.foundation.errors import AnswerError, EnvironmentFault, InputError
from cablewright.robot import load
from cablewright.robot.design_variables import Change
from cablewright.running.executors.choice import chosen
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.processes import Processes
from cablewright.running.executors.stored_results import HEAD, KeptResults, kept_in
from cablewright.running.executors.study import evaluate, require_all
from cablewright.running.executors.task import Chunk, Task, digest, programs, run_chunk, unlike
from cablewright.studies.trade import TradeSettings, trade
from executor_work import deadly, numbers

TASK = Task(numbers, {"factor": 1.1}, "number")
ITEMS = list(range(12))
EXPECTED = evaluate(TASK, ITEMS, Serial(), KeptResults())


@pytest.fixture(scope="module")
def processes() -> Iterator[Processes]:
    executor = Processes(2)
    yield executor
    executor.close()


def test_items_have_the_results_of_the_function_and_faults_name_the_reason() -> None:
    for item, outcome in zip(ITEMS, EXPECTED, strict=True):
        if item == 7:
            assert outcome.fault == "seven has no answer"
        elif item == 8:
            assert outcome.fault == "ZeroDivisionError: float division by zero"
        else:
            assert outcome.value["third"] == item / 3.0
    with pytest.raises(AnswerError, match=r"item 7: seven has no answer \(2 of 12 failed; the other 10 are kept\)"):
        require_all(EXPECTED, [f"item {item}" for item in ITEMS])


def test_processes_give_the_same_bytes(processes: Processes) -> None:
    assert evaluate(TASK, ITEMS, processes, KeptResults()) == EXPECTED


def test_a_study_of_robots_is_the_same_to_the_bit_in_processes(processes: Processes) -> None:
    robot, asked = load("jung2020"), TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
    varied = {Change("exit-distance"): (0.05, 0.1, 0.2)}
    assert trade(robot, varied, asked, executor=processes).combinations == trade(robot, varied, asked).combinations


def test_a_worker_that_is_killed_is_replaced(processes: Processes, tmp_path: Path) -> None:
    outcomes = evaluate(Task(deadly, str(tmp_path / "once"), "item"), range(6), processes, KeptResults())
    assert [each.value for each in outcomes] == [0, 1, 2, -3, 4, 5]


def test_what_kills_its_worker_twice_is_named_and_loses_nothing(processes: Processes, tmp_path: Path) -> None:
    with kept_in(tmp_path / "kept.jsonl") as kept:
        outcomes = evaluate(Task(deadly, "", "item"), range(6), processes, kept)
    assert [bool(each.fault) for each in outcomes] == [False, False, False, True, False, False]
    assert "ended twice" in outcomes[3].fault


@pytest.mark.slow  # as one that kills itself, above
def test_a_worker_killed_from_outside_changes_nothing(tmp_path: Path) -> None:
    executor, killed = Processes(2), list[int]()
    slow = Task(numbers, {"factor": 1.1, "pause": 0.05}, "number")

    def kill(_stage: str, done: int, _total: int) -> None:
        if done >= 3 and not killed:
            worker, _ = next(iter(executor._busy.values()))
            assert worker._process.pid is not None
            killed.append(worker._process.pid)
            os.kill(worker._process.pid, signal.SIGKILL)

    try:
        outcomes = evaluate(slow, ITEMS, executor, KeptResults(), kill)
    finally:
        executor.close()
    assert killed
    assert outcomes == EXPECTED


class _EndedError(Exception):
    """Represents an interruption."""


@pytest.mark.parametrize("resumes", ["serial", "processes"])
def test_what_was_ended_goes_on_with_any_executor(processes: Processes, tmp_path: Path, resumes: str) -> None:
    def ending(_stage: str, done: int, _total: int) -> None:
        if done >= 4:
            raise _EndedError

    file = tmp_path / "kept.jsonl"
    with pytest.raises(_EndedError), kept_in(file) as kept:
        evaluate(TASK, ITEMS, Serial(), kept, ending)
    lines = file.read_bytes().splitlines()
    assert len(lines) >= 5
    file.write_bytes(file.read_bytes()[:-9])  # a killed program leaves half a line
    told = list[int]()
    with kept_in(file) as kept:
        executor: Executor = Serial() if resumes == "serial" else processes
        outcomes = evaluate(TASK, ITEMS, executor, kept, lambda _stage, done, _total: told.append(done))
    assert told[0] == len(lines) - 2
    assert outcomes == EXPECTED
    with kept_in(file) as kept:
        assert evaluate(TASK, ITEMS, Serial(), kept) == EXPECTED


def test_keys_depend_on_all_that_results_depend_on() -> None:
    robot = load("house-printer")
    keys = {
        Task(numbers, {"factor": 1.1}, "").key(),
        Task(numbers, {"factor": 1.1000000000000003}, "").key(),
        Task(deadly, {"factor": 1.1}, "").key(),
        Task(numbers, robot, "").key(),
        Task(numbers, Change("mass").on(robot, 200.00000000000003), "").key(),
    }
    assert len(keys) == 5
    assert digest(robot) == digest(load("house-printer"))


@pytest.mark.parametrize(
    "content", [b"[]\n", b"{}\n", b"\xff\xfe\n", HEAD + b"[\n", HEAD + b'{"key": 1, "value": 2}\n']
)
def test_a_file_of_something_else_is_rejected(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "a.jsonl"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.jsonl: .*another --out"), kept_in(file):
        pass
    assert file.read_bytes() == content


def test_two_programs_do_not_write_one_file(tmp_path: Path) -> None:
    with (
        kept_in(tmp_path / "a.jsonl"),
        pytest.raises(EnvironmentFault, match="another program uses it"),
        kept_in(tmp_path / "a.jsonl"),
    ):
        pass


def test_a_worker_of_another_version_is_rejected_in_one_line() -> None:
    other = programs() | {"numpy": "1.0"}
    assert unlike(programs(), programs()) == ""
    assert unlike(other, programs()).startswith("has numpy ")
    chunk = Chunk(TASK, TASK.key(), other, (1,), (0,))
    with pytest.raises(EnvironmentFault, match=r"^a worker has numpy .*; here it is 1\.0$"):
        run_chunk(chunk)
    with pytest.raises(EnvironmentFault, match="reads the inputs"):
        run_chunk(replace(chunk, programs=programs(), key="0"))
    with pytest.raises(EnvironmentFault, match="other sources"):
        run_chunk(replace(chunk, programs=programs() | {"sources": "0"}))


@pytest.mark.parametrize(("workers", "cluster", "says"), [(0, None, "1 to 256"), (2, "tcp://a:1", "give one of them")])
def test_contradictions_are_rejected(workers: int, cluster: str | None, says: str) -> None:
    with pytest.raises(InputError, match=says), chosen(workers, cluster):
        pass


def test_chunks_take_about_a_second() -> None:
    sizes = list[int]()

    class Told(Serial):
        def run(self, chunks):  # type: ignore[no-untyped-def]
            for chunk in chunks:
                sizes.append(len(chunk.items))
                yield replace(run_chunk(chunk), seconds=0.05 * len(chunk.items))

    evaluate(TASK, list(range(20, 120)), Told(), KeptResults())
    assert sizes[0] == 1
    assert set(sizes[1:-1]) == {20}
    assert sum(sizes) == 100


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The scheduler of two workers, each a process."""
    distributed = pytest.importorskip("distributed", reason="needs the extra cluster")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


def test_dask_gives_the_same_bytes(address: str) -> None:
    with chosen(None, address) as executor:
        assert executor.workers == 2
        assert evaluate(TASK, ITEMS, executor, KeptResults()) == EXPECTED


def test_a_study_of_robots_is_the_same_to_the_bit_on_dask(address: str) -> None:
    robot, asked = load("jung2020"), TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
    varied = {Change("exit-distance"): (0.05, 0.1, 0.2)}
    with chosen(None, address) as executor:
        found = trade(robot, varied, asked, executor=executor)
    assert found.combinations == trade(robot, varied, asked).combinations


@pytest.mark.slow  # as a worker here, and a scheduler of dask
def test_a_worker_of_dask_that_dies_is_replaced(address: str, tmp_path: Path) -> None:
    with chosen(None, address) as executor:
        outcomes = evaluate(Task(deadly, str(tmp_path / "once"), "item"), range(6), executor, KeptResults())
    assert [each.value for each in outcomes] == [0, 1, 2, -3, 4, 5]


def test_workers_of_another_version_are_rejected(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from cablewright.running.executors import cluster

    monkeypatch.setattr(cluster, "unlike", lambda here, there: unlike(here | {"scipy": "0.1"}, there))
    says = "--cluster: .* has scipy .*; here it is 0.1"
    with pytest.raises(EnvironmentFault, match=says), chosen(None, address):
        pass


def test_no_scheduler_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    from cablewright.running.executors import cluster

    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    with pytest.raises(EnvironmentFault, match="no scheduler answers"), chosen(None, "tcp://127.0.0.1:9"):
        pass


def test_a_scheduler_that_dies_is_said_and_the_study_resumes_elsewhere(tmp_path: Path, processes: Processes) -> None:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    script = (
        "import distributed, sys, time\n"
        "if __name__ == '__main__':\n"
        "    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, "
        "death_timeout=5)\n"
        "    print(cluster.scheduler_address, flush=True)\n"
        "    time.sleep(120)\n"
    )
    (tmp_path / "scheduler.py").write_text(script)
    there = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    scheduler = subprocess.Popen(
        [sys.executable, str(tmp_path / "scheduler.py")], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=there,
        text=True,
    )  # fmt: skip
    assert scheduler.stdout is not None
    address, file = scheduler.stdout.readline().strip(), tmp_path / "kept.jsonl"
    slow = Task(numbers, {"factor": 1.1, "pause": 0.2}, "number")
    says = "its scheduler is gone; the same command resumes"
    with (
        scheduler,
        kept_in(file) as kept,
        chosen(None, address) as executor,
        pytest.raises(EnvironmentFault, match=says),
    ):
        evaluate(slow, range(20, 60), executor, kept, lambda _, done, __: scheduler.kill() if done > 2 else None)
    known = file.read_text().splitlines()[1:]
    assert 0 < len(known) < 40
    assert all(json.loads(line).keys() == {"key", "value"} for line in known)
    with kept_in(file) as kept:
        outcomes = evaluate(slow, range(20, 60), processes, kept)
    assert [each.value["third"] for each in outcomes] == [item / 3.0 for item in range(20, 60)]
