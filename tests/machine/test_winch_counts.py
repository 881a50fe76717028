"""Counts go on over the wrap of their counters, and over a loss of power exactly where nothing can have moved."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.errors import EnvironmentFault, InputError
from cablewright.machine.interface import Abilities
from cablewright.machine.winch_counts import BITS, CountFile, Remembering, Unwrapped
from cablewright.signals import Command, Condition, Encoders, SensorFrame, WinchMode

DT = 0.1
LINES = ("a", "b")


class Winches:
    """Two winches whose counters of 32 bits start at zero with the power."""

    period = DT

    def __init__(self) -> None:
        self.time, self.turned, self.sent = 0.0, np.zeros(2), 0

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
        self.turned += 1e9 * DT * command.winch_speeds
        raw = (np.rint(self.turned).astype(np.int64) + (1 << 31)) % (1 << BITS) - (1 << 31)
        return SensorFrame(self.time, (Encoders(self.time, raw),))


def command(*speeds: float, **more: object) -> Command:
    return Command(0.0, np.array(speeds), **more)  # type: ignore[arg-type]


def remembering(folder: Path, robot: str = "twin") -> Remembering:
    return Remembering(Winches(), CountFile(folder / "counts.json", robot, LINES))


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
    assert not machine.restored
    driven(machine, 1.0, -2.0)  # wraps twice
    left = driven(machine, 0.0, 0.0)
    np.testing.assert_array_equal(left, [2_000_000_000, -4_000_000_000])
    again = remembering(tmp_path)
    again.open()
    assert again.restored
    np.testing.assert_array_equal(driven(again, 0.0, 0.0, steps=1), left)
    np.testing.assert_array_equal(driven(again, 0.5, 0.0, steps=2), left + np.array([100_000_000, 0]))


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
    assert not again.restored


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


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("{", "JSON"),
        ("[]", "object"),
        ('{"schema": 2, "robot": "twin", "lines": ["a", "b"], "counts": [0, 0], "valid": true}', "schema"),
        ('{"schema": 1, "robot": "twin", "lines": ["a", "b"], "counts": [0, 1e99], "valid": true}', "counts"),
        ('{"schema": 1, "robot": "twin", "lines": ["a", "b"], "counts": [0], "valid": true}', "holds counts of 'twin'"),
        ('{"schema": 1, "robot": "other", "lines": ["a", "b"], "counts": [0, 0], "valid": true}', "of 'other'"),
        ('{"schema": 1, "robot": "twin", "lines": ["a", "b"], "counts": [0, 0], "valid": 1}', "valid"),
    ],
)
def test_a_file_that_is_damaged_or_of_another_is_refused(tmp_path: Path, content: str, says: str) -> None:
    (tmp_path / "counts.json").write_text(content)
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
    again.machine = Winches()
    again.open()
    assert not again.restored
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
