"""Creep of cables: two Voigt elements and logarithmic creep, with memory of the load.

The strain answers a constant load T from time 0 on by ``T c (s1 (1 - exp(-t / t1)) + s2 (1 - exp(-t / t2)) + s3
log(1 + t / t0))``, and several loads by the sum of their answers (Boltzmann). Spring and two Voigt elements: Piao et
al. 2017, doi 10.1177/1687814017737199; that creep goes on for hours: Choi and Park 2018, doi 10.1007/s00542-018-3820-7.
All numbers here are assumed: no usable ones of braided polyethylene were found.

The logarithm is itself a sum of Voigt elements, ``log(1 + a) = integral of (1 - exp(-a exp(v))) exp(-exp(v)) dv``, by
the trapezium rule: within 0.1 % from a hundredth of a second to eleven days. So all of the memory is the strain of each
element, which is advanced exactly for a load that changes linearly.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.simulated.snapshot import Archive

HOUR: Final = 3600.0  # s
VOIGT: Final = ((60.0, 0.2), (1200.0, 0.2))  # assumed: retardation time, s, and share of the strain after an hour
LOGARITHMIC: Final = (1.0, 0.6)  # assumed: t0, s, and share of the strain after an hour
_GRID: Final = np.arange(-19.0, 3.5, 1.0)  # of v
_SMALL: Final = 1e-4  # steps per retardation time, below which series are more exact


def step_response(times: Array) -> Array:
    """Return the creep at *times* (k,), s, after a load began, over that after an hour."""
    voigt = sum(share * _voigt(times, time) for time, share in VOIGT)
    begin, share = LOGARITHMIC
    return np.asarray(voigt + share * np.log1p(times / begin) / np.log1p(HOUR / begin))


def _voigt(times: Array, retardation: float) -> Array:
    """One element's answer, which is 1 after an hour."""
    return np.asarray(np.expm1(-times / retardation) / np.expm1(-HOUR / retardation))


def elements() -> tuple[Array, Array]:
    """Return retardation times (k,), s, and strains at the end of all time (k,), over the creep after an hour."""
    begin, share = LOGARITHMIC
    times = np.concatenate([[time for time, _ in VOIGT], begin * np.exp(-_GRID)])
    spread = share * np.exp(-np.exp(_GRID)) / np.log1p(HOUR / begin) * (_GRID[1] - _GRID[0])
    sizes = np.concatenate([[each / -np.expm1(-HOUR / time) for time, each in VOIGT], spread])
    return times, sizes


class CableCreep:
    """Creep of m lines, each by its own history of loads."""

    def __init__(self, compliances: Array) -> None:
        """*compliances* (m,): creep after an hour per load, 1/N; none has crept yet."""
        self._times, sizes = elements()
        self._sizes = np.multiply.outer(compliances, sizes)  # (m, k) 1/N
        self.stretched = np.zeros_like(self._sizes)  # strain of each element
        self._step = (0.0, np.zeros(0), np.zeros(0))

    @property
    def strain(self) -> Array:
        """Of each line, (m,)."""
        return np.asarray(self.stretched.sum(axis=1))

    def advance(self, before: Array, after: Array, period: float) -> None:
        """Advance by a *period*, s, in which loads change linearly from *before* to *after* (m,), N."""
        if period != self._step[0]:
            self._step = (period, *_factors(period / self._times))
        _, gone, late = self._step
        load = gone * before[:, None] + late * (after - before)[:, None]
        self.stretched += self._sizes * load - gone * self.stretched

    def archive_state(self, archive: Archive) -> None:
        """Save or load the strains."""
        archive.array("creep", self.stretched)


def _factors(steps: Array) -> tuple[Array, Array]:
    """What an element gains in so many retardation times *steps* (k,): of a constant load of 1, and of one that rises.

    1 - exp(-x), and 1 - (1 - exp(-x)) / x, by a load from 0 to 1.
    """
    gone = -np.expm1(-steps)
    series = steps * (0.5 - steps * (1.0 / 6.0 - steps / 24.0))
    return gone, np.where(steps < _SMALL, series, 1.0 - gone / np.maximum(steps, _SMALL))
