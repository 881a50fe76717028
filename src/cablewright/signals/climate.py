"""Temperature and humidity of the room."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cablewright.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Climate(Reading):
    """Reading of the climate sensor."""

    SOURCES: ClassVar = (Source("climate", stream=7, topic="/climate"),)

    time: float  # s
    temperature: float  # degrees Celsius
    humidity: float  # relative, 0 to 1
