"""How readings come to who listens: late, in the order sent, some never, none through a gap."""

from __future__ import annotations

from collections import deque

import numpy as np

from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import Reading

__all__ = ["Channel"]


class Channel:
    """One link with what is on its way."""

    def __init__(self, settings: Link, random: np.random.Generator) -> None:
        """Begin empty; *random* decides on delays and losses."""
        self.settings, self._random = settings, random
        self._sent: deque[tuple[float, Reading]] = deque()
        self._next_arrival = 0.0  # when the last one sent arrives
        self.last_arrival_time = 0.0  # s: when something arrived last

    def send(self, now: float, reading: Reading) -> None:
        """Put *reading* on its way at *now*, s."""
        late, lost = self._random.exponential(), self._random.random()
        if lost < self.settings.loss:
            return
        arrives = max(self._next_arrival, now + self.settings.latency + self.settings.jitter * late)
        for begin, end in self.settings.gaps:
            if begin <= arrives < end:
                arrives = end
        self._next_arrival = arrives
        self._sent.append((arrives, reading))

    def arrived(self, now: float) -> list[Reading]:
        """Take what has arrived by *now*, s."""
        readings = []
        while self._sent and self._sent[0][0] <= now:
            self.last_arrival_time, reading = self._sent.popleft()
            readings.append(reading)
        return readings

    def archive_state(self, archive: Archive) -> None:
        """Note, or take up again, what is on its way."""
        self._sent = deque(archive.readings("sent", tuple(self._sent)))
        self._next_arrival, self.last_arrival_time = (
            archive.number("last", self._next_arrival),
            archive.number("heard", self.last_arrival_time),
        )
        archive.random("random", self._random)
