"""Drives must report that they are disabled; the torque of a moving one is never cut; a deaf one stops by itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.signals import Condition, WinchMode
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import BusError, CanFrame
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.cia402 import PowerState
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.interface import RESET
from cases import often
from virtual_drives import SPEEDS, Bench, bench, braked, moving


def unwatched(found: Bench, line: int = 0) -> None:
    """A drive without a timeout of commands: it may lack the object."""
    found.rig.drives[line].dictionary.entries[0x1400, 5].data = bytes(2)


def words_to(found: Bench) -> list[tuple[int, int, PowerState]]:
    """Node, controlword and the drive's state, of each command from now on."""
    words: list[tuple[int, int, PowerState]] = []
    send = found.port.send

    def watched(frame: CanFrame) -> None:
        if frame.id & 0x780 == o.CONTROL_PDO:
            node = frame.id & 0x7F
            words.append((node, int.from_bytes(frame.data[:2], "little"), found.rig.drives[node - 1].state))
        send(frame)

    found.port.send = watched  # type: ignore[method-assign]
    return words


def preoperational(found: Bench) -> None:
    found.rig.drives[0].nmt, found.rig.drives[0]._commanded = o.PREOPERATIONAL, float("nan")


def other_master(found: Bench) -> None:
    found.port.inject(CanFrame(o.NMT, bytes([o.NMT_PREOPERATIONAL, 0])))


def deaf(found: Bench) -> None:
    """It answers, but no command reaches it any more."""
    unwatched(found)
    send = found.port.send
    found.port.send = lambda frame: None if frame.id == o.CONTROL_PDO + 1 else send(frame)  # type: ignore[method-assign]


def unsendable(found: Bench) -> None:
    unwatched(found)
    send = found.port.send

    def failing(frame: CanFrame) -> None:
        if frame.id == o.CONTROL_PDO + 1:
            raise BusError("no buffer space")
        send(frame)

    found.port.send = failing  # type: ignore[method-assign]


@pytest.mark.parametrize("harm", [preoperational, other_master, deaf, unsendable])
def test_a_drive_that_cannot_be_switched_off_stops_by_its_own_watch(harm: Callable[[Bench], None]) -> None:
    """Without proof that it is disabled the heartbeat ends, so that it stops as if the host were gone."""
    found = moving()
    harm(found)
    found.step(WinchMode.OFF, steps=3)
    found.step(WinchMode.OFF, steps=200)
    assert braked(found)
    assert found.rig.drives[0].dictionary[o.ERROR_CODE] == 0x8130
    assert found.machine.tripped
    angles = found.rig.plant.rig.winches.angles
    found.step(WinchMode.VELOCITY, SPEEDS, 100)
    assert np.abs(found.rig.plant.rig.winches.angles - angles).max() < 1e-6


def test_closing_leaves_the_watch_of_a_drive_that_is_not_proven_to_be_off() -> None:
    found = moving()
    preoperational(found)
    found.machine.close()
    assert found.rig.drives[0].dictionary[o.CONSUMER_HEARTBEAT] & 0xFFFF
    assert "south-west: its drive was not seen to switch off" in found.machine.left
    found.hang(0.7)
    assert braked(found)


def test_closing_waits_for_a_drive_that_has_to_stop_by_itself() -> None:
    found = moving()
    deaf(found)
    found.machine.close()
    assert braked(found)
    assert not found.machine.left
    assert found.rig.drives[0].dictionary[o.ERROR_CODE] == 0x8130


def test_an_orderly_end_leaves_no_drive_waiting_for_a_heartbeat() -> None:
    found = moving()
    found.machine.close()
    assert not found.machine.left
    assert not any(drive.dictionary[o.CONSUMER_HEARTBEAT] for drive in found.rig.drives)


def test_an_error_of_sending_is_not_forgotten_by_the_next_frame_that_comes() -> None:
    found = moving()
    unsendable(found)
    frame = found.step(WinchMode.VELOCITY, SPEEDS, 3)
    assert "no buffer space" in found.machine.tripped
    assert any(notice.condition is Condition.BUS_SILENT for notice in frame.notices)


def test_a_reset_neither_trusts_nor_revives_a_drive_that_is_silent() -> None:
    found = moving()
    preoperational(found)
    found.step(WinchMode.OFF, steps=10)
    found.step(WinchMode.OFF, outputs={RESET: 1.0})
    assert found.machine.tripped
    found.step(WinchMode.VELOCITY, SPEEDS, 50)
    assert braked(found)


def test_a_drive_that_ramps_slowly_is_waited_for() -> None:
    found = moving(deceleration=0.1)
    found.machine.stop()
    assert braked(found)
    assert not any(drive.state is PowerState.FAULT for drive in found.rig.drives)


@pytest.mark.parametrize("early", [False, True])
@pytest.mark.parametrize("how", ["off", "stop", "fault", "reset"])
def test_torque_stays_until_the_brake_has_closed(how: str, early: bool) -> None:
    """Also of drives that report to be disabled while it closes: the platform, which would fall, does not move."""
    found = moving()
    found.step(WinchMode.HOLD, steps=50)
    for drive in found.rig.drives:
        drive.tells_early = early
    lost = [0]
    advance = found.rig.advance

    def watched(now: float | None = None) -> list[CanFrame]:
        said = advance(now)
        lost[0] += any(not drive.brake_closed and not drive._powered for drive in found.rig.drives)
        return said

    found.rig.advance = watched  # type: ignore[method-assign]
    high = found.rig.plant.truth.position[2]
    if how == "stop":
        found.machine.stop()
    elif how == "off":
        found.step(WinchMode.OFF, steps=60)
    else:
        found.rig.drives[0].fail(0x2310)
        found.step(WinchMode.OFF, steps=1)
        for _ in range(10):
            found.step(WinchMode.OFF, outputs={RESET: 1.0} if how == "reset" else {})
        found.step(WinchMode.OFF, steps=60)
    assert not lost[0]
    assert braked(found)
    assert abs(found.rig.plant.truth.position[2] - high) < 2e-4


@pytest.mark.parametrize("clears", [True, False])
def test_a_drive_that_stops_by_its_own_input_is_ramped_held_and_braked(clears: bool) -> None:
    """It never gets the command to disable voltage; where its input stays, its watch over the heartbeat ends it."""
    found = moving()
    words = words_to(found)
    found.rig.drives[0].stop_input = True
    lost = [0]
    advance = found.rig.advance

    def watched(now: float | None = None) -> list[CanFrame]:
        said = advance(now)
        drive = found.rig.drives[0]
        lost[0] += not drive.brake_closed and not drive._powered
        return said

    found.rig.advance = watched  # type: ignore[method-assign]
    found.step(WinchMode.VELOCITY, SPEEDS, 10)
    assert found.machine.tripped == "south-west: is no longer enabled but quick stop active"
    found.rig.drives[0].stop_input = not clears
    found.step(WinchMode.VELOCITY, SPEEDS, 200)
    assert braked(found)
    assert not lost[0]
    assert {word for _, word, _ in words} <= {0x06, 0x07, 0x0F}
    assert not any(word == 0x06 and state not in SAFE for _, word, state in words)
    assert found.rig.drives[0].state is (PowerState.READY if clears else PowerState.FAULT)


SAFE = (PowerState.SWITCHED_ON, PowerState.READY, PowerState.DISABLED, PowerState.FAULT)


def test_drives_that_an_earlier_program_left_enabled_are_braked_before_anything_is_changed() -> None:
    found = moving()
    for drive in found.rig.drives:  # it watched nothing
        drive.dictionary[o.CONSUMER_HEARTBEAT] = 0
        drive.dictionary.entries[0x1400, 5].data = bytes(2)
        drive._commanded = drive._beat_heard = float("nan")
        drive.dictionary[o.DISABLE_OPTION] = 0  # torque off without delay
    found.drives._leave()
    again = DriveMachine(CanopenDrives(found.robot, found.twin.owner, lambda: found.port), found.twin.owner)
    high, words = found.rig.plant.truth.position[2], words_to(found)
    again.open()
    assert braked(found)
    found.machine = again
    found.step(WinchMode.OFF, steps=3)
    assert {word for _, word, _ in words} <= {0x06, 0x07}
    assert abs(found.rig.plant.truth.position[2] - high) < 0.05  # it moved at half a radian a second, and stopped


def test_one_that_was_left_enabled_and_does_not_obey_is_rejected() -> None:
    found = moving()
    found.drives._leave()
    for drive in found.rig.drives:
        drive._beat_heard = drive._commanded = float("nan")
    found.rig.drives[2].dictionary.stubborn.add((o.CONTROLWORD.index, 0))
    found.rig.drives[2]._control = lambda word: None  # type: ignore[method-assign]
    again = DriveMachine(CanopenDrives(found.robot, found.twin.owner, lambda: found.port), found.twin.owner)
    with pytest.raises(EnvironmentFault, match=r"north-east .* left under torque"):
        again.open()


@pytest.mark.parametrize("how", ["silent", "master", "restart", "fault", "bus"])
@pytest.mark.parametrize("stage", range(0, 60, often(20, 12)))
def test_whatever_happens_while_winches_are_enabled_leaves_all_braked(stage: int, how: str) -> None:
    """A drive falls silent, faults or restarts, another master comes, or the bus fails, in any cycle of it."""
    found = bench()
    found.machine.open()
    found.step(steps=25)
    count, cycle = [0], found.drives._network.cycle  # type: ignore[union-attr]

    def counted(*given: object, **more: object) -> float:
        count[0] += 1
        if count[0] == stage + 1:
            drive = found.rig.drives[1]
            if how == "silent":
                drive.hear = lambda *_: None  # type: ignore[method-assign]  # its cable is unplugged
            found.port.down = how == "bus"
            if how == "master":
                found.port.inject(CanFrame(o.SYNC))
            elif how == "restart":
                drive.restart()
            elif how == "fault":
                drive.fail(0x3210)
        return cycle(*given, **more)  # type: ignore[arg-type]

    found.drives._network.cycle = counted  # type: ignore[union-attr, method-assign]
    found.step(WinchMode.VELOCITY)
    found.step(WinchMode.VELOCITY, SPEEDS, 100)
    assert count[0] > stage
    assert found.machine.tripped
    assert sum(not drive.brake_closed for drive in found.rig.drives) == 0
