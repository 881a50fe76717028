"""The rule for times of readings and orders: which are new, which were repeated or overtaken, which are ahead.

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
    """How the time of a reading compares with the clock, and with the last reading of its source."""

    NEW = "new"
    OLD = "repeated or overtaken"
    AHEAD = "ahead of the clock, or without a time"


class ReadingTimes:
    """Time of the last new reading of each source, s. Changed by `judge`."""

    def __init__(self) -> None:
        """Begin without any reading."""
        self._last: dict[str, float] = {}
        self._ahead: dict[str, deque[float]] = {}  # of those that were ahead

    def judge(self, source: str, time: float, now: float) -> Timeliness:
        """Compare the *time* of a reading of *source* with *now*, s; a new one becomes the last of its source.

        One that was ahead, and whatever it overtook, is old once the clock has reached its time.
        """
        ahead = self._ahead.setdefault(source, deque(maxlen=_MOST))
        if not time <= now + CLOCK_TOLERANCE:
            if not math.isfinite(time):
                return Timeliness.AHEAD
            is_old = time <= max(ahead, default=-math.inf)
            ahead.append(time)
            return Timeliness.OLD if is_old else Timeliness.AHEAD
        reached = max((each for each in ahead if each <= now + CLOCK_TOLERANCE), default=-math.inf)
        while ahead and ahead[0] < reached:
            ahead.popleft()
        if time <= max(self._last.get(source, -math.inf), reached):
            return Timeliness.OLD
        self._last[source] = time
        return Timeliness.NEW

    def is_new(self, source: str, time: float, now: float) -> bool:
        """Whether a reading is `Timeliness.NEW`; see `judge`."""
        return self.judge(source, time, now) is Timeliness.NEW

    def last(self, source: str, otherwise: float = -math.inf) -> float:
        """Time of the last new reading of *source*, s; *otherwise* where there was none."""
        return self._last.get(source, otherwise)

    def clear(self) -> None:
        """Forget all readings, as when the clock was reset."""
        self._last.clear()
        self._ahead.clear()
