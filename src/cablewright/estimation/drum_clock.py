"""The clock on the drum: its readings' times, as the machine's clock would have them.

A reading cannot arrive earlier than its shortest way over the link takes, so the least lag of many bounds how far the
drum's clock is ahead from one side; that the least one was read within a period bounds it from the other. Between both
bounds nothing is known; the filter estimates the rest by the motion that lidars see.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from dataclasses import dataclass, field
from typing import Final

from cablewright.signals import Distance, Inertial, LineAngles, Reading, Scan

_BUCKET: Final = 1.0  # s
_BUCKETS: Final = 20  # that count ...
_FULL: Final = 5  # ... and from which the least lag is about the shortest
_SUDDEN: Final = 2  # buckets of later readings alone, from which the clock is in doubt ...
_SET_BACK: Final = 10  # ... and after which it was set back: a link may be as late for seconds
_JITTER: Final = 0.02  # s, of the largest leads of a second
_JUMP: Final = 0.1  # s, or three periods, by which a clock that was set differs
_AGREE: Final = 3  # frames in a row, for a clock that was set forward
_STAMPED: Final = (Scan, Inertial, LineAngles, Distance)


@dataclass(frozen=True)
class ClockSettings:
    """What is known of the drum's clock.

    ``offset``: s, standard deviation at the start. ``drift``: of its rate. ``latency``: s, shortest time of a reading
    over the link.
    """

    offset: float
    drift: float
    latency: float


@dataclass(eq=False)
class DrumClock:
    """How far the drum's clock is ahead of the machine's, s; changed in place by each frame."""

    settings: ClockSettings
    ahead: float = 0.0
    period: float = 0.0  # s, of the machine's frames
    doubt: float = 0.0  # s by which it may have been set back: or the link is late
    _time: float = math.inf
    _leads: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_BUCKETS))  # begin, largest lead; s
    _sudden: int = 0  # frames in a row with a lead far beyond

    @property
    def sigma(self) -> float:
        """Standard deviation of what is left, s."""
        bounded = 0.5 * self.period
        if len(self._leads) < _FULL:
            return max(self.settings.offset, bounded)
        return bounded if self.settings.drift else min(self.settings.offset, bounded)

    def corrected(self, readings: tuple[Reading, ...], now: float) -> tuple[Reading, ...]:
        """Return the *readings* of a frame of time *now*, s, those of the drum by the machine's clock."""
        if not now > self._time:
            self.restart()
        self.period, self._time = max(0.0, now - self._time), now
        far = self._far()
        leads = [reading.time - now for reading in readings if isinstance(reading, _STAMPED)]
        leads = [lead for lead in leads if math.isfinite(lead)]
        if leads and self._is_stray(max(leads) > far):
            readings = tuple(each for each in readings if not (isinstance(each, _STAMPED) and each.time - now > far))
            leads = [lead for lead in leads if lead <= far]
        if not leads:
            return tuple(map(self._moved, readings))
        self._add(max(leads), now)
        largest = max(lead for _, lead in self._leads)
        self.doubt = max(0.0, largest - max(lead for _, lead in list(self._leads)[-_SUDDEN:]) - _JITTER)
        earliest = largest + self.settings.latency
        latest = earliest + self.period if len(self._leads) >= _FULL else math.inf
        self.ahead = min(max(self.ahead, earliest), latest)
        return tuple(map(self._moved, readings))

    def restart(self) -> None:
        """Forget the lags: the machine's clock was set."""
        self._leads.clear()
        self._time, self.doubt = math.inf, 0.0

    def _far(self) -> float:
        """Lead, s, from which a reading's stamp is no longer like those before."""
        return max(each for _, each in self._leads) + _JUMP if self._leads else math.inf

    def _is_stray(self, far: bool) -> bool:
        """Whether a *far* lead is one wrong stamp; a clock that was set forward goes on so."""
        self._sudden = self._sudden + 1 if far else 0
        return far and self._sudden < _AGREE

    def _add(self, lead: float, now: float) -> None:
        if self._leads and now - self._leads[-1][0] < _BUCKET:
            begin, before = self._leads[-1]
            self._leads[-1] = begin, max(before, lead)
            return
        late, recent = max(_JUMP, 3.0 * self.period), list(self._leads)[-_SET_BACK:]
        if recent and max(each for _, each in recent) < max(each for _, each in self._leads) - late:  # it was set back
            self._leads.clear()
            self._leads.extend(recent)
        self._leads.append((now, lead))

    def _moved(self, reading: Reading) -> Reading:
        if isinstance(reading, Scan):
            return dataclasses.replace(reading, begin=reading.begin - self.ahead)
        if isinstance(reading, Inertial | LineAngles | Distance):
            return dataclasses.replace(reading, time=reading.time - self.ahead)
        return reading
