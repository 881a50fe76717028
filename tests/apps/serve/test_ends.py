"""Failures are events with the next step: full disks, removed folders, torn lines, uploads that are too large."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("starlette")

from cablewright.live.serve.events import Events
from cablewright.live.serve.jobs import JobCheck, subject_of, write_check
from cablewright.robot import load
from served import RING, Client, Served, client, served

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")
JOB = RING.replace('name = "ring"', 'name = "ring"\norigin = [0.0, 0.0, 5.9]').replace('"0.25 m/s"', '"0.1 m/s"')


def test_a_torn_last_line_of_orders_is_ended_before_the_next(tmp_path: Path) -> None:
    path = tmp_path / "orders.jsonl"
    path.write_bytes(b'{"order": "reset"}\n{"order": "ena')
    events = Events.at(path)
    events.keep({"order": "start"})
    events.close()
    lines = path.read_bytes().split(b"\n")
    assert lines[:2] == [b'{"order": "reset"}', b'{"order": "ena']
    assert json.loads(lines[2])["order"] == "start"


def test_a_full_disk_costs_a_line_and_says_so(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    events = Events.at(Path("/dev/full"))
    events.keep({"order": "start"})
    events.close()
    kind, text = events.told[-1][2:]
    assert kind == "fault"
    assert "No space left" in text
    assert "make room" in text


def test_a_removed_file_of_orders_is_made_again_and_a_removed_folder_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    path = folder / "orders.jsonl"
    events = Events.at(path)
    path.unlink()
    events.keep({"order": "start"})
    assert json.loads(path.read_bytes())["order"] == "start"
    shutil.rmtree(folder)
    events.keep({"order": "stop"})
    events.close()
    assert "put the folder back" in events.told[-1][3]


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Served, Path]]:
    """A server whose folder is on a disk of 8 MB of its own."""
    disk = tmp_path_factory.mktemp("disk")
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(disk)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("no disk can be mounted here")
    try:
        with served(disk / "out", "house-printer", "--seed", "1") as made:
            yield made, disk
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def fill(disk: Path) -> Path:
    """Fill a disk up; return the file that does."""
    path = disk / "filled"
    with suppress(OSError), open(path, "wb", buffering=0) as file:
        while True:
            file.write(b"0" * 4096)
    return path


def printing(server: Served, page: Client) -> None:
    """Load a job whose check said yes, and print it."""
    own = {"authorization": f"Bearer {server.token}", "x-page": page.page}
    number = json.loads(server.ask("POST", "/jobs", '{"name": "ring"}', **own)[1])["id"]
    assert server.ask("PUT", f"/jobs/{number}/settings", JOB, **own)[0] == 200
    folder = server.folder / "jobs" / number
    write_check(folder, JobCheck(subject=subject_of(folder, load("house-printer")), answer="yes", why=""))
    status, text, _ = server.ask("POST", f"/jobs/{number}/load", "{}", **own)
    assert status == 200, text
    sitting = page.state.get("sitting", 0)
    page.until(lambda state: state.get("sitting", 0) > sitting and state.get("state") == "fault")
    page.ready()
    page.until(lambda state: not np.any(state["speeds"]))
    assert page.order("start") == ""
    page.until(lambda state: state["state"] == "printing")


@pytest.mark.slow  # as a large file in test_serve.py
@pytest.mark.clock
@LINUX
def test_why_a_large_upload_is_rejected_is_read_by_whoever_sends_it(small: tuple[Served, Path]) -> None:
    server, _ = small
    with client(server) as page:
        end = time.monotonic() + 20.0
        while page.take():
            assert time.monotonic() < end
            page.during(0.2)
        own = {"authorization": f"Bearer {server.token}", "x-page": page.page}
        number = json.loads(server.ask("POST", "/jobs", '{"name": "huge"}', **own)[1])["id"]
        status, text, _ = server.ask("PUT", f"/jobs/{number}/gcode", b"G1 X1\n" * (12 << 20), **own)
        assert (status, text.strip()) == (413, "gcode of 'huge': too large; at most 65536 KiB")


@pytest.mark.slow  # a full disk stops a print in apps/cli/test_print_kills.py; that serve goes on is here alone
@pytest.mark.clock
@LINUX
def test_a_disk_that_gets_full_stops_a_print_in_order_and_serve_goes_on(small: tuple[Served, Path]) -> None:
    server, disk = small
    with client(server) as page:
        page.ready()
        printing(server, page)
        filled = fill(disk)
        page.until(lambda state: state["state"] in ("fault", "closed"))
        told = [text for *_, text in page.state["events"]]
        page.until(lambda state: state["state"] == "closed")
        stopped = [state for state in page.states if state.get("state") == "fault"]
        assert not np.any(stopped[-1]["speeds"])
        assert set(stopped[-1]["modes"]) <= {"hold", "off"}  # and brakes as it is closed
        told += [text for *_, text in page.state["events"]]
        assert any("No space left" in text for text in told)
        assert server.process.poll() is None
        filled.unlink()
        assert page.take() == ""
        own = {"authorization": f"Bearer {server.token}", "x-page": page.page}
        assert server.ask("POST", "/close", "{}", **own)[0] == 200  # opens the machine again
        page.until(lambda state: state["state"] == "fault")
        assert page.state["reason"] == "not reset since it was started"
        page.ready()
