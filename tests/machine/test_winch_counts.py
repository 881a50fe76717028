"""Counts go on over the wrap of their counters, and over a loss of power exactly where nothing can have moved."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.signals import Command, Condition, Encoders, SensorFrame, WinchMode
from cablewright.machine.interface import Abilities
from cablewright.machine.winch_counts import BITS, CountFile, Remembering, Unwrapped

DT = 0.1
LINES = ("a", "b")


class Winches:
    """Two winches whose counters of 32 bits start at zero with the power."""

    period = DT

    def __init__(self, counter: tuple[float, float] = (0.0, 0.0)) -> None:
        self.time, self.turned, self.sent, self.slip = 0.0, np.array(counter), 0, 0.0

    @property
    def abilities(self) -> Abilities:
        return Abilities(2, frozenset({"encoders"}), frozenset(WinchMode))

    def open(self) -> None:
        pass

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass

    def step(self, command: Command) -> SensorFrame:
        self.sent += 1
        self.time += DT
        self.turned += 1e9 * DT * command.winch_speeds + self.slip * (WinchMode.OFF in command.modes)
        raw = (np.rint(self.turned).astype(np.int64) + (1 << 31)) % (1 << BITS) - (1 << 31)
        return SensorFrame(self.time, (Encoders(self.time, raw),))


def command(*speeds: float, **more: object) -> Command:
    """A command; one of winches that do not turn closes their brakes."""
    if not any(speeds):
        more = {"modes": (WinchMode.OFF,) * 2} | more
    return Command(0.0, np.array(speeds), **more)  # type: ignore[arg-type]


def remembering(folder: Path, robot: str = "twin", counter: tuple[float, float] = (0.0, 0.0)) -> Remembering:
    return Remembering(Winches(counter), CountFile(folder / "counts.json", robot, LINES))


def driven(machine: Remembering, *speeds: float, steps: int = 20) -> np.ndarray:
    for _ in range(steps):
        frame = machine.step(command(*speeds))
    return frame.of(Encoders)[0].counts


def test_totals_go_on_where_counters_wrap() -> None:
    unwrapped, true, random = Unwrapped(), np.zeros(3, dtype=np.int64), np.random.default_rng(1)
    for _ in range(2000):
        raw = true % (1 << BITS)  # unsigned
        np.testing.assert_array_equal(unwrapped.total(raw), true)
        true = true + random.integers(-(2**31) + 1, 2**31 - 1, 3)


def test_counts_at_rest_are_found_again_after_the_power_was_gone(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 1.0, -2.0)  # wraps twice
    left = driven(machine, 0.0, 0.0)
    np.testing.assert_array_equal(left, [2_000_000_000, -4_000_000_000])
    again = remembering(tmp_path)
    again.open()
    assert again.epoch == machine.epoch
    np.testing.assert_array_equal(driven(again, 0.0, 0.0, steps=1), left)
    np.testing.assert_array_equal(driven(again, 0.5, 0.0, steps=2), left + np.array([100_000_000, 0]))
    assert again.power_lost


@pytest.mark.parametrize("steps", [0, 1, 5, 9])
def test_whoever_loses_power_in_motion_or_soon_after_finds_no_mark(tmp_path: Path, steps: int) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    driven(machine, 0.1, 0.0, steps=3)
    if steps:
        driven(machine, 0.0, 0.0, steps=steps)
    again = remembering(tmp_path)
    again.open()
    assert again.epoch != machine.epoch


def test_a_winch_that_is_held_under_torque_has_no_mark(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    assert mark(tmp_path)
    machine.step(command(0.0, 0.0, modes=(WinchMode.HOLD,) * 2))
    assert not mark(tmp_path)


def test_what_slips_while_brakes_close_is_counted_before_it_is_saved(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.1, 0.0, steps=3)
    for _ in range(20):
        machine.step(command(0.0, 0.0, modes=(WinchMode.HOLD,) * 2))
    own = machine.machine
    assert isinstance(own, Winches)
    step, left = own.step, [5]

    def slipping(given: Command) -> SensorFrame:
        own.slip, left[0] = 100.0 if left[0] > 0 else 0.0, left[0] - 1
        return step(given)

    own.step = slipping  # type: ignore[method-assign]
    machine.close()
    found = machine.file.read()
    assert found is not None
    assert found.valid
    assert found.counts.tolist() == [30_000_500, 500]


def test_counts_that_are_not_valid_never_become_those_of_the_same_epoch_again(tmp_path: Path) -> None:
    """Whatever opens and closes the machine after it was killed in motion: lengths of then are of another epoch."""
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    driven(machine, 0.1, 0.0, steps=3)  # and killed
    epochs = {machine.epoch}
    for _ in range(3):
        again = remembering(tmp_path)
        again.open()
        driven(again, 0.0, 0.0, steps=3)
        again.close()
        assert again.epoch not in {machine.epoch}
        epochs.add(again.epoch)
    assert len(epochs) == 2  # the new one goes on


@pytest.mark.parametrize(
    ("counter", "same", "lost"),
    [
        ((300.0, -70.0), True, False),
        ((0.0, 0.0), True, True),
        ((310.0, -70.0), False, False),
        ((0.0, 90.0), False, False),
    ],
)
def test_a_counter_that_is_elsewhere_begins_a_new_epoch(
    tmp_path: Path, counter: tuple[float, float], same: bool, lost: bool
) -> None:
    machine = remembering(tmp_path, counter=(300.0, -70.0))
    machine.open()
    left = driven(machine, 0.0, 0.0)
    again = remembering(tmp_path, counter=counter)
    again.open()
    counts = driven(again, 0.0, 0.0, steps=1)
    assert (again.epoch == machine.epoch, again.power_lost) == (same, lost)
    np.testing.assert_array_equal(counts, left if same else counter)


def mark(folder: Path) -> bool:
    """Whether the counts on disk are valid."""
    return bool(json.loads((folder / "counts.json").read_text())["valid"])


def test_the_mark_is_gone_on_disk_before_the_command_is_sent(tmp_path: Path, monkeypatch) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    assert json.loads((tmp_path / "counts.json").read_text())["valid"]
    own = machine.machine
    assert isinstance(own, Winches)
    sent = own.sent

    def full(*_: object, **__: object) -> None:
        raise EnvironmentFault("no space left")

    monkeypatch.setattr(CountFile, "write", full)
    for moving in (command(0.1, 0.0), command(0.0, 0.0, modes=(WinchMode.TENSION,) * 2, tensions=np.ones(2))):
        with pytest.raises(EnvironmentFault):
            machine.step(moving)
    assert own.sent == sent


def test_a_drum_that_turns_by_itself_has_no_mark(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    own = machine.machine
    assert isinstance(own, Winches)
    own.turned += [2.0, 0.0]  # it flickers
    driven(machine, 0.0, 0.0, steps=1)
    assert json.loads((tmp_path / "counts.json").read_text())["valid"]
    own.turned += [50.0, 0.0]  # a brake slips
    driven(machine, 0.0, 0.0, steps=1)
    assert not json.loads((tmp_path / "counts.json").read_text())["valid"]
    driven(machine, 0.0, 0.0)
    found = machine.file.read()
    assert found is not None
    assert found.valid
    np.testing.assert_array_equal(found.counts, [52, 0])


SAVED = {"schema": 2, "robot": "twin", "lines": ["a", "b"], "epoch": 1, "raw": [0, 0], "counts": [0, 0], "valid": True}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("{", "JSON"),
        ("[]", "object"),
        ({"schema": 1}, "schema"),
        ({"counts": [0, 1e99]}, "counts"),
        ({"counts": [0]}, "holds counts of 'twin'"),
        ({"raw": [0, 0, 0]}, "holds counts of 'twin'"),
        ({"robot": "other"}, "of 'other'"),
        ({"epoch": -1}, "epoch"),
        ({"valid": 1}, "valid"),
    ],
)
def test_a_file_that_is_damaged_or_of_another_is_rejected(tmp_path: Path, content: str | dict, says: str) -> None:
    text = content if isinstance(content, str) else json.dumps(SAVED | content)
    (tmp_path / "counts.json").write_text(text)
    with pytest.raises(InputError, match=says):
        remembering(tmp_path).open()


def test_silence_is_no_standstill(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    own = machine.machine
    assert isinstance(own, Winches)
    machine.open()
    driven(machine, 0.1, 0.0, steps=1)
    step = own.step
    own.step = lambda command: replace(step(command), readings=())  # type: ignore[method-assign]
    for _ in range(30):
        machine.step(command(0.0, 0.0))
    assert not (tmp_path / "counts.json").exists()


def test_a_creep_is_no_standstill(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    own = machine.machine
    assert isinstance(own, Winches)
    machine.open()
    for _ in range(30):
        own.turned += [2.0, 0.0]
        machine.step(command(0.0, 0.0))
    assert not (tmp_path / "counts.json").exists()


def test_saved_counts_are_not_lost_to_a_first_command_that_turns(tmp_path: Path) -> None:
    machine = remembering(tmp_path)
    machine.open()
    driven(machine, 0.0, 0.0)
    driven(machine, 0.001, 0.0, steps=1)
    driven(machine, 0.0, 0.0)
    again = remembering(tmp_path)
    again.open()
    np.testing.assert_array_equal(driven(again, 0.001, 0.0, steps=2), [200_000, 0])
    epoch, again.machine = again.epoch, Winches()
    again.open()
    assert again.epoch != epoch
    np.testing.assert_array_equal(driven(again, 0.0, 0.0, steps=1), [0, 0])


def test_a_full_disk_at_a_standstill_is_a_notice(tmp_path: Path, monkeypatch) -> None:
    machine = remembering(tmp_path)
    machine.open()

    def full(*_: object, **__: object) -> None:
        raise EnvironmentFault("no space left")

    monkeypatch.setattr(CountFile, "write", full)
    for _ in range(20):
        frame = machine.step(command(0.0, 0.0))
    assert [notice.condition for notice in frame.notices] == [Condition.NOT_SAVED]
