"""What goes wrong on the bus and in drives, in virtual time: always a named safe state, and no motion after it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.signals import (
    ORDER_LIFE,
    Condition,
    Drives,
    DriveState,
    Encoders,
    SensorFrame,
    Tensions,
    WinchMode,
)
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.cia402 import PowerState
from cablewright.machine.interface import RESET
from virtual_drives import SPEEDS, Bench, bench, moving


def causes(frame: SensorFrame) -> str:
    """What the guard would stop for."""
    found = [f"{notice.condition.value}: {notice.subject}" for notice in frame.notices]
    for reading in frame.of(Drives):
        found += [text for state, text in zip(reading.states, reading.faults, strict=True) if state is DriveState.FAULT]
    return "; ".join(found)


def assert_comes_to_rest(found: Bench, within: float) -> None:
    """Whatever is commanded, within a time (s) brakes are closed, and nothing turns again without a reset."""
    found.step(WinchMode.VELOCITY, SPEEDS, round(within / found.machine.period))
    assert all(drive.brake_closed for drive in found.rig.drives)
    before = found.rig.plant.rig.winches.angles
    found.step(WinchMode.VELOCITY, SPEEDS, 100)
    assert np.abs(found.rig.plant.rig.winches.angles - before).max() < 1e-6


@pytest.mark.parametrize("line", range(4))
def test_a_drive_that_faults_stops_all(line: int) -> None:
    found = moving()
    found.rig.drives[line].fail(0x2310)
    found.step(WinchMode.VELOCITY, SPEEDS)
    frame = found.step(WinchMode.VELOCITY, SPEEDS)
    assert found.rig.names[line] in found.machine.tripped
    assert "0x2310 continuous over current" in causes(frame)
    assert_comes_to_rest(found, 0.5)


@pytest.mark.parametrize("line", range(4))
def test_a_drive_that_falls_silent_stops_the_others(line: int) -> None:
    found = moving()
    found.rig.drives[line].dead = True
    for _ in range(8):
        frame = found.step(WinchMode.VELOCITY, SPEEDS)
    assert any(n.condition is Condition.BUS_SILENT and n.subject == found.rig.names[line] for n in frame.notices)
    found.rig.drives[line].dead = False  # its own watch over commands has stopped it, or does now
    assert_comes_to_rest(found, 0.5)


def test_the_bus_goes_off_and_the_drives_stop_by_themselves() -> None:
    found = moving()
    found.port.down = True
    frame = found.step(WinchMode.VELOCITY, SPEEDS, 30)
    assert "bus off" in causes(frame)
    assert all(drive.state is PowerState.FAULT and drive.brake_closed for drive in found.rig.drives)
    found.port.down = False
    assert_comes_to_rest(found, 0.2)


def test_a_host_that_hangs_is_missed_by_each_drive() -> None:
    found = moving()
    before = found.rig.plant.rig.winches.angles
    found.hang(1.0)  # as if the process had been stopped for a second
    after = found.rig.plant.rig.winches.angles
    assert all(drive.state is PowerState.FAULT and drive.brake_closed for drive in found.rig.drives)
    timeout = found.drives.settings.command_timeout
    assert np.abs(after - before).max() < 0.5 * (timeout + 0.05)
    frame = found.step(WinchMode.VELOCITY, SPEEDS, 2)
    assert "0x8250 no command came in time" in causes(frame)
    assert_comes_to_rest(found, 0.1)


def test_without_a_timeout_of_commands_the_heartbeat_stops_them() -> None:
    found = moving()
    for drive in found.rig.drives:
        drive.dictionary.entries[0x1400, 5].data = bytes(2)
    found.hang(1.0)
    assert all(drive.dictionary[o.ERROR_CODE] == 0x8130 for drive in found.rig.drives)
    assert all(drive.brake_closed for drive in found.rig.drives)


def test_drives_that_watch_nothing_are_switched_off_after_a_hang_and_move_no_more() -> None:
    found = moving()
    for drive in found.rig.drives:
        drive.dictionary.entries[0x1400, 5].data = bytes(2)
        drive.dictionary[o.CONSUMER_HEARTBEAT] = 0
    found.hang(ORDER_LIFE + 0.5)
    assert not any(drive.state is PowerState.FAULT for drive in found.rig.drives)
    found.step(WinchMode.VELOCITY, SPEEDS, 2)
    assert found.machine.tripped == "the control hung for 1.5 s"
    assert_comes_to_rest(found, 0.5)


KINDS = {
    "controls": o.CONTROL_PDO,
    "torques": o.TORQUE_PDO,
    "states": o.STATE_PDO,
    "loads": o.LOAD_PDO,
    "inputs": o.INPUT_PDO,
    "sync": o.SYNC,
    "heartbeat": o.HEARTBEAT,
}


@pytest.mark.parametrize("what", ["lost", "late", "doubled"])
@pytest.mark.parametrize("kind", KINDS)
def test_one_frame_of_each_kind_is_lost_late_or_doubled(kind: str, what: str) -> None:
    """One alone is lived through: the winches go on, and no reading is made up."""
    left = [0]

    def disturb(frame: CanFrame, now: float) -> tuple[float, ...]:
        if left[0] and frame.id & 0x780 == KINDS[kind]:
            left[0] -= 1
            return {"lost": (), "late": (0.012,), "doubled": (0.0, 0.0)}[what]
        return (0.0,)

    found = moving(disturb=disturb)
    counts = [reading.counts for frame in found.frames for reading in frame.of(Encoders)]
    left[0] = 1
    found.step(WinchMode.VELOCITY, SPEEDS, 30)
    assert not found.machine.tripped
    assert not left[0]
    counts = [reading.counts for frame in found.frames[-40:] for reading in frame.of(Encoders)]
    assert len(counts) >= 37
    assert (np.abs(np.diff(counts, axis=0)) < 2.6 * 0.5 * found.machine.period * 18702).all()


@pytest.mark.parametrize("kind", ["controls", "states", "sync", "heartbeat"])
def test_frames_that_stay_away_stop_the_machine(kind: str) -> None:
    away = [False]

    def disturb(frame: CanFrame, now: float) -> tuple[float, ...]:
        return () if away[0] and frame.id & 0x780 == KINDS[kind] else (0.0,)

    found = moving(disturb=disturb)
    away[0] = True
    frame = found.step(WinchMode.VELOCITY, SPEEDS, 40)
    assert causes(frame)
    assert found.machine.tripped
    away[0] = False
    assert_comes_to_rest(found, 0.5)


def test_a_drive_that_restarts_is_not_commanded_on() -> None:
    found = moving()
    found.rig.drives[1].restart()
    found.step(WinchMode.VELOCITY, SPEEDS, 2)
    assert "was restarted: open the machine again" in found.machine.tripped
    assert_comes_to_rest(found, 0.5)
    found.step(outputs={RESET: 1.0})
    assert found.machine.tripped


def test_a_fault_is_reset_by_an_order_alone_and_only_with_all_drives_disabled() -> None:
    found = moving()
    found.rig.drives[0].fail(0x4310)
    found.step(WinchMode.VELOCITY, SPEEDS, 50)
    found.step(WinchMode.HOLD, outputs={RESET: 1.0})
    assert found.machine.tripped
    assert found.rig.drives[0].state is PowerState.FAULT
    frame = found.step(outputs={RESET: 1.0})
    assert not causes(frame)
    assert all(drive.brake_closed for drive in found.rig.drives)
    found.step(WinchMode.VELOCITY)
    assert not any(drive.brake_closed for drive in found.rig.drives)


def test_winches_are_enabled_together_or_not_at_all() -> None:
    found = bench()
    found.machine.open()
    found.rig.drives[2].fail(0x3210)
    found.step(steps=2)
    found.step(WinchMode.VELOCITY)
    assert "0x3210" in found.machine.tripped
    assert all(drive.brake_closed for drive in found.rig.drives)
    mixed = bench()
    mixed.machine.open()
    mixed.step()
    modes = (WinchMode.OFF, *(WinchMode.VELOCITY,) * 3)
    from cablewright.foundation.signals import Command

    mixed.machine.step(Command(mixed.port.now(), np.zeros(4), modes=modes))
    assert all(drive.brake_closed for drive in mixed.rig.drives)


def test_brakes_open_under_torque_and_close_before_it_goes() -> None:
    """The load never moves when winches are enabled or switched off: less than the last digit of an encoder."""
    found = bench()
    found.machine.open()
    found.step()
    high = found.rig.plant.truth.position[2]
    found.step(WinchMode.VELOCITY)
    found.step(WinchMode.HOLD, steps=20)
    found.step(WinchMode.OFF, steps=50)
    assert abs(found.rig.plant.truth.position[2] - high) < 1e-4
    assert all(drive.brake_closed for drive in found.rig.drives)


def test_closing_a_machine_that_moves_stops_it_first() -> None:
    found = moving()
    found.machine.close()
    assert all(drive.brake_closed and drive.state is not PowerState.FAULT for drive in found.rig.drives)
    found.hang(2.0)
    assert not any(drive.state is PowerState.FAULT for drive in found.rig.drives)  # no node is missed any more


def test_a_mode_is_changed_at_rest_alone_and_its_speed_is_limited_in_the_drive() -> None:
    found = moving()
    found.step(WinchMode.TENSION, None, 60, tensions=np.full(4, 20.0))
    limit = found.drives.settings.tension_speed / found.drives.axes[0].scale.radii[1]
    rpm = limit * found.drives.axes[0].scale.ratio * 60.0 / (2.0 * np.pi)
    for drive in found.rig.drives:
        assert drive.dictionary[o.MODE] == o.Mode.TORQUE
        assert drive.dictionary[o.MAX_MOTOR_SPEED] <= rpm + 1
    speeds = np.abs([reading.velocities for frame in found.frames[-40:] for reading in frame.of(Drives)])
    assert np.nanmax(speeds) <= 1.05 * limit
    found.step(WinchMode.VELOCITY)
    assert all(drive.dictionary[o.MAX_MOTOR_SPEED] > 2000 for drive in found.rig.drives)


def test_a_tension_is_never_asked_over_that_of_the_file() -> None:
    found = moving()
    found.step(WinchMode.TENSION, None, 2, tensions=np.full(4, 1e6))
    most = found.drives.settings.tension * 0.05 / 114.75 / 0.5 * 1e3
    assert all(abs(drive.dictionary[o.TARGET_TORQUE]) <= most + 1 for drive in found.rig.drives)


def test_a_load_over_the_torque_limit_slips_and_is_braked() -> None:
    found = moving()
    for drive in found.rig.drives:
        drive.dictionary[o.MAX_TORQUE] = 50  # as if the load had grown
    found.step(WinchMode.VELOCITY, SPEEDS, 60)
    assert "0x8611 following error" in causes(found.frames[-1])
    assert all(drive.brake_closed for drive in found.rig.drives)


def wrong(change: Callable[[Bench], None], says: str, error: type[Exception] = InputError) -> None:
    found = bench()
    change(found)
    with pytest.raises(error, match=says):
        found.machine.open()
    assert all(drive.brake_closed for drive in found.rig.drives)


def test_drives_that_are_not_those_of_the_file_are_rejected() -> None:
    def dead(found: Bench) -> None:
        found.rig.drives[3].dead = True

    def profile(found: Bench) -> None:
        found.rig.drives[0].dictionary[o.DEVICE_TYPE] = 401

    def twice(found: Bench) -> None:
        found.rig.drives[1].node = found.rig.drives[0].node
        found.rig.drives[1].dictionary.node = found.rig.drives[0].node
        found.rig.drives[1].dictionary[o.SERIAL] = 77

    def modes(found: Bench) -> None:
        found.rig.drives[0].dictionary[o.SUPPORTED_MODES] = 1 << 8

    def motor(found: Bench) -> None:
        found.rig.drives[2].dictionary[o.RATED_TORQUE] = 500_000  # a unit that was mistaken

    def stubborn(found: Bench) -> None:
        found.rig.drives[2].dictionary.stubborn.add((o.QUICK_STOP_OPTION.index, 0))

    wrong(dead, "nodes.north-west.id = 4: no drive answers", EnvironmentFault)
    wrong(profile, "has the profile 401, not 402")
    wrong(twice, "two drives have this number")
    wrong(modes, "no cyclic synchronous torque")
    wrong(motor, "reports 500 N m")
    wrong(stubborn, "0x605A quick stop = 2, not 6 as it should be")


def test_a_second_master_is_rejected_and_one_that_comes_later_stops_the_machine() -> None:
    found = bench()
    found.port.inject(CanFrame(o.SYNC))
    with pytest.raises(EnvironmentFault, match="another master is on the bus: it sends SYNC"):
        found.machine.open()
    later = moving()
    later.port.inject(CanFrame(o.HEARTBEAT + 127, bytes([5])))
    frame = later.step(WinchMode.VELOCITY, SPEEDS, 2)
    assert "another master: it has the node 127" in causes(frame)
    assert_comes_to_rest(later, 0.5)


def test_parameters_that_changed_meanwhile_are_written_again_or_keep_it_off() -> None:
    found = moving()
    found.step(steps=50)
    for drive in found.rig.drives:
        drive.dictionary[o.FAULT_OPTION] = 0
        drive.dictionary[o.MAX_TORQUE] = 5000
    found.step(WinchMode.VELOCITY)
    assert all(drive.dictionary[o.FAULT_OPTION] == 2 for drive in found.rig.drives)
    found.step(steps=50)
    found.rig.drives[1].dictionary.entries[0x1A00, 1].data = bytes(4)  # another mapping
    found.step(WinchMode.VELOCITY)
    assert "mapped object" in found.machine.tripped
    assert all(drive.brake_closed for drive in found.rig.drives)


def test_the_limits_in_the_drives_are_those_of_robot_and_file() -> None:
    found = moving()
    winch = found.robot.lines[0].winch
    for drive, axis in zip(found.rig.drives, found.drives.axes, strict=True):
        low, high = axis.scale.radii
        turns = drive.dictionary[o.MAX_MOTOR_SPEED] / 60.0 / found.rig.ratio
        assert turns * 2.0 * np.pi * high == pytest.approx(winch.max_speed, rel=1e-3)
        torque = drive.dictionary[o.MAX_TORQUE] * 1e-3 * 0.5 * found.rig.ratio
        assert torque <= min(winch.max_torque, 2000.0 * low)
        assert drive.dictionary[o.QUICK_STOP_OPTION] == 6
        assert drive.dictionary[o.CONSUMER_HEARTBEAT] == 127 << 16 | 200


def test_tensions_are_those_of_the_lines_and_never_understated() -> None:
    found = moving()
    shown = found.step(WinchMode.HOLD, steps=30).of(Tensions)[0].tensions
    true = found.rig.plant.truth.tensions
    assert (shown > 0.99 * true).all()
    assert (shown < 1.2 * true).all()


@pytest.mark.parametrize("line", range(4))
def test_a_winch_that_drifts_unknown_to_its_drive_is_stopped(line: int) -> None:
    found = moving()
    found.step(WinchMode.HOLD, steps=20)
    found.rig.drives[line].drift = 0.05 / 0.055 * found.rig.per_radian  # 50 mm/s
    before = found.rig.plant.rig.winches.lengths_out()
    found.step(WinchMode.HOLD, steps=200)
    assert f"{found.rig.names[line]}: its winch is 2" in found.machine.tripped
    assert np.abs(found.rig.plant.rig.winches.lengths_out() - before).max() < 0.05
    assert all(drive.brake_closed for drive in found.rig.drives)


def test_a_counter_that_wraps_is_no_jump() -> None:
    found = bench()
    found.machine.open()
    found.rig._base += (1 << 31) - 2000.0
    found.step(steps=3)
    found.step(WinchMode.VELOCITY)
    found.step(WinchMode.VELOCITY, SPEEDS, 60)
    found.step(WinchMode.VELOCITY, -np.array(SPEEDS), 120)
    assert not found.machine.tripped
    counts = np.array([reading.counts for frame in found.frames for reading in frame.of(Encoders)])
    assert counts.min() < -(1 << 30) < 1 << 30 < counts.max()


def test_stopping_brakes_by_the_ramps_of_the_drives_and_never_cuts_the_torque() -> None:
    found = moving()
    words: list[int] = []
    send = found.port.send

    def watched(frame: CanFrame) -> None:
        if frame.id & 0x780 == o.CONTROL_PDO:
            words.append(int.from_bytes(frame.data[:2], "little"))
        send(frame)

    found.port.send = watched  # type: ignore[method-assign]
    found.machine.stop()
    assert all(drive.brake_closed for drive in found.rig.drives)
    assert set(words) <= {0x07, 0x06}  # disable operation, shutdown; neither disable voltage nor quick stop
