"""The loop's clock names a jump by its direction, and goes on by a period."""

from __future__ import annotations

import math

import pytest

from cablewright.control.clock import FrameClock
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import Barrier, Condition, SensorFrame

PERIOD = 0.01  # s


@pytest.mark.parametrize(
    ("jump", "says"),
    [
        (1e9, Condition.CLOCK_AHEAD),
        (7200.0, Condition.CLOCK_AHEAD),
        (-5.0, Condition.CLOCK_BACK),
        (math.nan, Condition.CLOCK_BACK),
        (12.0, Condition.OVERRUN),
    ],
)
def test_a_jump_is_named_by_its_direction(jump: float, says: Condition) -> None:
    clock = FrameClock(PERIOD, 0.0)
    clock.tell(SensorFrame(1.0))
    then = 1.0 + PERIOD + jump
    frame, elapsed = clock.tell(SensorFrame(then, (Barrier(then, broken=False),)))
    assert [notice.condition for notice in frame.notices] == [says]
    assert elapsed <= 3.0 * PERIOD
    if says is not Condition.OVERRUN:
        assert frame.time == pytest.approx(1.0 + PERIOD)
        assert not frame.readings
    after, _ = clock.tell(SensorFrame(then + PERIOD, (Barrier(then + PERIOD, broken=False),)))
    assert math.isnan(jump) or [reading.time for reading in after.readings] == [pytest.approx(after.time)]
    assert math.isnan(jump) or after.time == pytest.approx(frame.time + PERIOD)
    assert math.isnan(jump) or not after.notices


@pytest.mark.parametrize("jump", [-1.0, -5.0, 7200.0])
def test_a_reading_of_before_a_jump_that_is_repeated_is_never_new(jump: float) -> None:
    """A clear light barrier that a frozen sensor repeats is not measured again by the clock's being set."""
    clock, times = FrameClock(PERIOD, 0.0), ReadingTimes()
    frozen = Barrier(1.0 - 1.01 * PERIOD, broken=False)
    told = []
    for step in range(300):
        frame, _ = clock.tell(SensorFrame(1.0 + PERIOD * step + (jump if step > 50 else 0.0), (frozen,)))
        told += [times.is_new("barrier", each.time, frame.time) for each in frame.of(Barrier)]
    assert sum(told) == 1


def test_a_stamp_of_before_a_jump_is_no_reading_of_after_it() -> None:
    """A sensor falls silent with the jump, and repeats its last reading just as the clock reaches that time again."""
    clock, frozen = FrameClock(PERIOD, 0.0), Barrier(1.5, broken=False)
    told = []
    for step in range(300):
        now = 1.0 + PERIOD * step - (1.0 if step > 60 else 0.0)
        readings = (frozen,) if 50 <= step <= 60 or now > 1.5 - 0.5 * PERIOD else ()
        frame, _ = clock.tell(SensorFrame(now, readings))
        told.append(len(frame.readings))
    assert sum(told) == sum(told[:61]) > 0
