"""Homing on virtual drives: lengths that are right pass, wrong ones are rejected, with the line as far as it shows."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.drives import actions
from cablewright.live.drives.session import RealMachine, SessionOperator, Watching, session_path
from cablewright.live.prints import loop
from cablewright.robot.cable import Creep
from cases import some
from virtual_drives import RING_BEGIN, Bench, bench


def real(found: Bench, folder: Path) -> RealMachine:
    folder.mkdir(exist_ok=True)
    return RealMachine.of(found.robot, found.twin.owner, folder / "machine", lambda: found.port)


def home(found: Bench, folder: Path, place: np.ndarray | None = None) -> tuple[RealMachine, SessionOperator, float]:
    """Home it; also returns the error of the resulting position, m."""
    on = real(found, folder)
    homing = on.homing(np.array(RING_BEGIN["merlet2023"]), place)
    printer = on.printer(session_path(found.robot, None), "model", {PrintState.HOMING: homing})
    operator = SessionOperator("anna", Order(OrderKind.HOME))
    loop.run(printer, operator, Watching())
    position = homing.pose
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
    _, again, off = home(found, tmp_path)  # after a loss of power, by saved lengths
    assert again.reason == ""
    assert off < 0.01


@pytest.mark.parametrize("line", [pytest.param(0, marks=pytest.mark.slow), 3])
def test_a_line_that_was_moved_by_hand_without_power_is_found(line: int, tmp_path: Path) -> None:
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    name = found.rig.names[line]
    found.rig.turn_by_hand(name, 0.05)
    _, operator, _ = home(found, tmp_path)
    assert "the lengths do not fit together" in operator.reason
    assert f"it is line {name} by -5" in operator.reason  # after three poses: none of the other three


@pytest.mark.parametrize("line", some(["south-west", "south-east", "north-east", "north-west"]))
def test_a_wrong_direction_is_said_before_anything_is_pulled(line: str, tmp_path: Path) -> None:
    found = bench(rig={"reversed_lines": (line,)})
    _, operator, _ = home(found, tmp_path, np.array(RING_BEGIN["merlet2023"]))
    assert f"line {line} pulls with -" in operator.reason
    assert "its direction in the machine file is wrong" in operator.reason


PLACE = np.array(RING_BEGIN["merlet2023"])


def test_lengths_of_before_a_kill_in_motion_never_come_back(tmp_path: Path) -> None:
    """Whatever commands end in good order meanwhile: the counts are of another epoch than the lengths."""
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    file = tmp_path / "machine.counts.json"
    file.write_text(file.read_text().replace("true", "false"))  # killed while winches turned, then out of power
    for _ in range(3):
        elsewhere = bench(begin=(-0.3, 0.4, 1.6))
        _, refused, _ = home(elsewhere, tmp_path)
        assert "no valid lengths are saved" in refused.reason
        assert json.loads(file.read_text())["valid"]


def test_winches_turned_without_counting_are_homed_by_a_measured_place_alone(tmp_path: Path) -> None:
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    found.rig._base[1] += 4000.0  # an absolute encoder saw it
    found.rig._load()
    _, refused, _ = home(found, tmp_path)
    assert "no valid lengths are saved" in refused.reason


@pytest.mark.parametrize(
    "way",
    [(-0.7, 0.5, 0.0), *(pytest.param(each, marks=pytest.mark.slow) for each in ((-1.4, 1.0, 0.0), (0.0, 0.0, 1.5)))],
)
def test_a_place_that_was_typed_wrong_is_not_believed(way: tuple[float, ...], tmp_path: Path) -> None:
    on, operator, _ = home(bench(), tmp_path, PLACE + way)
    assert "the tensions do not fit the place" in operator.reason
    assert "at most 59 N is allowed (drives.tension_error)" in operator.reason
    assert on.keeper.found is None
    assert not (tmp_path / "machine.lengths.json").exists()


def test_a_place_outside_the_frame_is_rejected_before_the_bus_is_opened(tmp_path: Path) -> None:
    found = bench()
    for place, says in (((700.0, -500.0, 1000.0), "x = 700 m"), ((0.7, -0.5, -3.0), "z = -3 m")):
        with pytest.raises(InputError, match=f"place: {says}: is outside the frame of merlet2023"):
            actions.home(found.robot, found.twin.owner, tmp_path / "m", np.array(place), lambda: found.port)
    assert found.rig.now == 0.0


def test_lengths_that_fit_together_elsewhere_are_rejected_by_the_tensions(tmp_path: Path) -> None:
    """All drums were turned without power, and all lines are taut: no misfit, but another pull."""
    home(bench(), tmp_path, PLACE)
    sunk = bench(begin=(0.7, -0.5, 0.2))
    _, operator, _ = home(sunk, tmp_path)
    assert "the tensions do not fit the place 0.70, -0.50, 1.00 m" in operator.reason


def test_a_measured_place_replaces_saved_lengths_and_says_what_they_said(tmp_path: Path) -> None:
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    found.rig.turn_by_hand("south-west", 0.05)
    place = found.rig.plant.truth.position
    answer = actions.home(found.robot, found.twin.owner, tmp_path / "machine", place, lambda: found.port)
    assert answer.status == "done", answer.reason
    assert any("the saved lengths contradict the measured place" in note for note in answer.notes)
    assert any("south-west +5" in note for note in answer.notes)
    assert any(note.startswith("not tested: the measured place, by less than") for note in answer.notes)
    again = actions.home(found.robot, found.twin.owner, tmp_path / "machine", None, lambda: found.port)
    assert again.status == "done", again.reason
    assert again.notes[-1].startswith("not tested: lengths that are wrong together")
    law = Creep(logarithmic=1e-7)
    lines = (ln.model_copy(update={"cable": ln.cable.model_copy(update={"creep": law})}) for ln in found.robot.lines)
    crept = found.robot.model_copy(update={"lines": tuple(lines)})
    third = actions.home(crept, found.twin.owner, tmp_path / "machine", None, lambda: found.port)
    assert third.notes[-1].startswith("not counted: creep of cables")


def test_a_loss_of_power_is_survived_and_reported(tmp_path: Path) -> None:
    found = bench()
    home(found, tmp_path, found.rig.plant.truth.position)
    path = tmp_path / "machine"
    actions.jog_winch(found.robot, found.twin.owner, path, "south-west", 0.02, *held(40), lambda: found.port)
    counts = found.rig._base + found.rig.signs * found.rig.plant.rig.winches.counts
    assert abs(counts[0]) > 1000
    found.rig._base -= counts  # counters begin at zero with the power
    found.rig._load()
    answer = actions.home(found.robot, found.twin.owner, path, None, lambda: found.port)
    assert answer.status == "done", answer.reason
    assert "the counters were reset" in answer.notes[0]
    assert np.linalg.norm(np.array(answer.position) - found.rig.plant.truth.position) < 0.01


@pytest.mark.parametrize(
    ("pair", "place"),
    some([(("south-west", "south-east"), (0.0, -0.5, 1.0)), (("south-west", "north-west"), (0.7, -0.5, 1.0))]),
)
def test_two_drives_with_the_nodes_of_each_other_are_found_before_the_platform_goes_astray(
    pair: tuple[str, str], place: tuple[float, float, float], tmp_path: Path
) -> None:
    """By symmetry homing cannot see it there; the first centimetres of a motion can, as the pulls do not follow."""
    found, path = bench(begin=place), tmp_path / "machine"
    drives = found.twin.owner.drives
    nodes = dict(drives.nodes)
    nodes[pair[0]], nodes[pair[1]] = nodes[pair[1]], nodes[pair[0]]
    owner = found.twin.owner.model_copy(update={"drives": drives.model_copy(update={"nodes": nodes})})
    assert actions.home(found.robot, owner, path, np.array(place), lambda: found.port).status == "done"
    begin = found.rig.plant.truth.position
    velocity = (0.05, 0.0, 0.0)
    answer = actions.jog_platform(found.robot, owner, path, velocity, *held(1500), lambda: found.port)
    assert "the tensions do not fit the place" in answer.reason
    assert np.linalg.norm(found.rig.plant.truth.position - begin) < 0.05
    assert all(drive.brake_closed for drive in found.rig.drives)


def held(steps: int) -> tuple[Callable[[], bool], Callable[[], bool]]:
    """A button that is held for some steps, and all ends later."""
    left = [steps]

    def pressed() -> bool:
        left[0] -= 1
        return left[0] > 0

    return pressed, lambda: left[0] < -150


def case(seed: int, folder: Path, *, wrong: bool) -> tuple[str, str]:
    """Home a machine as built by *seed* at a random place, with a line moved by 30 mm or more, or right.

    Returns why it was rejected, and the line's name.
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


@pytest.mark.slow
def test_what_is_wrong_is_rejected_and_what_is_right_passes(tmp_path: Path) -> None:
    reason, line = case(1, tmp_path, wrong=True)
    assert f"{line} by " in reason
    assert case(1, tmp_path / "right", wrong=False)[0] == ""


@pytest.mark.slow
def test_of_20_wrong_ones_20_are_rejected_and_of_20_right_ones_20_pass(tmp_path: Path) -> None:
    wrong = [case(100 + seed, tmp_path / f"w{seed}", wrong=True) for seed in range(20)]
    right = [case(100 + seed, tmp_path / f"r{seed}", wrong=False) for seed in range(20)]
    named = sum(f"{line} by " in reason for reason, line in wrong)
    alone = sum(f"it is line {line} by " in reason for reason, line in wrong)
    other = sum("it is line " in reason for reason, _ in wrong) - alone
    print(f"{alone} named alone, {other} named another line")
    print(
        f"{sum(bool(reason) for reason, _ in wrong)} of 20 rejected, {named} with the line among the candidates; "
        f"{sum(not reason for reason, _ in right)} of 20 accepted"
    )
    assert all(reason for reason, _ in wrong)
    assert all(f"{line} by " in reason or "following error" in reason for reason, line in wrong)  # or overloaded
    assert not any(reason for reason, _ in right)
    assert not other
    assert alone >= 12
