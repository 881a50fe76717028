"""Offset of the platform's clock from the machine's clock, estimated from the stamps of wireless messages.

A reading cannot arrive earlier than the link's shortest latency, so the smallest lag of many bounds the offset from one
side. Since the newest reading is at most a period old, or another known time, the same lag bounds it from the other.
Between both bounds nothing is known; the filter estimates the rest by the motion that lidars measure.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

_BUCKET: Final = 1.0  # s
_BUCKETS: Final = 20  # that count ...
_FULL: Final = 5  # ... and from which the least lag is about the shortest
_SUDDEN: Final = 2  # buckets of later readings alone, from which the clock is in doubt ...
_SET_BACK: Final = 10  # ... and after which it was set back: a link may be as late for seconds
_JITTER: Final = 0.02  # s, of the largest leads of a second
_JUMP: Final = 0.1  # s, or three periods, by which a clock that was set differs
_AGREE: Final = 3  # frames in a row, for a clock that was set forward


@dataclass(frozen=True)
class ClockLeadSettings:
    """Known properties of the platform's clock.

    ``offset``: s, standard deviation at the start. ``drift``: standard deviation of its rate. ``latency``: s, shortest
    time of a reading over the link. ``age``: s, how old the youngest of a frame may be beyond that; None: as the
    machine's period.
    """

    offset: float
    drift: float
    latency: float
    age: float | None = None


@dataclass(eq=False)
class ClockLead:
    """Lead of the platform's clock over the machine's, s; changed in place by each frame."""

    settings: ClockLeadSettings
    ahead: float = 0.0
    period: float = 0.0  # s, of the machine's frames
    doubt: float = 0.0  # s by which it may have been set back: or the link is late
    _time: float = math.inf
    _leads: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_BUCKETS))  # begin, largest lead; s
    _sudden: int = 0  # frames in a row with a lead far beyond

    @property
    def sigma(self) -> float:
        """Standard deviation of the estimated lead of the platform's clock, s."""
        since = self._time - self._leads[0][0] if self._leads else 0.0
        bounded = max(0.5 * self._age, self.settings.drift * since)
        if len(self._leads) < _FULL:
            return max(self.settings.offset, bounded)
        return bounded if self.settings.drift else min(self.settings.offset, bounded)

    def hear(self, stamps: Iterable[float], now: float) -> float:
        """Update the bounds of the clock's lead by the *stamps*, s, of messages that arrived by *now*, s.

        Returns how far ahead of *now*, s, a stamp is wrong; infinity where none is. Subtract ``ahead`` from all others.
        """
        if not now > self._time:
            self.restart()
        self.period, self._time = max(0.0, now - self._time), now
        far, wrong = self._far(), math.inf
        leads = [stamp - now for stamp in stamps if math.isfinite(stamp - now)]
        if leads and self._is_stray(max(leads) > far):
            leads, wrong = [lead for lead in leads if lead <= far], far
        if leads:
            self._learn(leads, now)
        return wrong

    def _learn(self, leads: list[float], now: float) -> None:
        self._add(max(leads), now)
        largest = max(lead for _, lead in self._leads)
        self.doubt = max(0.0, largest - max(lead for _, lead in list(self._leads)[-_SUDDEN:]) - _JITTER)
        earliest = largest + self.settings.latency
        latest = earliest + self._age if len(self._leads) >= _FULL else math.inf
        self.ahead = min(max(self.ahead, earliest), latest)

    def restart(self) -> None:
        """Forget the observed lags: the machine's clock was set."""
        self._leads.clear()
        self._time, self.doubt = math.inf, 0.0

    @property
    def _age(self) -> float:
        """How old the youngest reading of a frame may be besides the latency, s."""
        return self.period if self.settings.age is None else self.settings.age

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
