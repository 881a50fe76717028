"""Homing on virtual drives: lengths that are right pass, wrong ones are refused, with the line as far as it shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.errors import AnswerError
from cablewright.signals import Order, OrderKind, PrintState
from cablewright.studies.drives.session import RealMachine, SessionOperator, Watching, still_path
from cablewright.studies.prints import loop
from virtual_drives import RING_BEGIN, Bench, bench


def real(found: Bench, folder: Path) -> RealMachine:
    folder.mkdir(exist_ok=True)
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
    assert "the lengths do not fit together" in operator.reason
    assert f"it is line {name} by -5" in operator.reason  # after three poses: none of the other three


def test_a_wrong_direction_is_said_before_anything_is_pulled(tmp_path: Path) -> None:
    found = bench(rig={"reversed_lines": ("south-east",)})
    _, operator, _ = home(found, tmp_path, np.array(RING_BEGIN["merlet2023"]))
    assert "line south-east pulls with -" in operator.reason
    assert "its direction in the machine file is wrong" in operator.reason


def case(seed: int, folder: Path, *, wrong: bool) -> tuple[str, str]:
    """Home a machine as built by *seed* at a random place, with a line moved by 30 mm or more, or right.

    Returns why it was refused, and the line's name.
    """
    random = np.random.default_rng([seed, 31])
    found = None
    while found is None:
        place = random.uniform((-1.0, -2.5, 0.8), (1.0, 2.5, 1.6))
        try:
            found = bench(rig={"seed": seed}, begin=tuple(place))
        except AnswerError:  # no equilibrium there
            continue
    home(found, folder, found.rig.plant.truth.position + random.normal(0.0, 2e-3, 3))  # measured to 2 mm
    line = found.rig.names[int(random.integers(4))]
    if wrong:
        found.rig.turn_by_hand(line, float(random.choice((-1.0, 1.0)) * random.uniform(0.03, 0.12)))
    _, operator, _ = home(found, folder)
    return operator.reason, line


@pytest.mark.parametrize("seed", range(2))
def test_what_is_wrong_is_refused_and_what_is_right_passes(seed: int, tmp_path: Path) -> None:
    reason, line = case(seed, tmp_path, wrong=True)
    assert f"{line} by " in reason
    assert case(seed, tmp_path / "right", wrong=False)[0] == ""


@pytest.mark.slow
def test_of_20_wrong_ones_20_are_refused_and_of_20_right_ones_20_pass(tmp_path: Path) -> None:
    wrong = [case(100 + seed, tmp_path / f"w{seed}", wrong=True) for seed in range(20)]
    right = [case(100 + seed, tmp_path / f"r{seed}", wrong=False) for seed in range(20)]
    named = sum(f"{line} by " in reason for reason, line in wrong)
    alone = sum(f"it is line {line} by " in reason for reason, line in wrong)
    other = sum("it is line " in reason for reason, _ in wrong) - alone
    print(f"{alone} named alone, {other} named another line")
    print(
        f"{sum(bool(reason) for reason, _ in wrong)} of 20 refused, {named} with the line among the candidates; "
        f"{sum(not reason for reason, _ in right)} of 20 accepted"
    )
    assert all(reason for reason, _ in wrong)
    assert all(f"{line} by " in reason or "following error" in reason for reason, line in wrong)  # or overloaded
    assert not any(reason for reason, _ in right)
    assert not other
    assert alone >= 12
