"""Reading of the distance sensor under the valve."""

from dataclasses import dataclass
from typing import Annotated

from cablewright.foundation.signals.reading import OR_NAN, Reading, Source


@dataclass(frozen=True, eq=False)
class Distance(Reading, sources=[Source("distance", stream=5, topic="/distance", clock="drum")]):
    """Reading of the distance sensor under the valve."""

    time: float  # s
    distance: Annotated[float, OR_NAN]  # m, along the drum's axis to the ground or material; NaN: no echo
