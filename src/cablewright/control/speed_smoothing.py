"""Speed changes that excite no swing: the running mean of the wanted speeds.

The two running means are those of `printing/shaping.py`, of the past alone: the speed comes late by half their length.
The response of a mode to the mean is that to the wanted speed, times the spectrum of the means.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.printing.shaping import LONG, SHORT

PeriodAt = Callable[[Array], float]
"""Period, s, of the slowest mode with the platform at a place (3,), m."""

_NONE: Final = np.zeros(0)
STEADY: Final = np.zeros((2, 1))
"""Rates of a speed that is no mean."""


@dataclass(eq=False)
class RampMean:
    """A moving mean of wanted speeds, changed in place.

    It is at rest until another speed is wanted, and again once all speeds of the mean are equal. Speeds are (d,), m/s
    or shares of a speed. Until the next `rest` the mean stays as long as it is.
    """

    rates: Array = field(default_factory=lambda: STEADY)
    """(2, d) 1/s of a speed: its changes of the last step and of this one; zero where it is no mean."""
    _past: Array = field(default_factory=lambda: _NONE)  # (k, d) wanted speeds, the last one first; k = 0: at rest
    _weights: Array = field(default_factory=lambda: _NONE)  # (k,)
    _same: int = 0  # steps with the same wanted speed

    @property
    def has_begun(self) -> bool:
        """Whether a mean was taken since the last `rest`."""
        return len(self._weights) > 0

    @property
    def is_steady(self) -> bool:
        """Whether the speed is the wanted one, and has been for as long as the mean takes."""
        return self.rates is STEADY and not len(self._past)

    def rest(self) -> None:
        """Forget the wanted speeds: the next speed is no mean."""
        self._past = self._weights = _NONE
        self.rates = STEADY

    def asked(self, now: Array) -> Array:
        """Return the last wanted speed (d,), or at rest the present speed *now* (d,)."""
        return self._past[0] if len(self._past) else now

    def pending(self, now: Array, dt: float) -> Array:
        """Return by which distance (d,), m, the wanted speeds are ahead of their mean, in steps of *dt*, s.

        *now* (d,): the present speed.
        """
        late = dt * (1.0 - np.cumsum(self._weights))
        return np.asarray(late @ self._past if len(self._past) else late.sum() * now)

    def take(self, now: Array, asked: Array, period: Callable[[], float], dt: float) -> Array:
        """Return the speed (d,) of the next *dt*, s, where *asked* (d,) is wanted and *now* (d,) is the present one.

        *period*: period of the slowest mode at the position where the mean begins, s.
        """
        if self.is_steady and now.tolist() == asked.tolist():
            return asked
        then = self._mean(now, asked, period, dt)
        rates = np.empty((2, len(then)))
        rates[0], rates[1] = self.rates[1], (then - now) / dt
        self.rates = rates if rates.any() else STEADY
        return then

    def _mean(self, now: Array, asked: Array, period: Callable[[], float], dt: float) -> Array:
        """Return the speed by `take`."""
        if not len(self._past):
            if np.array_equal(now, asked):
                return asked
            if not self.has_begun:
                whole = period()
                long, short = (max(round(share * whole / dt), 1) for share in (LONG, SHORT))
                self._weights = np.convolve(np.full(long, 1.0 / long), np.full(short, 1.0 / short))
            self._past, self._same = np.tile(now, (len(self._weights), 1)), 0
        self._same = self._same + 1 if np.array_equal(asked, self._past[0]) else 1
        self._past[1:] = self._past[:-1]
        self._past[0] = asked
        if self._same >= len(self._past):
            self._past = _NONE
            return asked
        return np.asarray(self._weights @ self._past)
