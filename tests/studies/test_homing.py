"""Homing on virtual drives: lengths that are right pass, wrong ones are refused, with the line as far as it shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.signals import Order, OrderKind, PrintState
from cablewright.studies.drives.session import RealMachine, SessionOperator, Watching, still_path
from cablewright.studies.prints import loop
from virtual_drives import RING_BEGIN, Bench, bench


def real(found: Bench, folder: Path) -> RealMachine:
    return RealMachine.of(found.robot, found.twin.owner, folder / "machine", lambda: found.port)


def home(found: Bench, folder: Path, place: np.ndarray | None = None) -> tuple[RealMachine, SessionOperator, float]:
    """Home it; also returns how far off the position is that was found, m."""
    on = real(found, folder)
    homing = on.homing(np.array(RING_BEGIN["merlet2023"]), place)
    printer = on.printer(still_path(found.robot, None), "model", {PrintState.HOMING: homing})
    operator = SessionOperator("anna", Order(OrderKind.HOME))
    loop.run(printer, operator, Watching())
    position = homing.position
    off = np.nan if position is None else float(np.linalg.norm(position - found.rig.plant.truth.position))
    return on, operator, off


def test_a_place_that_a_person_measured_begins_it_and_its_lengths_are_kept(tmp_path: Path) -> None:
    found = bench()
    _, refused, _ = home(found, tmp_path)
    assert "no valid lengths are saved: measure where the platform is" in refused.reason
    _, first, off = home(found, tmp_path, found.rig.plant.truth.position)
    assert first.reason == ""
    assert off < 0.01
    assert all(drive.brake_closed for drive in found.rig.drives)
    _, again, off = home(found, tmp_path)  # after a loss of power, by what was saved
    assert again.reason == ""
    assert off < 0.01


@pytest.mark.parametrize("line", range(4))
def test_a_line_that_was_moved_by_hand_without_power_is_found(line: int, tmp_path: Path) -> None:
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    name = found.rig.names[line]
    found.rig.turn_by_hand(name, 0.05)
    _, operator, _ = home(found, tmp_path)
    print(operator.reason)
    assert "the lengths do not fit together" in operator.reason
    assert f"{name} by " in operator.reason


def test_a_wrong_direction_is_said_before_anything_is_pulled(tmp_path: Path) -> None:
    found = bench(rig={"reversed_lines": ("south-east",)})
    _, operator, _ = home(found, tmp_path, np.array(RING_BEGIN["merlet2023"]))
    assert "line south-east pulls with -" in operator.reason
    assert "its direction in the machine file is wrong" in operator.reason
