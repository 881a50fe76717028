"""EtherCAT drives by pysoem, in an emulated ring of four, by the clock: SOEM is the oracle of the emulation."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.foundation.signals import Command, Condition, Encoders, PrintState, SensorFrame, WinchMode
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.ethercat.ethercat_drives import EthercatDrives
from cablewright.machine.interface import RESET
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from ring_of_drives import FAR, HERE, SLOW, Drives, missing, ring_of_drives, twin
from virtual_drives import RING, RING_BEGIN

SLOWLY = {"print_speed": 0.04, "travel_speed": 0.04, "acceleration": 0.1}
WHY_NOT = missing()
pytestmark = pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT)

SENDS = f"""
import socket, time
port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
port.bind(("{FAR}", 0x88A4))
print("", flush=True)
while True:
    port.send(bytes([255] * 6 + [2] * 6 + [0x88, 0xA4]) + bytes(46))
    time.sleep(0.01)
"""
SPEEDS = (0.2, 0.2, -0.2, -0.2)  # rad/s
VALVE = {"line": "south-east", "bit": 19, "closes_alone": True}
ROBOT = load("merlet2023")
EXAMPLE = Path(__file__).parents[3] / "examples" / "virtual-drives.toml"


@pytest.fixture(scope="module")
def ring() -> Iterator[Drives]:
    with ring_of_drives() as found:
        yield found


@pytest.fixture
def drives(ring: Drives) -> Drives:
    """All of them there, and just switched on."""
    switch_on(ring)
    return ring


def switch_on(drives: Drives) -> None:
    for place in range(4):
        drives.do("cut", place, False)
        drives.do("restart", place)


@contextmanager
def opened(**changes: object) -> Iterator[DriveMachine]:
    owner = twin(**changes).owner
    machine = DriveMachine(EthercatDrives(ROBOT, owner), owner)
    machine.open()
    try:
        yield machine
    finally:
        machine.close()


def step(
    machine: DriveMachine, mode: WinchMode = WinchMode.OFF, speeds: object = None, steps: int = 1, **more: object
) -> SensorFrame:
    given = np.zeros(4) if speeds is None else np.array(speeds)
    for _ in range(steps):
        frame = machine.step(Command(machine.drives.now(), given, modes=(mode,) * 4, **more))
    return frame


def enabled(machine: DriveMachine) -> None:
    step(machine, steps=3)
    step(machine, WinchMode.VELOCITY)
    assert not machine.tripped


def eventually(drives: Drives, holds: Callable[[dict], bool], seconds: float = 3.0) -> dict:
    end = time.monotonic() + seconds
    while not holds(found := drives.do("tell")):
        assert time.monotonic() < end, found
        time.sleep(0.02)
    return found


def test_a_ring_of_four_reaches_operation_and_prints_a_ring(drives: Drives) -> None:
    """The platform goes where it goes on the plant itself, and powder is poured by the valve."""
    helix, motion = RING.helix.model_copy(update={"radius": 0.05}), Motion(**SLOWLY)
    job = RING.model_copy(update={"origin": (0.65, -0.5, 0.0), "helix": helix, "motion": motion})
    assert isinstance(job.helix, Helix)
    settings = twin(valve=VALVE)
    path = TimedPath.of(job, None, 0.0)
    assert np.allclose(path.track.at(0.0).position, RING_BEGIN["merlet2023"])
    plant = SimulatedMachine(ROBOT, settings.with_simulation(wire=Link()), RING_BEGIN["merlet2023"], seed=0)
    here: list[np.ndarray] = []
    there: list[np.ndarray] = []
    times: list[float] = []

    def printed(machine: object, place: Callable[[], object], kept: list[np.ndarray], each: int) -> None:
        plan = planned(ROBOT, settings.owner, path, settings.owner.period, "encoders", "model", None)
        printer = Printer(plan, machine, lambda place, radii: estimator("encoders", ROBOT, settings.owner, place))

        class Kept:
            count = 0

            def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
                self.count += 1
                times.append(step.frame.time)
                if step.progress.state is PrintState.PRINTING and self.count % each == 0:
                    kept.append(np.array(place()))

        loop.run(printer, Attendant(lambda: None, resume_delay=0.1, refill_time=0.1), Kept())
        assert printer.finished, printer.supervisor.reason

    printed(plant, lambda: plant.truth.position, here, 1)  # first, so that all is compiled
    times.clear()
    before = drives.do("tell")["powder"]
    machine = DriveMachine(EthercatDrives(ROBOT, settings.owner), settings.owner)
    printed(machine, lambda: drives.do("tell")["position"], there, 10)
    assert machine.drives.statistics.cycles > 600
    held_up = max(np.diff(times))  # s: for so long the winches go on as last commanded
    after = drives.do("tell")
    assert all(after["brakes"])
    assert machine.left == ""
    assert 0.05 < before - after["powder"] < 0.25  # 8 s at 18.8 g/s
    apart = [np.linalg.norm(np.array(here) - place, axis=1).min() for place in there]
    assert max(apart) < 1e-3 + 2.0 * SLOWLY["print_speed"] * held_up
    assert np.ptp(np.array(there), axis=0)[:2] == pytest.approx([0.1, 0.1], abs=0.01)  # all around


def test_drives_whose_master_is_silent_stop_by_themselves_and_come_back_by_a_reset(drives: Drives) -> None:
    with opened() as machine:
        enabled(machine)
        step(machine, WinchMode.VELOCITY, SPEEDS, 20)
        time.sleep(SLOW["command_timeout"] + 0.8)  # as if the process had been stopped
        found = drives.do("tell")
        assert all(found["brakes"])
        assert found["codes"] == [0x8250] * 4
        assert found["bus"] == [4] * 4  # safe-operational, by the watchdog
        step(machine, WinchMode.VELOCITY, SPEEDS, 3)
        assert "its drive is safe-operational, not operational: Sync manager watchdog" in machine.tripped
        assert drives.do("tell")["angles"] == pytest.approx(found["angles"], abs=1e-6)
        step(machine, outputs={RESET: 1.0}, steps=3)
        assert not machine.tripped
        assert drives.do("tell")["bus"] == [8] * 4
        step(machine, WinchMode.VELOCITY, SPEEDS, 5)
        assert not machine.tripped


def test_a_fault_and_a_cable_that_is_pulled_stop_all(drives: Drives) -> None:
    with opened(valve=VALVE) as machine:
        enabled(machine)
        step(machine, WinchMode.VELOCITY, SPEEDS, 10, valve=1.0)
        assert drives.do("tell")["valve"]
        drives.do("fail", 2, 0x2310)
        step(machine, WinchMode.VELOCITY, SPEEDS, 60)
        assert machine.tripped.startswith("north-east: 0x2310 continuous over current")
        found = drives.do("tell")
        assert all(found["brakes"])
        assert not found["valve"]
        step(machine, outputs={RESET: 1.0}, steps=3)
        step(machine, WinchMode.VELOCITY, SPEEDS, 10)
        assert not machine.tripped
        drives.do("cut", 2, True)  # the frames turn round before the third
        for _ in range(100):
            frame = step(machine, WinchMode.VELOCITY, SPEEDS)
        assert {n.subject for n in frame.notices if n.condition is Condition.BUS_SILENT} >= {"north-east", "north-west"}
        assert "does not answer" in machine.tripped
        assert all(eventually(drives, lambda now: all(now["brakes"]))["brakes"])
        drives.do("cut", 2, False)


def test_a_drive_that_lost_power_has_no_address_until_the_machine_is_opened_again(drives: Drives) -> None:
    with opened() as machine:
        enabled(machine)
        drives.do("restart", 1)
        step(machine, WinchMode.VELOCITY, SPEEDS, 100)
        assert machine.tripped == "south-east: its drive does not answer"
        eventually(drives, lambda now: all(now["brakes"]))
        step(machine, outputs={RESET: 1.0}, steps=3)
        assert machine.tripped
    with opened() as machine:
        step(machine, outputs={RESET: 1.0}, steps=3)
        enabled(machine)


def test_drives_that_do_not_obey_are_left_to_their_watchdogs(drives: Drives) -> None:
    """Without heartbeat no outputs are sent, and inputs are read all the same."""
    with opened() as machine:
        enabled(machine)
        machine._beats = False
        end, frames = time.monotonic() + SLOW["command_timeout"] + 0.6, []
        while time.monotonic() < end:
            frames.append(step(machine, WinchMode.VELOCITY, SPEEDS))
        assert drives.do("tell")["bus"] == [4] * 4
        assert all(drives.do("tell")["brakes"])
        assert any(frame.of(Encoders) for frame in frames[-20:])


REFUSALS = {
    "another profile": (("profile", 1, 0x00020191), InputError, r"drives.nodes.south-east.id = 2: has the profile 401"),
    "a watchdog that is not kept": (
        ("stubborn", 3, (0x0420, 0x0422)),
        InputError,
        r"line north-west \(node 4\): 0x0420 watchdog of process data \(register\) = 1000, not 8000",
    ),
    "outputs that set no watchdog back": (
        ("stubborn", 0, (0x0810, 0x0818)),
        EnvironmentFault,
        r"position 1 of the ring does not become safe-operational: Invalid output configuration",
    ),
    "a lost connection that is no fault": (
        ("stubborn object", 2, (0x6007, 0)),
        InputError,
        r"0x6007 reaction to a lost connection = 0, not 1",
    ),
    "no process data": (
        ("stubborn object", 2, (0x1C12, 2)),
        InputError,
        r"0x1C12:2 assigned PDO = 0, not 5633",
    ),
    "a shorter ring": (("cut", 3, True), EnvironmentFault, r"id = 4: the ring has 3 devices"),
    "no ring": (("cut", 0, True), EnvironmentFault, r"id = 1: no device answers"),
}


def test_what_is_not_such_a_ring_is_rejected(drives: Drives) -> None:
    for name, (order, kind, says) in REFUSALS.items():
        drives.do(*order)
        owner = twin().owner
        with pytest.raises(kind, match=says) as caught:
            DriveMachine(EthercatDrives(ROBOT, owner), owner).open()
        assert isinstance(caught.value, CablewrightError), name
        switch_on(drives)


def test_another_master_and_a_missing_interface_are_rejected(drives: Drives) -> None:
    owner = twin().owner
    sender = subprocess.Popen([sys.executable, "-c", SENDS], stdout=subprocess.PIPE)
    assert sender.stdout is not None
    sender.stdout.readline()
    with pytest.raises(EnvironmentFault, match=f"another master sends on {HERE}; end it first"):
        EthercatDrives(ROBOT, owner).open()
    sender.kill()
    sender.communicate()
    gone = twin().owner
    gone = gone.model_copy(update={"drives": gone.drives.model_copy(update={"interface": "cwnone"})})
    with pytest.raises(EnvironmentFault, match=r"the interface cwnone cannot be opened: .*ip link set cwnone up"):
        EthercatDrives(ROBOT, gone).open()


def test_a_program_that_is_killed_is_missed_by_all(drives: Drives, tmp_path) -> None:
    text = (EXAMPLE.read_text("utf-8")).replace('kind = "canopen"', 'kind = "ethercat"')
    text = text.replace('interface = "loopback"', f'interface = "{HERE}"').replace("# acknowledged", "acknowledged")
    text = text.replace('command_timeout = "300 ms"', 'command_timeout = "800 ms"')
    file = tmp_path / "machine.toml"
    file.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "cablewright", "drives", "enable", "merlet2023", "--machine", str(file)]
    program = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        eventually(drives, lambda now: not any(now["brakes"]), 30.0)
        os.kill(program.pid, signal.SIGKILL)
        found = eventually(drives, lambda now: all(now["brakes"]))
        assert found["states"] == ["fault"] * 4
    finally:
        program.kill()
        program.wait()
