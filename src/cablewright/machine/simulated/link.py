"""Simulated link: readings arrive late and in order, some are lost, none pass during a gap."""

from __future__ import annotations

import bisect
from collections import deque

import numpy as np

from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import Reading


class Gaps:
    """Times without connection: planned ones, and ones at random, which the seed alone determines."""

    def __init__(self, settings: Link, random: np.random.Generator) -> None:
        """*random* draws the times between the gaps, and nothing else."""
        self._settings, self._random = settings, random
        self._begins, self._ends = list[float](), list[float]()  # s, of gaps at random, as far as they are known

    def end(self, time: float) -> float:
        """Return when there is a connection again from *time* on, s: at once, or at the end of a gap."""
        while True:
            later = self._random_end(self._planned_end(time))
            if later == time:
                return time
            time = later

    def _planned_end(self, time: float) -> float:
        for begin, end in self._settings.gaps:
            if begin <= time < end:
                time = end
        return time

    def _random_end(self, time: float) -> float:
        every, length = self._settings.gap_every, self._settings.gap_length
        if not (every and length):
            return time
        while not self._ends or self._ends[-1] <= time:
            begin = (self._ends[-1] if self._ends else 0.0) + every * self._random.exponential()
            self._begins.append(begin)
            self._ends.append(begin + length)
        at = bisect.bisect_right(self._begins, time) - 1
        return self._ends[at] if at >= 0 and time < self._ends[at] else time


class Channel:
    """One link with the readings in transit."""

    def __init__(self, settings: Link, random: np.random.Generator, gaps: Gaps) -> None:
        """Begin empty; *random* decides on delays and losses."""
        self.settings, self._random, self._gaps = settings, random, gaps
        self._sent: deque[tuple[float, Reading]] = deque()
        self._next_arrival = 0.0  # s, when the last reading sent will arrive
        self.last_arrival_time = 0.0  # s

    def send(self, now: float, reading: Reading) -> None:
        """Send *reading* at *now*, s."""
        delay, lost = self._random.exponential(), self._random.random()
        if lost < self.settings.loss:
            return
        arrives = max(self._next_arrival, now + self.settings.latency + self.settings.jitter * delay)
        self._next_arrival = arrives = self._gaps.end(arrives)
        self._sent.append((arrives, reading))

    def arrived(self, now: float) -> list[Reading]:
        """Return the readings that have arrived by *now*, s."""
        readings = []
        while self._sent and self._sent[0][0] <= now:
            self.last_arrival_time, reading = self._sent.popleft()
            readings.append(reading)
        return readings

    def archive_state(self, archive: Archive) -> None:
        """Save or load the readings in transit. Gaps follow from the seed and the time."""
        self._sent = deque(archive.readings("sent", tuple(self._sent)))
        self._next_arrival = archive.number("last", self._next_arrival)
        self.last_arrival_time = archive.number("heard", self.last_arrival_time)
        archive.random("random", self._random)
