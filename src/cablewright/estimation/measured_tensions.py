"""Measured tensions, smoothed, that accompany an estimate made by encoders alone."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Tensions


def smoothed(before: Array | None, readings: Iterable[Tensions], source: str, share: float, lines: int) -> Array | None:
    """Return tensions (m,), N, smoothed: they follow the *readings* of a *source* by a *share* of each difference.

    *before* (m,): the last ones; None: nothing was read yet. A line that is not read keeps its tension. A reading
    without a number for each of *lines* is not used.
    """
    for reading in readings:
        if reading.source == source and len(reading.tensions) == lines:
            known = reading.tensions if before is None else np.where(np.isnan(before), reading.tensions, before)
            change = share * (reading.tensions - known)
            before = np.where(np.isnan(reading.tensions), known, known + change)
    return before
