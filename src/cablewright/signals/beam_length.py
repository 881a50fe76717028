"""How long a platform that retracts is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cablewright.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class BeamLength(Reading):
    """Measured length of a platform that retracts."""

    SOURCES: ClassVar = (Source("retraction", stream=13, topic="/retraction"),)

    time: float  # s
    length: float  # m
