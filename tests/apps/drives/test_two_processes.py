"""By wall clock, drives in one process and their host in another: the host is stopped for a second, or killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.cia402 import PowerState
from cases import some
from virtual_drives import Watched, watched_drives

pytestmark = [
    pytest.mark.clock,
    pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="stopping a process needs POSIX signals"),
]

HOST = """
import sys, gc
sys.path.insert(0, {tests!r})
import numpy as np
from virtual_drives import virtual_twin
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.robot import load
from cablewright.foundation.signals import Command, WinchMode
times = dict(heartbeat_timeout=0.6, command_timeout=0.5, answer_timeout=0.4)  # a busy computer stalls
robot, owner = load("merlet2023"), virtual_twin(channel={channel!r}, **times).owner
machine = DriveMachine(CanopenDrives(robot, owner), owner)
gc.disable()
machine.open()
off, on = (WinchMode.OFF,) * 4, (WinchMode.VELOCITY,) * 4
speeds = np.array([0.5, 0.5, -0.5, -0.5])
for k in range(3):
    machine.step(Command(0.01 * k, np.zeros(4), modes=off))
machine.step(Command(0.05, np.zeros(4), modes=off, outputs=dict(reset=1.0)))
machine.step(Command(0.1, np.zeros(4), modes=on))
for k in range(1000):
    frame = machine.step(Command(1.0 + 0.01 * k, speeds * np.cos(0.02 * k), modes=on))
    if k == 20:
        print("moving" if not machine.tripped else machine.tripped, flush=True)
    if machine.tripped and k > 60:
        break
print(machine.tripped, flush=True)
machine.close()
"""


@pytest.fixture
def watched() -> Iterator[Watched]:
    with watched_drives() as found:
        yield found


@pytest.fixture
def host(watched: Watched) -> Iterator[subprocess.Popen[str]]:
    """A host whose winches turn."""
    text = HOST.format(tests=str(Path(__file__).parents[2]), channel=str(watched.channel))
    for _ in range(3):  # a busy computer may hold it up, so that the drives stop: as they should
        process = subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        said = process.stdout.readline().strip()
        if said == "moving":
            break
        process.kill()
        process.communicate()
    assert said == "moving", said
    yield process
    process.kill()
    process.communicate()


def test_a_host_that_is_stopped_for_a_second_finds_all_braked(watched: Watched, host: subprocess.Popen[str]) -> None:
    os.kill(host.pid, signal.SIGSTOP)
    began = time.monotonic()
    watched.wait("FAULT")
    took = time.monotonic() - began
    codes = {drive.dictionary[o.ERROR_CODE] for drive in watched.rig.drives}
    time.sleep(max(0.0, 1.0 - took))
    angles = watched.rig.plant.rig.winches.angles
    os.kill(host.pid, signal.SIGCONT)
    assert host.stdout is not None
    said = host.stdout.readline()
    assert took < 5.0
    assert codes <= {0x8130, 0x8250}
    reasons = ("no command came in time", "heartbeat of the computer is missing", "its drive does not answer")
    assert any(each in said for each in reasons), said
    host.wait(timeout=20.0)
    assert watched.braked
    assert np.abs(watched.rig.plant.rig.winches.angles - angles).max() < 1e-3  # nothing old was obeyed
    assert max(watched.tensions) < 700.0


def test_a_host_that_is_killed_leaves_all_braked(watched: Watched, host: subprocess.Popen[str]) -> None:
    host.kill()
    watched.wait("FAULT")
    assert watched.braked
    time.sleep(0.2)  # the simulated winches lag behind their drives
    angles = watched.rig.plant.rig.winches.angles
    time.sleep(0.5)
    assert np.abs(watched.rig.plant.rig.winches.angles - angles).max() < 1e-3
    assert max(watched.tensions) < 700.0


@pytest.mark.parametrize("number", some(["SIGINT", "SIGTERM"]))
def test_a_command_that_is_interrupted_brakes_all_first(watched: Watched, number: str, tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "examples" / "virtual-drives.toml").read_text("utf-8")
    file = tmp_path / "machine.toml"
    file.write_text(text.replace('"43113"', f'"{watched.channel}"'), encoding="utf-8")
    command = [sys.executable, "-m", "cablewright", "drives", "enable", "merlet2023", "--machine", str(file)]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored in the background of a shell
    )
    watched.wait("ENABLED", 30.0)
    time.sleep(0.5)
    process.send_signal(getattr(signal, number))
    _, said = process.communicate(timeout=20.0)
    assert process.returncode == 130, said
    assert said.strip().endswith("interrupted")
    assert watched.braked
    time.sleep(0.6)
    assert not any(drive.state is PowerState.FAULT for drive in watched.rig.drives)
