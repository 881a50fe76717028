"""The guard finds what is wrong by what is measured alone, stops as it should, and takes outliers for outliers."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from cablewright.control import guard
from cablewright.control.guard import Cause, GuardSettings, GuardState, RampState
from cablewright.errors import InputError
from cablewright.signals import (
    Condition,
    Drives,
    DriveState,
    Encoders,
    Inputs,
    Notice,
    Reading,
    SensorFrame,
    Tensions,
    frozen,
)

LIMITS = GuardSettings(
    np.full(3, 300.0),
    max_torques=np.full(3, 20.0),
    max_drum_speed=5.0,
    max_following_error=0.1,
    counts_per_radian=100.0,
)
DT = 0.01


class Watched:
    """Encoders that stand still, and whatever else a step brings."""

    def __init__(self, settings: GuardSettings = LIMITS) -> None:
        self.settings, self.state, self.now = settings, GuardState(), 0.0
        self.counts = np.zeros(3, dtype=np.int64)

    def sees(self, *readings: Reading, **more: Any) -> Cause | None:
        self.now += DT
        shown = (Encoders(self.now, self.counts.copy()),) if more.pop("encoders", True) else ()
        frame = SensorFrame(self.now, (*shown, *readings), tuple(map(Notice, more.pop("conditions", ()))))
        return guard.judge(self.settings, self.state, frame, more.pop("inferred", None))


def pulls(*tensions: float) -> Tensions:
    return Tensions("load_cells", 0.0, frozen(tensions))


def drives(**changes: Any) -> Drives:
    zeros = frozen(np.zeros(3))
    usual = dict.fromkeys(("positions", "velocities", "torques", "following_errors"), zeros)
    given = {"states": (DriveState.ENABLED,) * 3, "faults": ("",) * 3} | usual | changes
    return Drives(0.0, **given)


def test_nothing_is_wrong_where_nothing_is() -> None:
    watched = Watched()
    inputs = Inputs(0.0, chain_closed=True, torque_off=False, enabling=True, brakes_closed=())
    for _ in range(100):
        assert (
            watched.sees(pulls(100.0, 299.0, np.nan), drives(), inputs, inferred=np.array([10.0, np.nan, 0.0])) is None
        )


def test_a_measured_tension_needs_two_readings_and_holds_at_once_while_it_rises() -> None:
    watched = Watched()
    assert watched.sees(pulls(100.0, 900.0, 100.0)) is None
    found = watched.sees(pulls(100.0, 950.0, 100.0))
    assert found == Cause("line 2 pulls 950 N; at most 300 is allowed", at_once=True)
    falling = watched.sees(pulls(100.0, 940.0, 100.0))
    assert falling is not None
    assert not falling.at_once
    assert watched.sees() == falling  # it holds until the load cells tell otherwise
    assert watched.sees(pulls(100.0, 100.0, 100.0)) is None
    assert watched.sees(pulls(100.0, 900.0, 100.0)) is None


def test_tensions_by_lengths_are_judged_beside_measured_ones() -> None:
    found = Watched().sees(pulls(1.0, 1.0, 1.0), inferred=np.array([0.0, 301.0, np.nan]))
    assert found == Cause("line 2 pulls 301 N; at most 300 is allowed, by the lengths", at_once=True)


def test_a_flipped_bit_is_no_speed_and_a_winch_that_races_is_one() -> None:
    watched = Watched()
    watched.sees()
    watched.counts[1] ^= 1 << 20
    assert watched.sees() is None
    watched.counts[1] ^= 1 << 20
    assert watched.sees() is None
    for expected in (None, "line 1 turns at 6 rad/s; at most 5 is allowed"):
        watched.counts[0] -= 6
        found = watched.sees()
        assert (found.reason if found else None) == expected


@pytest.mark.parametrize(
    ("changes", "says", "at_once"),
    [
        ({"following_errors": frozen([0.0, 0.0, -0.2])}, "line 3 follows its command with an error of 0.2 rad", True),
        ({"velocities": frozen([0.0, 9.0, 0.0])}, "line 2 turns at 9 rad/s", False),
        ({"torques": frozen([-25.0, 0.0, 0.0])}, "line 1 has a torque of 25 N m; at most 20", True),
    ],
)
def test_drives_are_judged_by_two_readings(changes: dict[str, Any], says: str, at_once: bool) -> None:
    watched = Watched()
    assert watched.sees(drives(**changes)) is None
    found = watched.sees(drives(**changes))
    assert found is not None
    assert says in found.reason
    assert found.at_once is at_once


def test_a_fault_of_a_drive_needs_one() -> None:
    states, texts = (DriveState.ENABLED, DriveState.FAULT, DriveState.ENABLED), ("", "0x7380 position sensor", "")
    found = Watched().sees(drives(states=states, faults=texts))
    assert found == Cause("the drive of line 2 reports a fault: 0x7380 position sensor", at_once=True)


@pytest.mark.parametrize(
    ("state", "says", "at_once"),
    [
        ((False, True, True), "emergency-stop chain is open", False),
        ((True, True, True), "safe torque off", True),
        ((True, False, False), "enabling switch", False),
    ],
)
def test_inputs_stop_it(state: tuple[bool, bool, bool], says: str, at_once: bool) -> None:
    found = Watched().sees(Inputs(0.0, *state, ()))
    assert found is not None
    assert says in found.reason
    assert found.at_once is at_once


@pytest.mark.parametrize("condition", [Condition.DRIVE_FAULT, Condition.BRAKE, Condition.NO_EQUILIBRIUM])
def test_some_notices_hold_at_once(condition: Condition) -> None:
    found = Watched().sees(conditions=(condition,))
    assert found is not None
    assert found.at_once


@pytest.mark.parametrize("condition", [Condition.BUS_SILENT, Condition.ESTOP, Condition.CLOCK_BACK])
def test_others_stop_by_a_ramp(condition: Condition) -> None:
    found = Watched().sees(conditions=(condition,))
    assert found is not None
    assert not found.at_once


def test_the_more_urgent_cause_is_told() -> None:
    found = Watched().sees(conditions=(Condition.ESTOP, Condition.BRAKE))
    assert found is not None
    assert found.at_once


def test_silence_of_a_source_that_must_speak_is_heard() -> None:
    watched = Watched(GuardSettings(np.full(3, 300.0), timeouts={"encoders": 0.5, "load_cells": 0.1}))
    for _ in range(10):
        assert watched.sees(pulls(1.0, 1.0, 1.0)) is None
    for _ in range(11):
        found = watched.sees()
    assert found == Cause("no reading of the load cells for over 0.1 s", at_once=False)
    watched = Watched()
    for _ in range(52):
        found = watched.sees(encoders=False)
    assert found == Cause("no reading of the encoders for over 0.5 s", at_once=False)


def test_a_load_cell_that_dies_is_silence_and_one_that_never_was_is_not() -> None:
    watched = Watched(GuardSettings(np.full(3, 300.0), timeouts={"load_cells": 0.1}))
    for _ in range(30):
        assert watched.sees(pulls(1.0, 1.0, np.nan)) is None
    for _ in range(12):
        found = watched.sees(pulls(1.0, np.nan, np.nan))
    assert found == Cause("no reading of the load cells for over 0.1 s", at_once=False)


def test_a_reading_that_was_overtaken_is_not_heard() -> None:
    watched = Watched()
    for time_ in (1.0, 1.1):
        watched.sees(Tensions("load_cells", time_, frozen([100.0, 900.0, 100.0])))
    late = watched.sees(Tensions("load_cells", 1.05, frozen([100.0, 100.0, 100.0])))
    assert late is not None
    assert "pulls 900 N" in late.reason


def test_winches_come_to_rest_together_and_brakes_close_after_them() -> None:
    """One factor for all: the ratios of the speeds stay, so that no line is wound in against the others."""
    stop = RampState(10.0, np.array([1.0, -2.0, 0.5]), at_once=False)
    seen = [guard.ramp(LIMITS, stop, 10.0 + k * 0.05) for k in range(20)]
    factors = np.array([speeds / stop.speeds for speeds, _ in seen])
    assert np.ptp(factors, axis=1).max() < 1e-15
    assert (np.diff(factors[:, 0]) <= 0.0).all()
    assert factors[7, 0] == 0.0
    braked = [closed for _, closed in seen]
    assert braked.index(True) == 16  # 0.3 s of ramp and 0.5 s held
    speeds, _ = guard.ramp(LIMITS, stop._replace(at_once=True), 10.0)
    assert not speeds.any()


def test_a_step_takes_microseconds() -> None:
    """Asked are 20 us; `python -m benchmarks.run machine` measures it. This only finds what is far off."""
    watched, began = Watched(), time.perf_counter()
    for _ in range(2000):
        watched.sees(pulls(100.0, 200.0, 100.0))
    assert (time.perf_counter() - began) / 2000 < 2e-3


def test_limits_that_limit_nothing_are_refused() -> None:
    with pytest.raises(InputError, match="over 0"):
        GuardSettings(np.array([300.0, 0.0]))
    with pytest.raises(InputError, match="ramp_time = 0"):
        GuardSettings(np.array([300.0]), ramp_time=0.0)
    with pytest.raises(InputError, match="encoders = -1"):
        GuardSettings(np.array([300.0]), timeouts={"encoders": -1.0})
