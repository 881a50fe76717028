"""How readings come to who listens: late, in the order sent, some never, none through a gap."""

from __future__ import annotations

from collections import deque

import numpy as np

from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.snapshot import Book
from cablewright.signals import Reading

__all__ = ["Channel"]


class Channel:
    """One link with what is on its way."""

    def __init__(self, settings: Link, random: np.random.Generator) -> None:
        """Begin empty; *random* decides on delays and losses."""
        self.settings, self._random = settings, random
        self._sent: deque[tuple[float, Reading]] = deque()
        self._last = 0.0  # when the last one sent arrives
        self.heard = 0.0  # s: when something arrived last

    def send(self, now: float, reading: Reading) -> None:
        """Put *reading* on its way at *now*, s."""
        late, lost = self._random.exponential(), self._random.random()
        if lost < self.settings.loss:
            return
        arrives = max(self._last, now + self.settings.latency + self.settings.jitter * late)
        for begin, end in self.settings.gaps:
            if begin <= arrives < end:
                arrives = end
        self._last = arrives
        self._sent.append((arrives, reading))

    def arrived(self, now: float) -> list[Reading]:
        """Take what has arrived by *now*, s."""
        readings = []
        while self._sent and self._sent[0][0] <= now:
            self.heard, reading = self._sent.popleft()
            readings.append(reading)
        return readings

    def keep(self, book: Book) -> None:
        """Note, or take up again, what is on its way."""
        self._sent = deque(book.readings("sent", tuple(self._sent)))
        self._last, self.heard = book.number("last", self._last), book.number("heard", self.heard)
        book.random("random", self._random)
