"""Climate (temperature and humidity) in which cables creep, from the readings of one sensor."""

from __future__ import annotations

from collections import deque
from statistics import median
from typing import Final

from cablewright.foundation.signals import Climate
from cablewright.models.climate_and_creep import COLDEST, HOTTEST, Air
from cablewright.models.creep import CreepMemory

_LAST: Final = 5  # readings, of whose numbers the median counts: a spike is none of them
_ENOUGH: Final = 3  # of them, before which a spike might be the median


class FeltAir:
    """Medians of the last readings of air temperature and humidity."""

    def __init__(self) -> None:
        self._heat: deque[float] = deque(maxlen=_LAST)
        self._damp: deque[float] = deque(maxlen=_LAST)

    def read(self, reading: Climate, *memories: CreepMemory) -> Air:
        """Return the climate after a *reading*; None for quantities with too few readings.

        The creep of *memories* follows it. Implausible values count as not measured.
        """
        if COLDEST <= reading.temperature <= HOTTEST:  # NaN is not
            self._heat.append(reading.temperature)
        if 0.0 <= reading.humidity <= 1.0:
            self._damp.append(reading.humidity)
        heat, damp = (median(each) if len(each) >= _ENOUGH else None for each in (self._heat, self._damp))
        air = Air(heat, damp)
        for memory in memories:
            memory.feel(air)
        return air
