"""What the computer watches beside the drives: creep, speeds under torque, the order of limits and modes, inputs."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.signals import Command, Inputs, WinchMode
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.objects import Mode
from virtual_drives import SPEEDS, Bench, bench, braked, moving


@pytest.mark.parametrize("speed", [3e-3, 15e-3, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_a_held_winch_that_creeps_is_seen_however_slow_it_is(speed: float) -> None:
    found = moving()
    found.step(WinchMode.HOLD, steps=20)
    drive, limit = found.rig.drives[2], found.drives.settings.following_error
    drive.drift = found.rig.signs[2] * speed / 0.05 * found.rig.per_radian
    before = found.rig.plant.rig.winches.lengths_out()[2]
    found.step(WinchMode.HOLD, steps=round(1.3 * limit / speed / found.machine.period))
    assert "north-east: its winch is 20 mm from where it was commanded" in found.machine.tripped
    assert abs(found.rig.plant.rig.winches.lengths_out()[2] - before) < 1.25 * limit
    assert braked(found)


def test_a_winch_whose_speed_is_a_little_off_is_not_stopped_while_it_moves() -> None:
    found = moving()
    for drive in found.rig.drives:
        drive.speed_unit *= 1.01
    for k in range(400):
        found.step(WinchMode.VELOCITY, np.cos(0.02 * k) * np.array(SPEEDS))
    assert not found.machine.tripped


def test_cycles_stay_equal_after_days() -> None:
    """Nothing adds up: twelve days after the bus began, when a clock has ten digits left behind the period."""
    found = bench()
    found.rig.ticks = 500_000_000
    found.machine.open()
    found.step(steps=3)
    found.step(WinchMode.VELOCITY)
    times = []
    for _ in range(400):
        found.step(WinchMode.VELOCITY, SPEEDS)
        times.append(found.port.now())
    assert not found.machine.tripped
    assert np.diff(times) == pytest.approx(np.full(399, found.machine.period), abs=1e-8)


def under_torque(found: Bench, steps: int, tension: float = 20.0) -> None:
    """One winch under torque, the others held."""
    modes = (WinchMode.HOLD, WinchMode.TENSION, WinchMode.HOLD, WinchMode.HOLD)
    tensions = np.array([np.nan, tension, np.nan, np.nan])
    for _ in range(steps):
        command = Command(found.port.now(), np.zeros(4), modes=modes, tensions=tensions)
        found.frames.append(found.machine.step(command))


@pytest.mark.parametrize("slow", [0.0, 0.15])
def test_a_speed_limit_goes_after_torque_mode_and_comes_before_it(slow: float) -> None:
    """Whatever time the answers of drives take: no drive is in torque mode with the speed limit of a winch."""
    late = [0.0]
    found = moving(disturb=lambda frame, _now: (late[0],) if frame.id & 0x780 == o.SDO_ANSWER else (0.0,))
    late[0] = slow
    drive, seen, advance = found.rig.drives[1], set[tuple[int, bool]](), found.rig.advance

    def watched(now: float | None = None) -> list[CanFrame]:
        said = advance(now)
        seen.add((drive.dictionary[o.MODE], drive.dictionary[o.MAX_MOTOR_SPEED] > 1000))
        return said

    found.rig.advance = watched  # type: ignore[method-assign]
    under_torque(found, 20)
    found.step(WinchMode.HOLD, steps=5)
    assert not found.machine.tripped
    assert seen == {(Mode.VELOCITY, True), (Mode.VELOCITY, False), (Mode.TORQUE, False)}


def test_a_drive_that_does_not_limit_its_speed_under_torque_is_stopped() -> None:
    """It stores 0x6080 and does not heed it in this mode; the line would let its load down at full speed."""
    found = moving()
    found.step(WinchMode.HOLD, steps=30)
    drive, limited = found.rig.drives[1], found.rig.drives[1]._move

    def unlimited(dt: float) -> None:
        entry = drive.dictionary.entries[o.MAX_MOTOR_SPEED.index, 0]
        kept, entry.data = entry.data, (6000).to_bytes(4, "little")
        limited(dt)
        entry.data = kept

    drive._move = unlimited  # type: ignore[method-assign]
    before = found.rig.plant.rig.winches.lengths_out()
    under_torque(found, 60)
    assert "south-east: its winch moved" in found.machine.tripped
    assert "beyond its speed limit under torque, 0.02 m/s" in found.machine.tripped
    assert braked(found)
    assert np.abs(found.rig.plant.rig.winches.lengths_out() - before).max() < 0.04


def test_trouble_on_the_bus_is_seen_before_anything_is_enabled() -> None:
    found = moving()
    found.step(WinchMode.OFF, steps=60)
    found.port.inject(CanFrame(o.SYNC))
    states, advance = set(), found.rig.advance

    def watched(now: float | None = None) -> list[CanFrame]:
        said = advance(now)
        states.update(drive.state.value for drive in found.rig.drives)
        return said

    found.rig.advance = watched  # type: ignore[method-assign]
    found.step(WinchMode.OFF)
    found.step(WinchMode.VELOCITY)
    assert "another master" in found.machine.tripped
    assert states == {"ready to switch on"}


BITS = {"chain": 17, "brake": 16, "enabling": 17, "torque_on": 17}


def test_inputs_that_are_not_known_are_not_those_of_before() -> None:
    """One answer that is lost makes nothing up; after `answer_timeout` all that is not known counts as not safe."""
    away = [0]

    def disturb(frame: CanFrame, _now: float) -> tuple[float, ...]:
        if away[0] > 0 and frame.id == o.INPUT_PDO + 2:
            away[0] -= 1
            return ()
        return (0.0,)

    found = moving(disturb=disturb, inputs=BITS)
    known = found.step(WinchMode.HOLD).of(Inputs)[0]
    assert (known.chain_closed, known.torque_off, known.enabling, any(known.brakes_closed)) == (
        True,
        False,
        True,
        False,
    )
    away[0] = 1
    assert not found.step(WinchMode.HOLD).of(Inputs)
    assert found.step(WinchMode.HOLD).of(Inputs)[0].chain_closed
    away[0] = 1000
    told = [frame.of(Inputs) for frame in (found.step(WinchMode.OFF) for _ in range(20))]
    assert not told[2]
    last = told[-1][0]
    assert (last.chain_closed, last.torque_off, last.enabling) == (False, True, False)
    assert last.brakes_closed[1] is False
