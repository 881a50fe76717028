"""What the distance sensor under the valve measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from cablewright.signals.reading import OR_NAN, Reading, Source


@dataclass(frozen=True, eq=False)
class Distance(Reading):
    """Reading of the distance sensor under the valve."""

    SOURCES: ClassVar = (Source("distance", stream=5, topic="/distance", clock="drum"),)

    time: float  # s
    distance: Annotated[float, OR_NAN]  # m, along the drum's axis to the ground or material; NaN: no echo
