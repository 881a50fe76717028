"""Creep of the cables of a machine, by the law of `models.creep`. All numbers here are assumed."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.simulated.snapshot import Archive
from cablewright.models.creep import RETARDATIONS, gains, log_elements, log_response, voigt_response, voigt_size

VOIGT_SHARES: Final = (0.2, 0.2)  # of the strain after an hour, by the elements of `RETARDATIONS`
LOG_SHARE: Final = 0.6


def step_response(times: Array) -> Array:
    """Return the creep at *times* (k,), s, after a load began, over that after an hour."""
    voigt = (share * voigt_response(times, time) for time, share in zip(RETARDATIONS, VOIGT_SHARES, strict=True))
    return np.asarray(sum(voigt) + LOG_SHARE * log_response(times))


def elements() -> tuple[Array, Array]:
    """Return retardation times (k,), s, and strains at the end of all time (k,), over the creep after an hour."""
    times, spread = log_elements()
    sizes = [share * voigt_size(time) for time, share in zip(RETARDATIONS, VOIGT_SHARES, strict=True)]
    return np.concatenate([RETARDATIONS, times]), np.concatenate([sizes, LOG_SHARE * spread])


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
            self._step = (period, *gains(period / self._times))
        _, gone, late = self._step
        load = gone * before[:, None] + late * (after - before)[:, None]
        self.stretched += self._sizes * load - gone * self.stretched

    def archive_state(self, archive: Archive) -> None:
        """Save or load the strains."""
        archive.array("creep", self.stretched)
