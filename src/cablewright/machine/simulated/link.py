"""Simulated link: readings arrive late and in order, some are lost, none pass during a gap."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Annotated, Any, Final

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Coded
from cablewright.foundation.signals import Reading
from cablewright.machine.log.messages import decode, encode
from cablewright.machine.simulated.as_built_parts import GAPS
from cablewright.machine.simulated.random_spells import Spells
from cablewright.machine.simulated.settings import Link

_MESSAGES: Final = TypeAdapter(
    list[tuple[Annotated[float, Field(strict=True, allow_inf_nan=False)], Annotated[str, Field(strict=True)], str]]
)


class Gaps:
    """Times without connection: planned ones, and random ones, which the seed alone determines."""

    def __init__(self, settings: Link, seed: int, number: int) -> None:
        """*number*: number of the link; each link has gaps of its own."""
        every, length = settings.gap_every, settings.gap_length
        self._planned = settings.gaps
        self._spells = Spells(every, (length, length), seed, GAPS, number) if every and length else None
        self.any = bool(self._planned) or self._spells is not None

    def end(self, time: float) -> float:
        """Return the next time with a connection from *time* on, s: *time*, or the end of a gap."""
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


def encode_readings(readings: Iterable[tuple[float, Reading]]) -> list[tuple[float, str, str]]:
    """Return *readings*, each with a number, as number, topic and message of a log."""
    encoded = ((number, *encode(reading, (), 1)) for number, reading in readings)
    return [(float(number), topic, data.decode()) for number, topic, data in encoded]


def decode_readings(messages: Any) -> deque[tuple[float, Reading]]:
    """Decode the output of `encode_readings`. Raises `InputError` for anything else."""
    try:
        rows = _MESSAGES.validate_python(messages)
    except ValidationError:
        raise InputError("a list of number, topic and message is expected") from None
    found = deque[tuple[float, Reading]]()
    for number, topic, text in rows:
        reading = decode(topic, text.encode(), "snapshot")
        if not isinstance(reading, Reading):
            raise InputError(f"{topic[:60]!r} is no topic of a reading")
        found.append((number, reading))
    return found


class Channel:
    """One simulated wireless link, with the readings in transit."""

    SAVED = (Coded("_sent", encode_readings, decode_readings), "_next_arrival", "last_arrival_time", "_random")

    def __init__(self, settings: Link, random: np.random.Generator, gaps: Gaps) -> None:
        """Begin empty; *random* decides on delays and losses."""
        self.settings, self._random, self._gaps = settings, random, gaps
        self._sent: deque[tuple[float, Reading]] = deque()
        self._next_arrival = 0.0  # s, when the last reading sent will arrive
        self.last_arrival_time = 0.0  # s

    def send(self, now: float, reading: Reading) -> None:
        """Send a *reading* over the link at *now*, s."""
        delay, lost, own = self._random.exponential(), self._random.random(), self.settings
        if lost < own.loss:
            return
        arrives = max(self._next_arrival, now + own.latency + own.jitter * delay)
        self._next_arrival = arrives = self._gaps.end(arrives) if self._gaps.any else arrives
        self._sent.append((arrives, reading))

    def arrived(self, now: float) -> list[Reading]:
        """Return the readings that have arrived by *now*, s."""
        readings: list[Reading] = []
        sent = self._sent
        while sent and sent[0][0] <= now:
            self.last_arrival_time, reading = sent.popleft()
            readings.append(reading)
        return readings
