"""Rule for times of readings and orders: which are new, repeated, out of order, or ahead of the clock.

Guard, supervisor, procedures, orders and estimators follow it. A time is that of the measurement, or of the order, and
not that of the frame in which it arrives.
"""

from __future__ import annotations

import math
from collections import deque
from enum import Enum
from typing import Final

CLOCK_TOLERANCE: Final = 1e-6
"""Time, s, by which a reading may be ahead of its frame."""

_MOST: Final = 1024  # times of readings that were ahead, of a source


class Timeliness(Enum):
    """Age of a reading by the clock, and its order among the readings of its source."""

    NEW = "new"
    OLD = "repeated or overtaken"
    AHEAD = "ahead of the clock, or without a time"


class ReadingTimes:
    """Time of the last new reading of each source, s. Changed by `judge`."""

    def __init__(self) -> None:
        """Begin without any reading."""
        self.times: dict[str, float] = {}  # s, of the last new reading of each source
        self._ahead: dict[str, deque[float]] = {}  # of those that were ahead

    def judge(self, source: str, time: float, now: float) -> Timeliness:
        """Compare the *time* of a reading of *source* with *now*, s; a new one becomes the last of its source.

        One that was ahead is old when it is repeated. One that it overtook counts as ahead as well, also when the clock
        has reached its time: it may be as old as that, or its source's clock was put right.
        """
        last, ahead, reached = self.times.get(source, -math.inf), self._ahead.get(source), now + CLOCK_TOLERANCE
        if not ahead and last < time <= reached:
            self.times[source] = time
            return Timeliness.NEW
        if ahead is None:
            ahead = self._ahead[source] = deque(maxlen=_MOST)
        if time <= last or time in ahead:
            return Timeliness.OLD
        if not time <= reached or (ahead and any(time <= each <= reached for each in ahead)):
            if math.isfinite(time):
                ahead.append(time)
            return Timeliness.AHEAD
        self.times[source] = time
        while ahead and ahead[0] <= time:
            ahead.popleft()
        return Timeliness.NEW

    def is_new(self, source: str, time: float, now: float) -> bool:
        """Whether a reading is `Timeliness.NEW`; see `judge`."""
        return self.judge(source, time, now) is Timeliness.NEW

    def last(self, source: str, otherwise: float = -math.inf) -> float:
        """Time of the last new reading of *source*, s; *otherwise* where there was none."""
        return self.times.get(source, otherwise)

    def clear(self) -> None:
        """Forget all readings, as when the clock was reset."""
        self.times.clear()
        self._ahead.clear()
