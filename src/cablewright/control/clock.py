"""The clock of a control loop: a machine's, made to go on whatever that does."""

from __future__ import annotations

import math
from typing import Final

from cablewright.foundation.reading_times import CLOCK_TOLERANCE
from cablewright.foundation.signals import Condition, Notice, SensorFrame

_SAME: Final = 1e-6  # of a period: elapsed times that differ by less are a period, told by a clock with rounding
_LATE: Final = 1.5  # periods after which a step is an overrun
_AHEAD: Final = 3600.0  # s after which no step was late, but the clock was set
_MOST: Final = 3.0  # periods for which the control goes on after a gap


class FrameClock:
    """Times of frames and readings, each later than the last."""

    def __init__(self, period: float, begin: float) -> None:
        """*period*: s, of a step as planned; *begin*: s, the time before the first frame."""
        self._period, self._begin, self._offset = period, begin, 0.0
        self._now: float | None = None
        self._jump = -math.inf  # s, when the machine's clock jumped

    @property
    def now(self) -> float:
        """Time of the last frame, s."""
        return self._begin if self._now is None else self._now

    def tell(self, frame: SensorFrame) -> tuple[SensorFrame, float]:
        """Return the frame by this clock, and the time that has elapsed since the last one, s, at most a few periods.

        A late frame has a notice. Where the machine's clock jumps, or tells no number, the frame has another; the
        times of all frames and readings from then on are shifted, so that this clock goes on by one period. Readings
        without a time are left out, and those of before a jump: by which clock they are nobody knows.
        """
        period, notices, known = self._period, frame.notices, math.isfinite(frame.time)
        if self._now is None:
            self._now = frame.time - period if known else self._begin
        elapsed = frame.time + self._offset - self._now
        if not 0.0 < elapsed <= max(_AHEAD, _MOST * period):
            jumped = Condition.CLOCK_AHEAD if known and elapsed > 0.0 else Condition.CLOCK_BACK
            notices, elapsed = (*notices, Notice(jumped)), period
            if known:
                self._offset = self._now + period - frame.time
            self._jump = now = self._now + period
        else:
            now = frame.time + self._offset
            if abs(elapsed - period) <= _SAME * period:
                elapsed = period
            elif elapsed > _LATE * period:
                notices = (*notices, Notice(Condition.OVERRUN))
        self._now = now
        readings = frame.readings
        if self._offset or not all(math.isfinite(each.time) for each in readings):
            shifted = (each.stamped(each.stamp + self._offset) for each in readings if math.isfinite(each.time))
            readings = tuple(each for each in shifted if each.time > self._jump + CLOCK_TOLERANCE)
        return SensorFrame(now, readings, notices), min(elapsed, _MOST * period)
