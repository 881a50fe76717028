"""Whether somebody is near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cablewright.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Barrier(Reading):
    """Reading of the light barrier around the machine."""

    SOURCES: ClassVar = (Source("barrier", stream=8, topic="/barrier"),)

    time: float  # s
    broken: bool  # somebody interrupts the light
