"""Reading of the angles of the swivelling sheaves."""

from dataclasses import dataclass
from typing import Annotated

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import PerLine, Reading, Source


@dataclass(frozen=True, eq=False)
class Swivels(Reading, sources=[Source("swivels", stream=14, topic="/swivels")]):
    """Angles of the swivelling sheaves: of each line's vertical plane in plan view, from x towards y."""

    time: float  # s
    angles: Annotated[Array, PerLine("rad")]  # (m,) -pi to pi; NaN: not measured
