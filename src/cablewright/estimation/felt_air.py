"""The climate that cables creep in, by the readings of one sensor."""

from __future__ import annotations

import math
from collections import deque
from statistics import median
from typing import Final

from cablewright.models.creep_pace import Air
from cablewright.signals import Climate

_LAST: Final = 5  # readings, of whose temperatures and humidities the medians count: a spike is none of them


class FeltAir:
    """Medians of the last readings."""

    def __init__(self) -> None:
        self._readings: deque[Climate] = deque(maxlen=_LAST)

    def read(self, reading: Climate) -> Air | None:
        """Return what the air is after a *reading*; None before the first that has numbers."""
        if math.isfinite(reading.temperature) and math.isfinite(reading.humidity):
            self._readings.append(reading)
        if not self._readings:
            return None
        return Air(
            median(each.temperature for each in self._readings), median(each.humidity for each in self._readings)
        )
