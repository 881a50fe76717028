"""The loop's clock names a jump by its direction, and goes on by a period."""

from __future__ import annotations

import math

import pytest

from cablewright.control.clock import FrameClock
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
        assert [reading.time for reading in frame.readings] == ([] if math.isnan(jump) else [pytest.approx(frame.time)])
    after, _ = clock.tell(SensorFrame(then + PERIOD))
    assert math.isnan(jump) or after.time == pytest.approx(frame.time + PERIOD)
    assert math.isnan(jump) or not after.notices
