"""The nozzle's valve, an output of a drive, in virtual time: open while it is ordered, shut whatever goes wrong."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import WinchMode
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.settings import WinchDriveSettings
from virtual_drives import SPEEDS, Bench, bench, moving, virtual_twin

LINE, BIT = "south-east", 19
CLOSES = {"line": LINE, "bit": BIT, "closes_alone": True}
KEEPS = {**CLOSES, "closes_alone": False}


def pouring(**valve: object) -> Bench:
    """A machine that moves with its valve open."""
    found = moving(valve=valve or CLOSES)
    assert not found.rig.valve_open
    found.step(WinchMode.VELOCITY, SPEEDS, 20, valve=1.0)
    assert found.rig.valve_open
    return found


def test_powder_leaves_the_drum_while_it_is_ordered_to() -> None:
    found = moving(valve=CLOSES)
    before = found.rig.plant.truth.powder
    found.step(WinchMode.VELOCITY, SPEEDS, 100, valve=0.4)  # of a valve that is open or shut: less than half is shut
    assert found.rig.plant.truth.powder == before
    found.step(WinchMode.VELOCITY, SPEEDS, 100, valve=0.5)
    flow = found.twin.owner.point_drum.flow
    assert before - found.rig.plant.truth.powder == pytest.approx(flow, rel=0.03)  # in 1 s, two cycles late at most
    found.step(WinchMode.VELOCITY, SPEEDS, 2)
    assert not found.rig.valve_open


def test_no_other_output_and_no_other_drive_is_touched() -> None:
    found = pouring()
    for name, drive in zip(found.rig.names, found.rig.drives, strict=True):
        assert drive.dictionary[o.OUTPUT_MASK] == (1 << BIT if name == LINE else 0)
        assert drive.dictionary[o.OUTPUTS] == (1 << BIT if name == LINE else 0)


def tripped(found: Bench) -> None:
    found.rig.drives[0].fail(0x2310)


def stopped(found: Bench) -> None:
    found.machine.stop()


def another_is_silent(found: Bench) -> None:
    found.rig.drives[3].dead = True
    found.step(WinchMode.VELOCITY, SPEEDS, 10, valve=1.0)


def own_stop_input(found: Bench) -> None:
    found.rig.drives[1].stop_input = True


def mode_changes(found: Bench) -> None:
    shut = []
    cycle = found.drives.cycle

    def watched(*args, **kwargs):  # type: ignore[no-untyped-def]
        shut.append(not any(each.valve for each in args[0]))
        return cycle(*args, **kwargs)

    found.drives.cycle = watched  # type: ignore[method-assign]
    found.step(WinchMode.TENSION, valve=1.0, tensions=[20.0] * 4)
    assert all(shut[:-1])
    found.step(WinchMode.HOLD)


@pytest.mark.parametrize("what", [tripped, stopped, another_is_silent, own_stop_input, mode_changes])
def test_it_is_shut_in_every_stop(what: Callable[[Bench], None]) -> None:
    found = pouring()
    what(found)
    for _ in range(2):
        found.step(WinchMode.OFF if what is stopped else WinchMode.VELOCITY, None if what is stopped else SPEEDS)
    assert not found.rig.valve_open


def test_a_drive_that_closes_alone_shuts_it_when_the_host_hangs() -> None:
    found = pouring()
    found.hang(0.2)
    assert not found.rig.valve_open
    found.step(WinchMode.VELOCITY, SPEEDS, 3, valve=1.0)  # what was ordered before is not sent any more
    assert not found.rig.valve_open
    assert found.rig.drives[1].dictionary[o.OUTPUTS] == 0


def test_one_that_does_not_leaves_it_open_until_the_host_is_back() -> None:
    found = pouring(**KEEPS)
    found.hang(0.5)
    assert found.rig.valve_open
    found.step(WinchMode.VELOCITY, SPEEDS, 2, valve=1.0)
    assert not found.rig.valve_open


def test_a_valve_that_was_left_open_is_shut_before_anything_is_enabled() -> None:
    found = bench(valve=KEEPS)
    drive = found.rig.drives[1]
    drive.dictionary[o.OUTPUTS] = drive.dictionary[o.OUTPUT_MASK] = 1 << BIT
    assert found.rig.valve_open
    found.machine.open()
    assert not found.rig.valve_open


def test_a_drive_without_that_output_stays_off() -> None:
    found = bench(valve=CLOSES)
    found.rig.drives[1].dictionary.stubborn.add((o.OUTPUT_MASK.index, o.OUTPUT_MASK.sub))
    with pytest.raises(InputError, match=r"line south-east \(node 2\): 0x60FE:2 digital outputs: mask = 0, not 524288"):
        found.machine.open()


def test_a_valve_of_a_line_without_a_drive_is_rejected() -> None:
    table = virtual_twin().owner.drives
    assert isinstance(table, WinchDriveSettings)
    with pytest.raises(ValueError, match=r"has no drive in drives\.nodes"):
        virtual_twin(valve={**CLOSES, "line": "east"})


def test_the_machine_knows_no_valve_that_the_file_does_not_name() -> None:
    found = moving()
    assert isinstance(found.machine, DriveMachine)
    found.step(WinchMode.VELOCITY, SPEEDS, 20, valve=1.0)
    assert not found.rig.valve_open
    assert [each.dictionary[o.OUTPUTS] for each in found.rig.drives] == [0] * 4


def test_a_person_beside_the_drives_fills_the_drum() -> None:
    found = pouring()
    plant, full = found.rig.plant, found.twin.owner.carrier.powder
    found.step(WinchMode.VELOCITY, SPEEDS, 100, valve=1.0)
    emptier = plant.truth.powder
    found.rig.refill()
    assert emptier < plant.truth.powder == pytest.approx(full, rel=0.05)  # as weighed
