"""Reading of the length of a platform that retracts."""

from dataclasses import dataclass

from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class BeamLength(Reading, sources=[Source("retraction", stream=13, topic="/retraction")]):
    """Measured length of a platform that retracts."""

    time: float  # s
    length: float  # m
