"""Random periods (spells) during which an effect acts: a link outage, a push, a visit."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from cablewright.machine.simulated.as_built_parts import drawn

_WINDOW: Final = 1000  # spells on average, of those that are drawn together
_DRAWN: Final = 1200
_LONGEST_PAUSE: Final = 1e12  # s


class Spell(NamedTuple):
    """One random period, such as a person in the room: its begin and its end."""

    number: int
    begin: float  # s
    end: float  # s


class Spells:
    """Spells of uniformly distributed lengths, after pauses that are exponentially distributed.

    They follow from the seed and the time alone, so that there is no state to keep, and the next hour costs no more
    than the next year: they are drawn in windows of time, and one that would go on into the next window is left out.
    """

    def __init__(self, pause: float, lengths: tuple[float, float], seed: int, *which: int, begun: bool = False) -> None:
        """*pause*: s, its mean; *lengths*: s, the shortest and the longest; *which*: see `drawn`.

        With *begun* one may be under way at time 0, with the chance that one is at any time.
        """
        self._pause, self._lengths, self._seed, self._which = min(pause, _LONGEST_PAUSE), lengths, seed, which
        self._mean = 0.5 * (lengths[0] + lengths[1])
        self._window, self._begun = _WINDOW * (self._pause + self._mean), begun
        self._known = (-1, np.zeros(0), np.zeros(0))  # a window, and begins and ends in it, s from its start

    def at(self, time: float) -> Spell | None:
        """Return the spell at *time*, s from 0 on."""
        window = int(time // self._window)
        if self._known[0] != window:
            self._known = self._draw(window)
        _, begins, ends = self._known
        start = window * self._window
        i = int(np.searchsorted(begins, time - start, "right")) - 1
        if i < 0 or time - start >= ends[i]:
            return None
        return Spell(window * _DRAWN + i, start + float(begins[i]), start + float(ends[i]))

    def _draw(self, window: int) -> tuple[int, np.ndarray, np.ndarray]:
        """A window with the begins and ends in it."""
        random, (least, most) = drawn(self._seed, *self._which, window), self._lengths
        pauses, lengths = self._pause * random.exponential(size=_DRAWN), random.uniform(least, most, _DRAWN)
        chance, share = random.random(2)
        if window == 0 and self._begun and chance * (self._pause + self._mean) < self._mean:
            lengths[0] = np.sqrt(random.uniform(least**2, most**2))  # a long one is more likely to be under way
            pauses[0] = -share * lengths[0]
        ends = np.cumsum(pauses + lengths)
        inside = ends < self._window
        return window, (ends - lengths)[inside], ends[inside]
