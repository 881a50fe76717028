"""Creep of a simulated machine's cables beyond the described creep, by the law of `models.creep`.

All numbers here are assumed.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.creep import (
    LOG_SHARE,
    RETARDATIONS,
    VOIGT_SHARES,
    CreepMemory,
    log_elements,
    log_response,
    voigt_response,
    voigt_size,
)


def step_response(times: Array) -> Array:
    """Return the creep strain at *times* (k,), s, after a load begins, relative to that after an hour."""
    voigt = (share * voigt_response(times, time) for time, share in zip(RETARDATIONS, VOIGT_SHARES, strict=True))
    return np.asarray(sum(voigt) + LOG_SHARE * log_response(times))


def elements() -> tuple[Array, Array]:
    """Return retardation times (k,), s, and final strains (k,) of the creep law, relative to creep after an hour."""
    times, spread = log_elements()
    sizes = [share * voigt_size(time) for time, share in zip(RETARDATIONS, VOIGT_SHARES, strict=True)]
    return np.concatenate([RETARDATIONS, times]), np.concatenate([sizes, LOG_SHARE * spread])


class CableCreep(CreepMemory):
    """Creep of m lines, each by its own history of loads."""

    def __init__(self, compliances: Array) -> None:
        """*compliances* (m,): creep after an hour per load, 1/N; none has crept yet."""
        times, sizes = elements()
        super().__init__(times, np.multiply.outer(compliances, sizes))
