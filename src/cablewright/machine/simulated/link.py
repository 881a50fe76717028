"""Simulated link: readings arrive late and in order, some are lost, none pass during a gap."""

from __future__ import annotations

from collections import deque

import numpy as np

from cablewright.machine.simulated.as_built_parts import GAPS
from cablewright.machine.simulated.settings import Link
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.spells import Spells
from cablewright.signals import Reading


class Gaps:
    """Times without connection: planned ones, and ones at random, which the seed alone determines."""

    def __init__(self, settings: Link, seed: int, number: int) -> None:
        """*number*: of the link; each has gaps of its own."""
        every, length = settings.gap_every, settings.gap_length
        self._planned = settings.gaps
        self._spells = Spells(every, (length, length), seed, GAPS, number) if every and length else None

    def end(self, time: float) -> float:
        """Return when there is a connection again from *time* on, s: at once, or at the end of a gap."""
        while True:
            later = time
            for begin, end in self._planned:
                if begin <= later < end:
                    later = end
            spell = None if self._spells is None else self._spells.at(later)
            later = later if spell is None else spell.end
            if later == time:
                return time
            time = later


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
