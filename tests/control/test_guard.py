"""The guard finds faults by measurements alone, stops correctly, and ignores outliers."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cablewright.control import guard
from cablewright.control.guard import GuardSettings, GuardState, StopCause
from cablewright.control.stop import StopKind
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    Command,
    Condition,
    Drives,
    DriveState,
    Encoders,
    Inputs,
    Notice,
    Reading,
    SensorFrame,
    Tensions,
    WinchMode,
    YawAngle,
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

    def sees(self, *readings: Reading, **more: Any) -> StopCause | None:
        self.now += DT
        shown = (Encoders(self.now, self.counts.copy()),) if more.pop("encoders", True) else ()
        frame = SensorFrame(self.now, (*shown, *readings), tuple(map(Notice, more.pop("conditions", ()))))
        return guard.judge(self.settings, self.state, frame, more.pop("inferred", None), **more)


def pulls(*tensions: float, at: float = math.inf) -> Tensions:
    """A reading, of now where its own time is later."""
    return Tensions("load_cells", at, frozen(tensions))


def drives(**changes: Any) -> Drives:
    zeros = frozen(np.zeros(3))
    usual = dict.fromkeys(("positions", "velocities", "torques", "following_errors"), zeros)
    given = {"states": (DriveState.ENABLED,) * 3, "faults": ("",) * 3} | usual | changes
    return Drives(math.inf, **given)


def test_nothing_is_wrong_where_nothing_is() -> None:
    watched = Watched()
    inputs = Inputs(math.inf, chain_closed=True, torque_off=False, enabling=True, brakes_closed=())
    for _ in range(100):
        assert (
            watched.sees(pulls(100.0, 299.0, np.nan), drives(), inputs, inferred=np.array([10.0, np.nan, 0.0])) is None
        )


def test_a_measured_tension_needs_two_readings_and_holds_immediately_while_it_rises() -> None:
    watched = Watched()
    assert watched.sees(pulls(100.0, 900.0, 100.0)) is None
    found = watched.sees(pulls(100.0, 950.0, 100.0))
    assert found == StopCause("line 2 pulls 950 N; at most 300 is allowed", StopKind.HOLD)
    falling = watched.sees(pulls(100.0, 900.0, 100.0))
    assert falling is not None
    assert falling.kind is StopKind.RAMP
    assert watched.sees() == falling  # it holds until the load cells report otherwise
    assert watched.sees(pulls(100.0, 100.0, 100.0)) is None
    assert watched.sees(pulls(100.0, 900.0, 100.0)) is None


def test_tensions_by_lengths_are_judged_beside_measured_ones() -> None:
    found = Watched().sees(pulls(1.0, 1.0, 1.0), inferred=np.array([0.0, 301.0, np.nan]))
    assert found == StopCause("line 2 pulls 301 N; at most 300 is allowed, by the lengths", StopKind.HOLD)


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
    ("changes", "says", "kind"),
    [
        (
            {"following_errors": frozen([0.0, 0.0, -0.2])},
            "line 3 follows its command with an error of 0.2 rad",
            StopKind.HOLD,
        ),
        ({"velocities": frozen([0.0, 9.0, 0.0])}, "line 2 turns at 9 rad/s", StopKind.RAMP),
        ({"torques": frozen([-25.0, 0.0, 0.0])}, "line 1 has a torque of 25 N m; at most 20", StopKind.HOLD),
    ],
)
def test_drives_are_judged_by_two_readings(changes: dict[str, Any], says: str, kind: StopKind) -> None:
    watched = Watched()
    assert watched.sees(drives(**changes)) is None
    found = watched.sees(drives(**changes))
    assert found is not None
    assert says in found.reason
    assert found.kind is kind


def test_a_fault_of_a_drive_needs_one() -> None:
    states, texts = (DriveState.ENABLED, DriveState.FAULT, DriveState.ENABLED), ("", "0x7380 position sensor", "")
    found = Watched().sees(drives(states=states, faults=texts))
    assert found == StopCause("the drive of line 2 reports a fault: 0x7380 position sensor", StopKind.BRAKE)


@pytest.mark.parametrize(
    ("state", "says", "kind"),
    [
        ((False, False, True), "emergency-stop chain is open", StopKind.RAMP),
        ((True, True, True), "safe torque off", StopKind.BRAKE),
        ((True, False, False), "enabling switch", StopKind.RAMP),
    ],
)
def test_inputs_stop_it(state: tuple[bool, bool, bool], says: str, kind: StopKind) -> None:
    found = Watched().sees(Inputs(math.inf, *state, ()))
    assert found is not None
    assert says in found.reason
    assert found.kind is kind


NOTICES = {
    Condition.DRIVE_FAULT: StopKind.BRAKE,
    Condition.BUS_SILENT: StopKind.BRAKE,
    Condition.BRAKE: StopKind.KEEP,
    Condition.NO_EQUILIBRIUM: StopKind.HOLD,
    Condition.OFF_PLANE: StopKind.HOLD,
    Condition.ESTOP: StopKind.RAMP,
    Condition.CLOCK_BACK: StopKind.RAMP,
    Condition.CLOCK_AHEAD: StopKind.RAMP,
    Condition.HUNG: StopKind.RAMP,
}


@pytest.mark.parametrize("condition", Condition)
def test_notices_stop_it_as_they_should(condition: Condition) -> None:
    found = Watched().sees(conditions=(condition,))
    assert (None if found is None else found.kind) is NOTICES.get(condition)


def test_the_more_urgent_cause_is_reported() -> None:
    found = Watched().sees(conditions=(Condition.ESTOP, Condition.BRAKE))
    assert found is not None
    assert found.kind is StopKind.KEEP


def test_silence_of_a_source_that_must_speak_is_heard() -> None:
    watched = Watched(GuardSettings(np.full(3, 300.0), timeouts={"encoders": 0.5, "load_cells": 0.1}))
    for _ in range(10):
        assert watched.sees(pulls(1.0, 1.0, 1.0)) is None
    for _ in range(11):
        found = watched.sees()
    assert found == StopCause("no reading of the load cells for over 0.1 s")
    watched = Watched()
    for _ in range(52):
        found = watched.sees(encoders=False)
    assert found == StopCause("no reading of the encoders for over 0.5 s")


@pytest.mark.parametrize(("then", "ahead"), [(None, 0.0), (math.nan, 0.0), (0.1, 1e-3)])
def test_a_silent_encoder_of_the_yaw_is_heard_as_any_other(then: float | None, ahead: float) -> None:
    """So is one that says nothing new, no number, or what the drum's control does not take, as it is ahead."""
    watched = Watched(GuardSettings(np.full(3, 300.0), timeouts={"yaw_encoder": 0.1}))
    for _ in range(30):
        assert watched.sees(YawAngle(watched.now + DT, 0.1)) is None
    stale = YawAngle(watched.now, 0.1)
    for _ in range(11):
        found = watched.sees(stale if then is None else YawAngle(watched.now + DT + ahead, then))
    assert found == StopCause("no reading of the yaw encoder for over 0.1 s")


def test_a_load_cell_that_dies_is_silence_and_one_that_never_was_is_not() -> None:
    watched = Watched(GuardSettings(np.full(3, 300.0), timeouts={"load_cells": 0.1}))
    for _ in range(30):
        assert watched.sees(pulls(1.0, 1.0, np.nan)) is None
    for _ in range(12):
        found = watched.sees(pulls(1.0, np.nan, np.nan))
    assert found == StopCause("no reading of the load cells for over 0.1 s")


def test_a_reading_that_was_overtaken_is_not_heard() -> None:
    watched = Watched()
    for _ in range(20):
        watched.sees(pulls(100.0, 900.0, 100.0))
    late = watched.sees(pulls(100.0, 100.0, 100.0, at=watched.now - 2.0 * DT))
    assert late is not None
    assert "pulls 900 N" in late.reason


def test_brakes_that_ignore_commands_are_found() -> None:
    open_, closed = (True, False, True), (True, True, True)
    for to_close, contacts, says in ((True, open_, "line 2 does not close"), (False, closed, "line 1 does not open")):
        watched, found = Watched(), []
        for _ in range(60):
            modes = (WinchMode.OFF if to_close else WinchMode.HOLD,) * 3
            guard.take_note(watched.state, watched.now, Command(watched.now, np.zeros(3), modes=modes))
            inputs = Inputs(math.inf, chain_closed=True, torque_off=False, enabling=True, brakes_closed=contacts)
            found.append(watched.sees(inputs))
        assert found[:49] == [None] * 49
        assert found[-1] is not None
        assert says in found[-1].reason


def test_one_number_too_few_is_a_cause_and_no_error() -> None:
    for short in (pulls(1.0, 1.0), drives(faults=()), Encoders(math.inf, np.zeros(2, dtype=np.int64))):
        found = Watched().sees(short, encoders=False)
        assert found is not None
        assert "do not report 3 numbers" in found.reason


def test_a_reading_of_the_future_silences_no_sensor() -> None:
    watched = Watched()
    assert watched.sees(pulls(100.0, 100.0, 100.0, at=1e6)) is None
    watched.sees(pulls(100.0, 900.0, 100.0, at=watched.now + DT))
    assert watched.sees(pulls(100.0, 900.0, 100.0, at=watched.now + DT)) is not None


def test_who_dies_over_the_limit_has_not_recovered() -> None:
    watched = Watched()
    watched.sees(pulls(100.0, 900.0, 100.0))
    watched.sees(pulls(100.0, np.nan, 100.0))
    assert watched.sees(pulls(100.0, 900.0, 100.0)) is not None
    for _ in range(50):
        assert watched.sees(pulls(100.0, np.nan, 100.0)) is not None
    assert watched.sees(pulls(100.0, 100.0, 100.0)) is None


def test_counts_that_are_reported_twice_hide_no_speed() -> None:
    watched = Watched()
    found = None
    for _ in range(10):
        watched.counts[0] += 20
        again = Encoders(watched.now + DT, watched.counts.copy())
        found = watched.sees(again)
    assert found is not None
    assert "turns at" in found.reason


def test_a_step_takes_microseconds() -> None:
    """20 us are required; `python -m benchmarks.run machine` measures it. This only finds large excesses."""
    watched, began = Watched(), time.perf_counter()
    for _ in range(2000):
        watched.sees(pulls(100.0, 200.0, 100.0))
    assert (time.perf_counter() - began) / 2000 < 2e-3


def test_limits_that_limit_nothing_are_rejected() -> None:
    with pytest.raises(InputError, match="over 0"):
        GuardSettings(np.array([300.0, 0.0]))
    with pytest.raises(InputError, match="encoders = -1"):
        GuardSettings(np.array([300.0]), timeouts={"encoders": -1.0})


TURNED = dataclasses.replace(LIMITS, max_uncounted=np.full(3, 0.4))  # 20 mm of cable on a radius of 50 mm


def ordered(speeds: Array, follows: Callable[[float, Array], Array], mode: WinchMode = WinchMode.VELOCITY) -> float:
    """Order *speeds* (3,) until the guard stops; return for how long, s. *follows*: rad/s of the drums, by time."""
    watched, angles = Watched(TURNED), np.zeros(3)
    while watched.now < 5.0:
        guard.take_note(watched.state, watched.now, Command(watched.now, speeds, modes=(mode,) * 3))
        angles = angles + DT * follows(watched.now, speeds)
        watched.counts = np.rint(angles * 100.0).astype(np.int64)
        found = watched.sees()
        if found is not None:
            assert "the encoder of line 2 does not count" in found.reason
            assert found.kind is StopKind.HOLD
            return watched.now
    return math.inf


@pytest.mark.parametrize("speed", [0.1, 0.6, -0.6, 2.0])
def test_an_encoder_that_does_not_count_is_named_within_3_cm(speed: float) -> None:
    stopped = ordered(np.full(3, speed), lambda _, speeds: speeds * [1.0, 0.0, 1.0])
    assert abs(speed) * stopped * 0.05 <= max(0.03, abs(speed) * 0.05 * 0.3)


def test_late_slow_and_slipping_winches_count() -> None:
    for speed in (0.01, 0.5, 3.0):
        for follows in (
            lambda now, speeds: speeds * (now > 0.2),  # late
            lambda now, speeds: speeds * min(1.0, 3.0 * now),  # accelerates
            lambda now, speeds: 0.5 * speeds,  # the half of it
            lambda now, speeds: 0.5 * speeds * (1.0 + math.cos(20.0 * now)),  # vibrates
        ):
            assert ordered(np.array([speed, -speed, 0.0]), follows) == math.inf


@pytest.mark.parametrize("mode", [WinchMode.TENSION, WinchMode.HOLD, WinchMode.OFF])
def test_winches_without_a_speed_need_not_count(mode: WinchMode) -> None:
    assert ordered(np.full(3, 1.0), lambda _, speeds: 0.0 * speeds, mode) == math.inf


def test_a_winch_that_goes_back_and_forth_less_than_the_limit_need_not_count() -> None:
    watched = Watched(TURNED)
    for _ in range(1000):
        speeds = np.full(3, math.copysign(0.3, math.sin(4.0 * watched.now)))
        guard.take_note(watched.state, watched.now, Command(watched.now, speeds))
        assert watched.sees() is None


def test_a_motor_that_says_it_cannot_turn_is_not_a_stuck_encoder() -> None:
    watched = Watched(TURNED)
    for _ in range(200):
        guard.take_note(watched.state, watched.now, Command(watched.now, np.full(3, 1.0)))
        assert watched.sees(conditions=(Condition.STALLED,)) is None


def test_the_minimum_is_judged_by_the_best_known_tensions_and_the_maximum_by_the_lengths_too() -> None:
    limits = dataclasses.replace(LIMITS, min_tensions=np.full(3, 50.0))
    for inferred, best, reason in (
        (np.full(3, 20.0), np.full(3, 100.0), ""),
        (np.full(3, 100.0), np.array([100.0, 20.0, 100.0]), "line 2 pulls 20 N; at least 50 is needed"),
        (np.array([100.0, 400.0, 100.0]), np.full(3, 100.0), "line 2 pulls 400 N; at most 300 is allowed, by the"),
        (np.full(3, 20.0), None, "line 1 pulls 20 N; at least 50 is needed"),
    ):
        watched = Watched(limits)
        found: StopCause | None = None
        for _ in range(int((guard.LOST_TIME + 0.1) / DT)):
            found = watched.sees(inferred=inferred, best=best, lowest=True)
        assert ("" if found is None else found.reason).startswith(reason)
        assert (found is None) == (not reason)
