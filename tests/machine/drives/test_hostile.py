"""Sequences that could hurt somebody: hosts that end at any moment, wrong signs and units, late frames, brakes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Condition, WinchMode
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.cia402 import PowerState
from cablewright.machine.interface import RESET
from cablewright.machine.simulated.unmodelled.effect_sizes import WinchBrakes
from cases import some
from virtual_drives import SPEEDS, Bench, bench, braked, moving


class GoneError(Exception):
    """The host has ended."""


def whole_life(found: Bench) -> None:
    """Open, reset, enable, move, pull, hold, brake, enable again, and close."""
    found.machine.open()
    found.step(steps=25)
    found.step(outputs={RESET: 1.0})
    found.step(WinchMode.VELOCITY)
    found.step(WinchMode.VELOCITY, SPEEDS, 20)
    found.step(WinchMode.HOLD, steps=10)
    found.step(WinchMode.TENSION, None, 10, tensions=np.full(4, 300.0))
    found.step(WinchMode.HOLD, steps=5)
    found.step(steps=40)
    found.step(WinchMode.VELOCITY, SPEEDS, 20)
    found.machine.close()


def sent_in_a_life() -> int:
    found, sent = bench(), [0]
    send = found.port.send

    def counted(frame: CanFrame) -> None:
        sent[0] += 1
        send(frame)

    found.port.send = counted  # type: ignore[method-assign]
    whole_life(found)
    return sent[0]


SHARES = np.linspace(0.02, 0.999, 24).tolist()


@pytest.fixture(scope="module")
def frames() -> int:
    return sent_in_a_life()


@pytest.mark.parametrize("share", [*SHARES[::2], *some(SHARES[1::2], 0)])
def test_a_host_that_ends_between_any_two_frames_leaves_all_braked(share: float, frames: int) -> None:
    """Killed after a share of all frames that it sends: drives stop and brake, and nothing falls or strains."""
    found, left = bench(), [round(share * frames)]
    send, step, pulls = found.port.send, found.rig.plant.step, [0.0]

    def ending(frame: CanFrame) -> None:
        if left[0] <= 0:
            raise GoneError
        left[0] -= 1
        send(frame)

    def watched(command):  # type: ignore[no-untyped-def]
        told = step(command)
        pulls.append(float(found.rig.plant.truth.tensions.max()))
        return told

    found.port.send, found.rig.plant.step = ending, watched  # type: ignore[method-assign]
    with pytest.raises(GoneError):
        whole_life(found)
    place = found.rig.plant.truth.position
    found.hang(1.5)
    assert braked(found)
    assert max(pulls) < 900.0  # of 2000 N that are allowed
    assert np.linalg.norm(found.rig.plant.truth.position - place) < 0.05
    angles = found.rig.plant.rig.winches.angles
    found.hang(1.0)
    assert np.abs(found.rig.plant.rig.winches.angles - angles).max() < 1e-6


@pytest.mark.parametrize("line", range(4))
def test_an_encoder_of_the_wrong_sign_is_seen_in_the_first_centimetres(line: int) -> None:
    found = bench()
    axis = found.drives.axes[line]
    axis.scale = replace(axis.scale, counts=-axis.scale.counts)
    found.machine.open()
    found.step(steps=25)
    found.step(WinchMode.VELOCITY)
    before = found.rig.plant.rig.winches.lengths_out()
    found.step(WinchMode.VELOCITY, SPEEDS, 100)
    assert f"{found.rig.names[line]}: its winch is" in found.machine.tripped
    assert np.abs(found.rig.plant.rig.winches.lengths_out() - before).max() < 0.025
    assert braked(found)


@pytest.mark.parametrize("factor", [60.0, 1.0 / 60.0])
def test_a_unit_of_speed_that_was_mistaken_is_seen_within_the_following_error(factor: float) -> None:
    """Of turns a minute for turns a second: limited by the drive's own speed limit, and stopped."""
    found = bench()
    for drive in found.rig.drives:
        drive.speed_unit /= factor
    found.machine.open()
    found.step(steps=25)
    found.step(WinchMode.VELOCITY)
    before = found.rig.plant.rig.winches.lengths_out()
    found.step(WinchMode.VELOCITY, 0.1 * np.array(SPEEDS), 900)
    assert "from where it was commanded" in found.machine.tripped
    assert np.abs(found.rig.plant.rig.winches.lengths_out() - before).max() < 0.06
    assert braked(found)


def test_an_encoder_with_other_counts_is_rejected_and_never_overwritten() -> None:
    found = bench()
    found.rig.drives[3].dictionary[o.COUNTS] = 4096
    with pytest.raises(InputError, match="0x608F:1 encoder increments = 4096, not 1024 as it should be"):
        found.machine.open()
    assert found.rig.drives[3].dictionary[o.COUNTS] == 4096


@pytest.mark.parametrize("late", [0.012, 0.05, 0.15, 0.3])
def test_a_command_that_comes_late_after_off_opens_no_brake(late: float) -> None:
    """The last commands to move overtake nothing: whenever they come, the next one disables again."""
    after = [False]

    def disturb(frame: CanFrame, now: float) -> tuple[float, ...]:
        return (0.0, late) if after[0] and frame.id & 0x780 == o.CONTROL_PDO else (0.0,)

    found = moving(disturb=disturb)
    after[0] = True
    found.step(WinchMode.VELOCITY, SPEEDS)
    after[0] = False
    before = found.rig.plant.rig.winches.angles
    found.step(WinchMode.OFF, steps=100)
    assert braked(found)
    assert np.abs(found.rig.plant.rig.winches.angles - before).max() < 0.5 * 0.1


def test_a_brake_that_slips_under_a_load_is_said() -> None:
    """Nothing is switched on by itself: that takes a person, who secures the load first."""
    found = moving()
    found.step(WinchMode.HOLD, steps=10)
    found.step(WinchMode.OFF, steps=60)
    assert not found.machine.tripped
    for _ in range(200):
        found.rig._base[2] += (
            found.rig.signs[2] * 0.0002 / 0.05 * found.rig.per_radian
        )  # 20 mm/s, as its encoder reports
        frame = found.step(WinchMode.OFF)
    assert "north-east: its winch is 20 mm" in found.machine.tripped
    assert "which its brake should hold: secure the load" in found.machine.tripped
    assert any(notice.condition is Condition.BRAKE for notice in frame.notices)
    assert all(drive.state is PowerState.READY for drive in found.rig.drives)
    found.step(outputs={RESET: 1.0})
    assert not found.machine.tripped


def test_brakes_of_the_plant_that_give_are_seen_by_the_counts() -> None:
    """Counts of the drives' own encoders are the length paid out; with brakes that hold it is nothing."""
    for torque, slips in ((0.0, False), (1e4, False), (15.0, True)):
        found = moving(brakes=WinchBrakes(torque=torque))
        found.step(WinchMode.HOLD, steps=10)
        rest = found.rig.plant.truth.lengths
        notices = [n for _ in range(300) for n in found.step(WinchMode.OFF).notices]
        assert braked(found)
        told = [n.subject for n in notices if n.condition is Condition.BRAKE]
        away = found.rig.plant.truth.lengths.max() - rest.max()
        assert bool(told) == slips == (away > 0.02) == bool(found.machine.tripped)
        if slips:
            assert "its winch is 2" in told[0]
            assert "which its brake should hold: secure the load" in told[0]


def test_two_that_begin_at_the_same_time_both_reject() -> None:
    """Each hears the other's first request."""
    found = bench()
    send = found.port.send
    asked: list[int] = []

    def both(frame: CanFrame) -> None:
        send(frame)
        if frame.id & 0x780 == o.SDO_REQUEST and not asked:
            asked.append(frame.id)
            found.port.inject(CanFrame(o.SDO_REQUEST + 2, bytes(8)))

    found.port.send = both  # type: ignore[method-assign]
    with pytest.raises(Exception, match="another master is on the bus: it sends requests for objects"):
        found.machine.open()
    assert braked(found)


def test_a_load_that_swings_while_it_is_stopped_keeps_within_the_limits() -> None:
    """All winches at full speed, then off: by ramps of the drives, which do not know of each other."""
    for how in ("stop", "fault", "off"):
        found = moving()
        speeds = 3.6 * np.array(SPEEDS) / np.abs(SPEEDS).max() * 0.9
        for share in np.linspace(0.1, 1.0, 30):
            found.step(WinchMode.VELOCITY, share * speeds)
        pulls, step = [0.0], found.rig.plant.step

        def watched(command, pulls=pulls, step=step, found=found):  # type: ignore[no-untyped-def]
            told = step(command)
            pulls.append(float(found.rig.plant.truth.tensions.max()))
            return told

        found.rig.plant.step = watched  # type: ignore[method-assign]
        if how == "stop":
            found.machine.stop()
        else:
            if how == "fault":
                found.rig.drives[0].fail(0x2310)
            found.step(WinchMode.OFF, steps=80)
        assert braked(found)
        assert max(pulls) < 2000.0, how
