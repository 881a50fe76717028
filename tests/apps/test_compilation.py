"""Kernels compiled ahead: each task once, whatever becomes of other processes, and words for who waits."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cablewright.apps import compilation
from cablewright.kernels import cache
from cablewright.solvers import row_threads

ECHO = "import sys\nfor line in sys.stdin: print(line.strip(), flush=True)"
"""A process that reports each task as done."""
ENDS = "import sys; sys.stdin.readline()"
COSTS = {"a": 4.0, "b": 3.0, "c": 2.0, "d": 1.0}  # s
LIES = "import sys\nfor line in sys.stdin: print('something else', flush=True)"


@pytest.fixture
def done(monkeypatch) -> list[str]:
    """Names of four tasks as this process does them."""
    names: list[str] = []
    tasks = {name: (lambda name=name: names.append(name), seconds) for name, seconds in COSTS.items()}
    monkeypatch.setattr(compilation, "TASKS", tasks)
    return names


def helped_by(monkeypatch, code: str, processes: int = 3) -> None:
    monkeypatch.setattr(compilation, "thread_count", lambda: processes)
    monkeypatch.setattr(
        compilation,
        "_begun",
        lambda: subprocess.Popen(
            [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ),
    )


@pytest.mark.parametrize("code", [ENDS, LIES, "import os; os._exit(1)"])
def test_what_others_leave_undone_is_done_here(done: list[str], monkeypatch, code: str) -> None:
    helped_by(monkeypatch, code)
    compilation.prepare(tuple("abcd"), lambda *_: None)
    assert sorted(done) == list("abcd")


def test_others_do_the_last_tasks_and_each_is_reported(done: list[str], monkeypatch, tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    wait = f"import pathlib, time\nwhile not pathlib.Path({str(begun)!r}).exists(): time.sleep(0.01)\n"
    helped_by(monkeypatch, wait + ECHO, 2)
    said: list[tuple[int, int, float]] = []

    def first_waits() -> None:
        begun.touch()
        while len(said) < 4:  # until the other process has done the rest
            time.sleep(0.01)
        done.append("a")

    monkeypatch.setitem(compilation.TASKS, "a", (first_waits, 4.0))
    compilation.prepare(tuple("abcd"), lambda *words: said.append(words))
    assert done == ["a"]
    assert [(one, count) for one, count, _ in said] == [(k, 4) for k in range(5)]
    assert said[0][2] == 10.0 / 2
    assert said[-1][2] == 0.0


def test_alone_where_nothing_can_be_kept(done: list[str], monkeypatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(cache.DIRECTORY, str(tmp_path / "file"))
    helped_by(monkeypatch, ECHO)
    compilation.prepare(tuple("abcd"), lambda *_: None)
    assert done == list("abcd")


def test_an_error_ends_the_others(done: list[str], monkeypatch) -> None:
    helped_by(monkeypatch, "import time; time.sleep(600)")
    monkeypatch.setitem(compilation.TASKS, "a", (lambda: 1 / 0, 4.0))
    with pytest.raises(ZeroDivisionError):
        compilation.prepare(tuple("abcd"), lambda *_: None)


def test_nothing_is_prepared_where_all_is_compiled(monkeypatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(row_threads, "_ready", set())
    monkeypatch.setattr(row_threads, "is_compiled", lambda *_: True)
    with row_threads.before_compiling(lambda: asked.append(1)):
        compilation.TASKS["inverse"][0]()
    assert not asked


def test_it_is_prepared_once(monkeypatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(row_threads, "_ready", set())
    monkeypatch.setattr(row_threads, "is_compiled", lambda *_: False)
    with row_threads.before_compiling(lambda: asked.append(1)), row_threads.saying_more():
        compilation.TASKS["inverse"][0]()
        compilation.TASKS["forward"][0]()
    assert asked == [1]


def test_a_process_ends_with_whoever_asked_it_even_while_it_compiles(tmp_path: Path) -> None:
    environment = os.environ | {cache.DIRECTORY: str(tmp_path)}
    begin = (
        "import signal; from cablewright.apps.compilation import TASKS, main; TASKS['x'] = (signal.pause, 1.0); main()"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    worker = subprocess.Popen([sys.executable, "-c", begin], env=environment, text=True, **pipes)
    assert worker.communicate("x\n", timeout=100) == ("", None)
    assert worker.returncode == 0


@pytest.mark.slow
def test_after_warm_nothing_is_left_to_compile(tmp_path: Path) -> None:
    def ran(*arguments: str) -> str:
        environment = os.environ | {cache.DIRECTORY: str(tmp_path / "kernels")}
        command = [sys.executable, "-m", "cablewright", *arguments]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stderr

    assert "compiling kernels (once): 1 of 8" in ran("warm")
    kept = set(tmp_path.rglob("*"))
    helix = str(Path(__file__).parents[2] / "examples" / "helix.toml")
    for command in (
        ("inverse", "cogiro", "--at", "0,0,1"),
        ("forward", "merlet2023", "--lengths", "10.43,10.43,10.43,10.43", "--certify"),
        ("interference", "house-printer", "--at", "0,0,1"),
        ("check", "house-printer", helix, "--out", str(tmp_path / "check")),
    ):
        assert "compiling" not in ran(*command)
    new = {each for each in set(tmp_path.rglob("*")) - kept if each.is_relative_to(tmp_path / "kernels")}
    assert not new
