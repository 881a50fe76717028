"""How a platform leans, by a tilt meter."""

from dataclasses import dataclass

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class TiltMeter(Reading, sources=[Source("tilt_meter", stream=17, topic="/tilt_meter")]):
    """The upward direction along the platform's own x and y."""

    time: float  # s
    tilt: Array  # (2,)
