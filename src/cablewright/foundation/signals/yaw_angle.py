"""Reading of the angle by which a drive has turned the container about its axis."""

from dataclasses import dataclass

from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class YawAngle(Reading, sources=[Source("yaw_encoder", stream=15, topic="/yaw_encoder")]):
    """Measured angle of the container's yaw drive, relative to its suspension."""

    time: float  # s
    angle: float  # rad, counter-clockwise seen from above
