"""Benchmarks run, at sizes too small for results; rows are kept with the commit that they were measured at."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks import run
from benchmarks.processes import alone
from benchmarks.timing import Row

PEERS = {"statics": "moorpy", "bodies": "moorpy", "workspace": "daqp", "interference": "fcl"}  # of the extra `bench`
MARKS = {  # tests of each subject hold the same
    **dict.fromkeys(
        ("bracket", "calibration", "commands", "estimation", "hanging", "machine", "print_job", "statics", "workspace"),
        (pytest.mark.slow,),
    ),
    "drives": (pytest.mark.slow, pytest.mark.clock),
}
WITH_AND_WITHOUT = [pytest.param(name, "", marks=MARKS.get(name, ())) for name in run.NAMES]
WITH_AND_WITHOUT += [pytest.param(*one, marks=MARKS.get(one[0], ())) for one in PEERS.items() if find_spec(one[1])]


@pytest.mark.parametrize(("name", "hidden"), WITH_AND_WITHOUT)
def test_a_benchmark_runs_without_judging_or_writing(
    name: str, hidden: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if hidden:
        monkeypatch.setitem(sys.modules, hidden, None)
    before = run.RESULTS.stat()
    assert run.main(["--quick", name]) == 0
    (head, *rows), told = (text.splitlines() for text in capsys.readouterr())
    assert head.startswith("QUICK")
    assert rows
    assert not any(sign in row for row in rows for sign in ("<", ">", " yes ", " NO "))
    peer = PEERS.get(name)
    assert set(told) == ({f"{peer} is not installed: left out"} if peer and not find_spec(peer) else set())
    assert (run.RESULTS.stat().st_mtime_ns, run.RESULTS.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


@pytest.mark.parametrize(("name", "size", "quick"), [("machine", "DROPPED", 0.05), ("estimation", "TOLD", 13.5)])
def test_a_table_of_the_documentation_is_printed(
    name: str, size: str, quick: float, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = import_module(f"benchmarks.{name}")
    monkeypatch.setattr(module, size, quick)  # s
    module.main()
    head, *rows = capsys.readouterr().out.splitlines()
    assert "off" in head or "out" in head
    assert len(rows) >= 5
    assert not any("nan" in row for row in rows)


def test_an_unknown_name_or_option_is_one_line_with_the_choices(capsys: pytest.CaptureFixture[str]) -> None:
    assert run.main(["--quick", "statics", "static", "--fast"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert line.startswith("static, --fast: unknown; ")
    assert all(choice in line for choice in ("--quick", *run.NAMES))


def test_results_are_of_benchmarks_that_there_are() -> None:
    kept = json.loads(run.RESULTS.read_text())
    assert kept["schema"] == 2
    assert {row["file"] for row in kept["rows"]} <= set(run.NAMES)
    assert {tuple(row) for row in kept["rows"]} == {("file", *Row("", 0.0, "").fields(), "commit")}


@pytest.fixture
def two(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Benchmarks `one` and `two` of a row each, with results in a folder of their own; what they measure, by name."""
    measured = {"one": 1.0, "two": 2.0}

    def source(name: str) -> SimpleNamespace:
        def rows(size: object) -> Iterator[Row]:
            yield Row(name, np.float64(measured[name]), "s", "<= 5", np.bool_(measured[name] <= 5.0))

        return SimpleNamespace(rows=rows, FULL=None, QUICK=None)

    monkeypatch.setattr(run, "RESULTS", tmp_path / "results.json")
    monkeypatch.setattr(run, "NAMES", tuple(measured))
    for name in measured:
        monkeypatch.setitem(sys.modules, f"benchmarks.{name}", source(name))
    return measured


def kept() -> list[tuple[str, float, bool]]:
    return [(row["file"], row["value"], row["met"]) for row in json.loads(run.RESULTS.read_text())["rows"]]


def test_a_named_benchmark_keeps_the_rows_of_the_others(two: dict[str, float]) -> None:
    assert run.main([]) == 0
    assert kept() == [("one", 1.0, True), ("two", 2.0, True)]
    two |= {"one": 6.0, "two": 7.0}
    assert run.main(["one"]) == 0
    assert kept() == [("one", 6.0, False), ("two", 2.0, True)]


def test_rows_measured_before_one_fails_are_kept(two: dict[str, float]) -> None:
    assert run.main([]) == 0
    two["one"] = 3.0
    del two["two"]
    with pytest.raises(KeyError):
        run.main([])
    assert kept() == [("one", 3.0, True), ("two", 2.0, True)]
    assert [path.name for path in run.RESULTS.parent.iterdir()] == ["results.json"]


@pytest.mark.skipif(which("git") is None, reason="git is not installed")
def test_rows_know_their_commit(two: dict[str, float], monkeypatch: pytest.MonkeyPatch) -> None:
    def commits() -> list[object]:
        return [row["commit"] for row in json.loads(run.RESULTS.read_text())["rows"]]

    folder = run.RESULTS.parent
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(folder.parent))
    assert run.main([]) == 0
    assert commits() == [None, None]  # outside git
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    who = ["-c", "user.name=a", "-c", "user.email=a@b"]
    subprocess.run(["git", *who, "commit", "--quiet", "--allow-empty", "--message", "a"], cwd=folder, check=True)
    sha = run.git("rev-parse", "HEAD")
    assert run.main(["two"]) == 0
    assert commits() == [None, {"hash": sha, "clean": True}]  # results may differ
    (folder / "edited.py").touch()
    assert run.main(["one"]) == 0
    assert commits() == [{"hash": sha, "clean": False}, {"hash": sha, "clean": True}]


@pytest.mark.skipif(sys.platform != "linux", reason="the system's own count is in /proc")
def test_memory_is_that_of_the_command_and_not_of_who_starts_it() -> None:
    large = np.ones(40_000_000)  # 320 MB here
    for code, least in (("held = b''", 0.0), ("held = b'x' * 100_000_000", 1e8)):
        output, seconds, memory = alone(["-c", f"{code}; print(open('/proc/self/status').read())"])
        known = next(int(line.split()[1]) for line in output.splitlines() if line.startswith("VmHWM"))
        assert memory == pytest.approx(1024 * known, abs=2e6)
        assert least < memory < least + 0.5 * large.nbytes
        assert seconds > 0.0


def test_a_command_that_fails_is_reported() -> None:
    with pytest.raises(RuntimeError, match="ended with 3: no reason"):
        alone(["-c", "import sys; print('no reason', file=sys.stderr); sys.exit(3)"])
