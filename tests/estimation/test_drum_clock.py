"""The drum's clock: bounds by the least lag, drift, jumps."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest

from cablewright.estimation.clock_offset import ClockLead, ClockLeadSettings
from cablewright.estimation.reading_checks import by_machine_clock
from cablewright.foundation.signals import Encoders, Inertial, LineAngles, Reading, frozen

LATENCY, PERIOD = 5e-3, 0.01


def drive(ahead: float, drift: float, seconds: float, jump: float = 0.0, at: float = 1e9) -> tuple[ClockLead, float]:
    """Send readings through a link with jitter; return the clock, and the largest error of a time after 10 s, s."""
    clock, random = ClockLead(ClockLeadSettings(0.01, 1e-4, LATENCY)), np.random.default_rng(3)
    sent: deque[tuple[float, float, Reading]] = deque()
    worst, arrives = 0.0, 0.0
    for step in range(round(seconds / PERIOD)):
        true = step * PERIOD
        shown = true * (1.0 + drift) + ahead + (jump if true >= at else 0.0)
        arrives = max(arrives, true + LATENCY + 3e-3 * random.exponential())
        sent.append((arrives, true, LineAngles(shown, frozen(np.zeros(4)))))
        now, here = true, []
        while sent and sent[0][0] <= now:
            here.append(sent.popleft()[1:])
        corrected = by_machine_clock(clock, tuple(reading for _, reading in here), now)
        assert len(corrected) == len(here) or at <= now < at + 1.0  # when the clock was set, for two frames
        for (was, _), reading in zip(here[-len(corrected) :], corrected, strict=False):
            assert reading.time <= now - LATENCY + 1e-9, "no reading is faster than the link"
            if now > 10.0 and not at < now < at + 30.0:
                worst = max(worst, abs(reading.time - was))
    return clock, worst


@pytest.mark.parametrize("ahead", [-0.03, -0.002, 0.0, 0.004, 0.5])
def test_times_are_within_a_period(ahead: float) -> None:
    _, worst = drive(ahead, 0.0, 20.0)
    assert worst <= PERIOD + 1e-3


@pytest.mark.parametrize("drift", [-5e-5, 5e-5, 1e-3])
def test_a_drift_is_followed(drift: float) -> None:
    clock, worst = drive(0.01, drift, 120.0)
    assert worst <= PERIOD + 20.0 * abs(drift) + 1e-3
    assert clock.ahead == pytest.approx(0.01 + 120.0 * drift, abs=PERIOD + 20.0 * abs(drift))


@pytest.mark.parametrize("jump", [-0.7, 0.7])
def test_a_jump_is_followed_within_half_a_minute(jump: float) -> None:
    clock, worst = drive(0.0, 0.0, 70.0, jump, at=20.0)
    assert worst <= PERIOD + 1e-3
    assert clock.ahead == pytest.approx(jump, abs=PERIOD)


@pytest.mark.parametrize("drift", [-5e-5, 5e-5])
def test_in_long_steps_a_drift_is_followed_closely_where_readings_are_known_to_be_young(drift: float) -> None:
    """Read at the end of each step of a second, for ten hours: the clock ends 1.8 s off."""
    clock, none = ClockLead(ClockLeadSettings(0.01, 5e-5, 0.0, age=0.0)), frozen(np.zeros(3))
    for now in range(1, 36_001):
        (moved,) = by_machine_clock(clock, (Inertial(now * (1.0 + drift) + 4e-3, none, none),), float(now))
        assert abs(moved.time - now) <= 1e-3
    assert clock.ahead == pytest.approx(36_000 * drift + 4e-3, abs=1e-3)
    assert 0.0 < clock.sigma <= 1e-3


@pytest.mark.parametrize("period", [0.99, 10.0, 60.0])
def test_in_steps_of_any_length_the_clock_is_as_sure_as_it_says(period: float) -> None:
    clock, none = ClockLead(ClockLeadSettings(0.01, 5e-5, 0.0, age=0.0)), frozen(np.zeros(3))
    for step in range(1, 200):
        now = step * period
        by_machine_clock(clock, (Inertial(now * (1.0 - 5e-5), none, none),), now)
        assert abs(clock.ahead + 5e-5 * now) <= clock.sigma * (2.0 if step < 10 else 1.0) + 1e-9


def test_only_the_drums_readings_are_moved() -> None:
    clock = ClockLead(ClockLeadSettings(0.1, 0.0, 0.0))
    none = frozen(np.zeros(3))
    imu, encoders = Inertial(1.5, none, none), Encoders(1.0, np.zeros(4, dtype=np.int64))
    moved, same = by_machine_clock(clock, (imu, encoders), 1.0)
    assert moved.time == pytest.approx(1.0)
    assert same is encoders


@pytest.mark.parametrize("stamp", [1000.0, math.inf, math.nan])
def test_one_wrong_stamp_moves_nothing(stamp: float) -> None:
    clock, none = ClockLead(ClockLeadSettings(0.01, 0.0, 0.0)), frozen(np.zeros(3))
    for step in range(1000):
        now = step * PERIOD
        wrong = step == 500
        imu = Inertial(stamp if wrong else now + 0.02, none, none)
        corrected = by_machine_clock(clock, (imu,), now)
        if step > 5 and not wrong:
            assert corrected[0].time == pytest.approx(now, abs=PERIOD)
        if wrong:
            assert not any(math.isfinite(reading.time) and reading.time > 900.0 for reading in corrected)


def test_a_late_link_is_no_clock_set_back_and_the_doubt_is_reported() -> None:
    clock, none = ClockLead(ClockLeadSettings(0.01, 0.0, 0.0)), frozen(np.zeros(3))
    for step in range(3000):
        now = step * PERIOD
        late = 0.25 if 1000 <= step < 1700 else 0.0
        by_machine_clock(clock, (Inertial(now - late, none, none),), now)
        assert clock.ahead == pytest.approx(0.0, abs=PERIOD)
        if 1400 < step < 1700:
            assert clock.doubt > 0.2
    assert clock.doubt < 0.02
