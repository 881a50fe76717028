"""Simulated link: readings arrive late and in order, some are lost, none pass during a gap."""

from __future__ import annotations

from collections import deque

import numpy as np

from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import Reading


class Channel:
    """One link with the readings in transit."""

    def __init__(self, settings: Link, random: np.random.Generator) -> None:
        """Begin empty; *random* decides on delays and losses."""
        self.settings, self._random = settings, random
        self._sent: deque[tuple[float, Reading]] = deque()
        self._next_arrival = 0.0  # s, when the last reading sent will arrive
        self.last_arrival_time = 0.0  # s

    def send(self, now: float, reading: Reading) -> None:
        """Send *reading* at *now*, s."""
        delay, lost = self._random.exponential(), self._random.random()
        if lost < self.settings.loss:
            return
        arrives = max(self._next_arrival, now + self.settings.latency + self.settings.jitter * delay)
        for begin, end in self.settings.gaps:
            if begin <= arrives < end:
                arrives = end
        self._next_arrival = arrives
        self._sent.append((arrives, reading))

    def arrived(self, now: float) -> list[Reading]:
        """Return the readings that have arrived by *now*, s."""
        readings = []
        while self._sent and self._sent[0][0] <= now:
            self.last_arrival_time, reading = self._sent.popleft()
            readings.append(reading)
        return readings

    def archive_state(self, archive: Archive) -> None:
        """Save or load the readings in transit."""
        self._sent = deque(archive.readings("sent", tuple(self._sent)))
        self._next_arrival = archive.number("last", self._next_arrival)
        self.last_arrival_time = archive.number("heard", self.last_arrival_time)
        archive.random("random", self._random)
