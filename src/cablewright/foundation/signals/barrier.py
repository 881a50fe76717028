"""Reading of the light barrier: whether a person is near the machine."""

from dataclasses import dataclass

from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Barrier(Reading, sources=[Source("barrier", stream=8, topic="/barrier")]):
    """Reading of the light barrier around the machine."""

    time: float  # s
    broken: bool  # somebody interrupts the light
