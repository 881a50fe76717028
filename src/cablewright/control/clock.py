"""Clock of a control loop: monotonic, even if the machine's clock jumps or stops."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

from cablewright.foundation.reading_times import CLOCK_TOLERANCE
from cablewright.foundation.signals import Condition, Notice, Reading, SensorFrame

_SAME: Final = 1e-6  # of a period: elapsed times that differ by less count as a period: clocks round
_LATE: Final = 1.5  # periods after which a step is an overrun
_AHEAD: Final = 3600.0  # s after which no step was late, but the clock was set
_STAMPS: Final = 256  # of each source that are known again after a jump
_MOST: Final = 3.0  # periods for which the control goes on after a gap


class FrameClock:
    """Times of frames and readings, corrected so that each is later than the last."""

    def __init__(self, period: float, begin: float) -> None:
        """*period*: s, of a step as planned; *begin*: s, the time before the first frame."""
        self._period, self._begin, self._offset = period, begin, 0.0
        self._now: float | None = None
        self._jump = -math.inf  # s, when the machine's clock jumped
        self._stamps: dict[str, deque[float]] = {}  # s, of readings by their sources, since that jump ...
        self._before: dict[str, deque[float]] = {}  # ... and those of before

    @property
    def now(self) -> float:
        """Time of the last frame, s."""
        return self._begin if self._now is None else self._now

    def tell(self, frame: SensorFrame) -> tuple[SensorFrame, float]:
        """Return the frame with times by this clock, and the time since the last one, s, at most a few periods.

        A late frame has a notice. Where the machine's clock jumps, or is not a number, the frame has another; the times
        of all frames and readings from then on are shifted, so that this clock goes on by one period. Readings without
        a time are left out, and those of before a jump: their clock is unknown. So are those that repeat a stamp of
        before it: a frozen sensor's, which the clock has reached again.
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
            for source, stamps in self._stamps.items():
                self._before.setdefault(source, deque(maxlen=_STAMPS)).extend(stamps)
            self._stamps.clear()
        else:
            now = frame.time + self._offset
            if abs(elapsed - period) <= _SAME * period:
                elapsed = period
            elif elapsed > _LATE * period:
                notices = (*notices, Notice(Condition.OVERRUN))
        self._now = now
        readings = self._timely(frame)
        if now != frame.time or readings is not frame.readings or notices is not frame.notices:
            frame = SensorFrame(now, readings, notices)
        return frame, min(elapsed, _MOST * period)

    def _timely(self, frame: SensorFrame) -> tuple[Reading, ...]:
        """The readings of a frame by this clock."""
        timely = not self._offset
        for each in frame.readings:
            stamps, stamp = self._stamps.get(each.source), each.stamp
            if stamps is None:
                stamps = self._stamps[each.source] = deque(maxlen=_STAMPS)
            if not stamps or stamps[-1] != stamp:
                stamps.append(stamp)
            timely = timely and math.isfinite(each.time)
        if timely:
            return frame.readings
        known = (each for each in frame.readings if math.isfinite(each.time))
        anew = (each for each in known if each.stamp not in self._before.get(each.source, ()))
        shifted = (each.stamped(each.stamp + self._offset) for each in anew)
        return tuple(each for each in shifted if each.time > self._jump + CLOCK_TOLERANCE)
