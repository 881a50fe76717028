"""Control and server that hang or are killed: orders given meanwhile move nothing, and drives brake."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("starlette")

from cablewright.foundation.signals import PrintState
from served import Client, Served, client, served
from virtual_drives import Watched, watched_drives

pytestmark = [pytest.mark.clock, pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")]

HANG = float(os.environ.get("CABLEWRIGHT_TEST_HANG", "2"))  # s
AWAY = (0.5, 0.5, 0.5)  # m


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("hangs") / "out", "house-printer", "--seed", "1") as made:
        yield made


def far(page: Client) -> list[float]:
    """A place half a metre away from the platform, towards the middle."""
    at = np.array(page.state["platform"]["position"])
    return np.asarray(at + np.where(at > 1.0, -0.5, 0.5)).tolist()


def ask_for_everything(page: Client) -> None:
    """Give all orders that may move it, without waiting for answers."""
    page.ask("go to", position=far(page))
    for kind in ("reset", "enable", "park", "start", "resume", "home"):
        page.ask(kind)
    page.send(t="jog", seq=10**6, beat=page.beat, velocity=[0.1, 0.0, 0.0])


def hang(process: int, page: Client, seconds: float = HANG) -> None:
    """Stop a process for a while, in which people ask for everything."""
    os.kill(process, signal.SIGSTOP)
    try:
        ask_for_everything(page)
        page.during(0.5 * seconds)
        page.send(t="take", name="Ben")
        ask_for_everything(page)
        page.during(0.5 * seconds)
    finally:
        os.kill(process, signal.SIGCONT)


def stands(page: Client, place: list[float], seconds: float = 3.0) -> None:
    """Whether no winch turns from now on, and the platform is where it was."""
    begin = len(page.states)
    page.during(seconds)
    since = page.states[begin:]
    assert since
    assert not any(np.any(state["speeds"]) for state in since), [state["state"] for state in since]
    assert np.allclose(page.state["platform"]["position"], place, atol=2e-3)


def test_orders_to_a_hung_control_move_nothing(server: Served) -> None:
    with client(server) as page:
        page.ready()
        place = page.state["platform"]["position"]
        before = page.state["time"]
        hang(server.process.pid, page)
        resumed = time.monotonic()
        page.until(lambda state: state["state"] == "fault")
        assert "the control hung" in page.state["reason"]
        stands(page, place)
        assert page.state["time"] - before < time.monotonic() - resumed + 2.0  # no step was made up for


def test_orders_to_a_hung_server_move_nothing(server: Served) -> None:
    with client(server) as page:
        page.ready()
        place = page.state["platform"]["position"]
        hang(server.server(), page)
        stands(page, place)
        page.until(lambda state: state["state"] == "idle")
        page.ready()
        assert page.order("go to", position=far(page)) == ""
        page.until(lambda state: state["state"] == "manual")


def test_what_moves_by_hand_ends_with_the_page_that_ordered_it(server: Served) -> None:
    with client(server) as watching:
        with client(server) as page:
            page.ready()
            page.until(lambda state: not np.any(state["speeds"]))
            assert page.order("go to", position=far(page)) == ""
            page.until(lambda state: np.any(state["speeds"]))
            watching.until(lambda state: state["state"] == "manual")
        watching.until(lambda state: state["state"] == "idle" and not np.any(state["speeds"]), 5.0)
        assert watching.state["reason"] == "stopped by order"
        told = [text for *_, text in watching.state["events"]]
        assert any("the operator has left" in text for text in told)


def test_a_server_that_hangs_ends_what_moves_by_hand(server: Served) -> None:
    with client(server) as page:
        page.ready()
        page.until(lambda state: not np.any(state["speeds"]))
        place = np.array(far(page))
        assert page.order("go to", position=place.tolist()) == ""
        page.until(lambda state: np.any(state["speeds"]))
        process = server.server()
        os.kill(process, signal.SIGSTOP)
        time.sleep(HANG)
        os.kill(process, signal.SIGCONT)
        page.until(lambda state: state["state"] == "idle" and not np.any(state["speeds"]))
        assert np.linalg.norm(np.array(page.state["platform"]["position"]) - place) > 0.05


def insist(page: Client, kind: str, state: str, **arguments: object) -> None:
    """Give an order until it is obeyed, while the machine is in that state: a busy computer may be late with it."""
    page.until(lambda now: now["state"] != state or (page.take() == "" and page.order(kind, **arguments) == ""))


@pytest.fixture
def drives(tmp_path: Path) -> Iterator[Watched]:
    with watched_drives(tmp_path / "machine.toml") as found:
        yield found


def still(drives: Watched) -> bool:
    """Whether no winch turns for half a second."""
    angles = drives.rig.plant.rig.winches.angles.copy()
    time.sleep(0.5)
    return bool(np.abs(drives.rig.plant.rig.winches.angles - angles).max() < 1e-3)


@pytest.mark.slow  # as a host in drives/test_two_processes.py; one starts again in test_news.py
def test_a_control_that_is_killed_in_a_jog_leaves_all_braked_and_starts_again(drives: Watched, tmp_path: Path) -> None:
    given = ("merlet2023", "--machine", str(tmp_path / "machine.toml"))
    with served(tmp_path / "out", *given) as server, client(server) as page:
        known = False
        while not known:
            insist(page, "reset", "fault")
            insist(page, "enable", "off")
            insist(page, "home", "idle", place=[0.7, -0.5, 1.0])
            page.until(lambda state: state["state"] != "homing")
            known = page.state["state"] == "idle" and page.state["known"]
        page.hold((0.0, 0.1, 0.0), 0, lambda state: np.abs(state["platform"]["velocity"][1]) > 0.08)
        server.process.kill()
        began = time.monotonic()
        while not drives.braked:
            assert time.monotonic() - began < 1.5, [drive.state for drive in drives.rig.drives]
            time.sleep(0.005)
    time.sleep(0.2)  # the simulated winches lag behind their drives
    assert still(drives)
    with served(tmp_path / "out", *given) as server, client(server) as page:
        page.until(lambda state: state["state"] == "fault")
        assert page.state["reason"] == "not reset since it was started"
        insist(page, "reset", "fault")
        page.until(lambda state: state["state"] == "off")


RING = """
schema = 1
name = "ring"
origin = [0.3, -0.5, 0.0]
[helix]
radius = 0.4
layers = 1
layer_height = 0.001
first_height = 1.0
[motion]
print_speed = 0.1
travel_speed = 0.1
acceleration = 0.1
"""


class Typed:
    """A print whose orders are typed, and its output."""

    def __init__(self, command: list[str]) -> None:
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said: list[str] = []
        self._reading = threading.Thread(target=lambda: self.said.extend(self.process.stderr or ()), daemon=True)
        self._reading.start()

    def end(self, number: int) -> None:
        """End the print by a signal."""
        self.process.send_signal(number)
        self.process.wait(timeout=60.0)
        self._reading.join(timeout=10.0)
        for stream in (self.process.stdin, self.process.stderr):
            assert stream is not None
            stream.close()

    def until(self, then: str) -> None:
        """Type what leads on from the state that was said last, until it is *then*, also after a fault."""
        end = time.monotonic() + 120.0
        homed = False
        while (state := self._state()) != then:
            assert self.process.poll() is None, self.said
            assert time.monotonic() < end, self.said
            homed = (homed or state == "homing") and state not in ("fault", "off")
            word = {"fault": "reset", "off": "enable", "idle": "start" if homed else "home"}.get(state)
            if word is not None:
                assert self.process.stdin is not None
                self.process.stdin.write(f"{word}\n")
                self.process.stdin.flush()
            time.sleep(0.3)

    def _state(self) -> str:
        said = [re.match("[a-z]+", line) for line in self.said]
        states = [each[0] for each in said if each is not None and each[0] in set(PrintState)]
        return states[-1] if states else "fault"


@pytest.mark.slow
def test_a_print_that_is_killed_on_drives_leaves_all_braked_and_is_resumed(drives: Watched, tmp_path: Path) -> None:
    job, folder = tmp_path / "job.toml", tmp_path / "run"
    job.write_text(RING, encoding="utf-8")
    program = [sys.executable, "-m", "cablewright"]
    home = ["drives", "home", "merlet2023", "--machine", str(tmp_path / "machine.toml"), "--place", "0.7,-0.5,1"]
    subprocess.run([*program, *home], check=True, timeout=120)
    command = [
        *program,
        "print",
        "merlet2023",
        str(job),
        "--machine",
        str(tmp_path / "machine.toml"),
        "--out",
        str(folder),
    ]
    printing = Typed(command)
    try:
        printing.until("printing")
        time.sleep(1.0)
    finally:
        printing.process.kill()
        began = time.monotonic()
    while not drives.braked:
        assert time.monotonic() - began < 1.5, [drive.state for drive in drives.rig.drives]
        time.sleep(0.005)
    printing.end(signal.SIGKILL)
    time.sleep(0.2)
    assert still(drives)
    again = Typed([*command, "--resume"])
    try:
        again.until("idle")
    finally:
        again.end(signal.SIGINT)
    assert drives.braked
