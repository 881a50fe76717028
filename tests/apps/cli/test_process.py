"""The command as a process: exit codes, a pure stdout, interruptions, tracebacks only on request."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

COMMAND = [sys.executable, "-c", "from cablewright.apps.cli.main import main; main()"]


def start(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=300, check=False)


def test_a_yes() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert ended.returncode == 0
    assert json.loads(ended.stdout)["status"] == "ok"


def test_a_no() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0,4.5", "--json")
    assert ended.returncode == 1
    assert json.loads(ended.stdout)["status"] == "infeasible"
    assert "no tensions within the limits" in ended.stderr.splitlines()[-1]


def test_bad_input() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0")
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "Traceback" not in ended.stderr


def test_help_is_there_at_once() -> None:
    walls = []
    for _ in range(3):
        begin = time.perf_counter()
        ended = start("--help")
        walls.append(time.perf_counter() - begin)
        assert ended.returncode == 0
        assert "check" in ended.stdout
    assert min(walls) <= 1.5


def test_a_reader_that_has_seen_enough_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    try:
        ended = subprocess.run([*COMMAND, "robots", "paty2021"], stdout=writer, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writer)
    assert ended.returncode == 0
    assert ended.stderr == b""


def test_a_full_disk_under_stdout() -> None:
    if not os.path.exists("/dev/full"):  # noqa: PTH110
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:
        ended = subprocess.run([*COMMAND, "schema"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 3
    assert ended.stderr.count("\n") == 1


def raising(error: BaseException) -> Callable[..., None]:
    def call(*_arguments: object, **_options: object) -> None:
        raise error

    return call


def test_an_interruption(cli, monkeypatch) -> None:
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", raising(KeyboardInterrupt()))
    answer = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert (answer.code, answer.out) == (130, "")
    assert "Traceback" not in answer.err


@pytest.mark.parametrize("place", [0, -1])
def test_debug_shows_where_an_error_came_from(cli, place: int) -> None:
    arguments = ["inverse", "nobody", "--at", "0,0,1"]
    arguments.insert(place % (len(arguments) + 1), "--debug")
    answer = cli(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Traceback")
    assert answer.err.splitlines()[-1].startswith("cablewright: no robot 'nobody'")


def test_debug_adds_nothing_to_a_yes(cli) -> None:
    plain = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert cli("--debug", "inverse", "merlet2023", "--at", "0,0,1", "--json") == plain


def test_version_and_help(cli) -> None:
    assert cli("--version").out.startswith("cablewright ")
    for command in ("check", "forward", "inverse", "robots", "schema"):
        assert command in cli("--help").out
        assert cli(command, "--help").code == 0
