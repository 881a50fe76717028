"""Consistency of each sensor: whether its innovations are as large as the filter expects.

Normalised innovations squared have a mean of 1 for each degree of freedom where model and noise are right. Far larger
ones say that a sensor, or its data sheet, is worse than the covariance assumes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

_MEMORY: Final = 100  # measurements
_ENOUGH: Final = 30  # measurements, before it is judged
LARGE: Final = 4.0
"""Mean from which a sensor is inconsistent ..."""
_SMALL: Final = 2.0  # ... and below which it no longer is


@dataclass(eq=False)
class Consistency:
    """Running means of normalised innovations squared by sensor, changed in place."""

    _counts: dict[str, int] = field(default_factory=dict)
    _means: dict[str, float] = field(default_factory=dict)
    _shown: Mapping[str, float] | None = None

    @property
    def means(self) -> Mapping[str, float]:
        """Mean of each sensor's normalised innovations squared over their degrees of freedom, about 1."""
        if self._shown is None:
            self._shown = {sensor: round(mean, 3) for sensor, mean in self._means.items()}
        return self._shown

    def add(self, sensor: str, nis: float, freedoms: int) -> bool | None:
        """Add an innovation; return whether the sensor is consistent, None where that is not certain."""
        count = self._counts[sensor] = self._counts.get(sensor, 0) + 1
        before = self._means.get(sensor, 0.0)
        mean = self._means[sensor] = before + (nis / freedoms - before) / min(count, _MEMORY)
        self._shown = None
        if count < _ENOUGH or _SMALL <= mean <= LARGE:
            return None
        return mean < _SMALL
