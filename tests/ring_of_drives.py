"""A ring of virtual EtherCAT drives in a network namespace of its own, for tests.

As a program: `python ring_of_drives.py INTERFACE ROBOT` is the drives, obeys a line of JSON each and answers with one.
"""

from __future__ import annotations

import ctypes
import json
import os
import select
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

HERE, FAR = "cwmaster", "cwdrives"  # the two ends of the cable
_CLONE_NEWNET = 0x40000000
# The computer is shared: whatever it is held up by is no fault of a drive.
SLOW = {"command_timeout": 0.8, "heartbeat_timeout": 1.0, "answer_timeout": 0.6, "following_error": 0.1}


def missing() -> str:
    """Why there can be no ring here; empty: there can."""
    if sys.platform != "linux" or os.geteuid() != 0:
        return "an emulated EtherCAT ring needs Linux and root"
    if find_spec("pysoem") is None:
        return "an emulated EtherCAT ring needs pysoem: pip install 'cablewright[ethercat]'"
    if shutil.which("ip") is None:
        return "an emulated EtherCAT ring needs ip of iproute2"
    name = f"cwtry{os.getpid()}"
    if _ip("netns", "add", name).returncode:
        return "an emulated EtherCAT ring needs network namespaces, which cannot be made here"
    _ip("netns", "del", name)
    return ""


def _ip(*words: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(["ip", *words], capture_output=True, check=False)


@contextmanager
def in_time() -> Iterator[None]:
    """Before all that is not bound to the clock, as a program that commands drives should run, where it may."""
    policy, given = os.sched_getscheduler(0), os.sched_getparam(0)
    with suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, given)


class Drives:
    """The drives in the other process."""

    def __init__(self, namespace: str, robot: str) -> None:
        command = ["ip", "netns", "exec", namespace, sys.executable, str(Path(__file__)), FAR, robot]
        path = os.pathsep.join(each for each in (str(Path(__file__).parent), *sys.path) if each)
        environment = {**os.environ, "PYTHONPATH": path}
        self.namespace = namespace
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        self._answer()

    def do(self, what: str, *arguments: Any) -> Any:
        """Order something, and return the answer."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps([what, *arguments]) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> Any:
        assert self._process.stdout is not None
        return json.loads(self._process.stdout.readline())

    def end(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(10.0)
        assert self._process.stdout is not None
        self._process.stdout.close()


@contextmanager
def ring_of_drives(robot: str = "merlet2023") -> Iterator[Drives]:
    """Drives of a *robot* on a cable, in whose namespace this thread is meanwhile."""
    name = f"cw{os.getpid()}"
    libc = ctypes.CDLL(None, use_errno=True)
    with open("/proc/thread-self/ns/net") as home:
        try:
            for words in (
                ("netns", "add", name),
                ("-n", name, "link", "add", "name", HERE, "type", "veth", "peer", "name", FAR),
                ("-n", name, "link", "set", HERE, "up"),
                ("-n", name, "link", "set", FAR, "up"),
            ):
                done = _ip(*words)
                if done.returncode:
                    pytest.skip(f"an emulated EtherCAT ring: ip {' '.join(words)}: {done.stderr.decode()}")
            with open(f"/run/netns/{name}") as there:
                assert libc.setns(there.fileno(), _CLONE_NEWNET) == 0, os.strerror(ctypes.get_errno())
            drives = Drives(name, robot)
            try:
                with in_time():
                    yield drives
            finally:
                drives.end()
        finally:
            libc.setns(home.fileno(), _CLONE_NEWNET)
            _ip("netns", "del", name)


def twin(robot: str = "merlet2023", **changes: Any) -> Any:
    """The machine of `virtual_twin` for a *robot*, in the ring."""
    from virtual_drives import virtual_twin

    table = {"interface": HERE, "channel": FAR, "acknowledged": "tested on virtual drives only", **SLOW}
    return virtual_twin(robot, **table, **changes).with_owner(kind="ethercat")


def main() -> None:
    """Be the drives."""
    from cablewright.machine.drives.virtual.ethercat_ring import VirtualRing, run_ring
    from cablewright.machine.drives.virtual.rig import VirtualRig
    from cablewright.robot import load
    from virtual_drives import RING_BEGIN

    name = sys.argv[2]
    robot = load(name)
    valve = {"line": robot.lines[0].name, "bit": 19, "closes_alone": True}
    rig = VirtualRig(robot, twin(name, valve=valve), RING_BEGIN[name])
    rig.warm()
    ring = VirtualRing(rig)
    over = False

    def obey() -> bool:
        nonlocal over
        while not over and select.select([sys.stdin], [], [], 0.0)[0]:
            line = sys.stdin.readline()
            over = not line
            if line:
                print(json.dumps(_done(ring, *json.loads(line))), flush=True)
        return over

    with in_time():
        run_ring(ring, sys.argv[1], obey, lambda: print("0", flush=True))


def _done(ring: Any, what: str, *arguments: Any) -> Any:
    rig = ring.rig
    match what:
        case "fail":
            ring.slaves[arguments[0]].drive.fail(arguments[1])
        case "cut":
            ring.slaves[arguments[0]].cut = arguments[1]
        case "restart":
            ring.slaves[arguments[0]].restart()
        case "profile":
            drive = ring.slaves[arguments[0]].drive
            drive.dictionary.entries[0x1000, 0].data = arguments[1].to_bytes(4, "little")
        case "stubborn":
            ring.slaves[arguments[0]].memory.stubborn = range(*arguments[1])
        case "stubborn object":
            ring.slaves[arguments[0]].drive.dictionary.stubborn.add(tuple(arguments[1]))
    return {
        "position": list(rig.plant.truth.position),
        "rotation": list(rig.plant.truth.rotation),
        "angles": list(rig.plant.rig.winches.angles),
        "powder": rig.plant.truth.powder,
        "brakes": [slave.drive.brake_closed for slave in ring.slaves],
        "states": [slave.drive.state.value for slave in ring.slaves],
        "codes": [int.from_bytes(slave.drive.dictionary.entries[0x603F, 0].data, "little") for slave in ring.slaves],
        "bus": [slave.state for slave in ring.slaves],
        "valve": rig.valve_open,
    }


if __name__ == "__main__":
    main()
