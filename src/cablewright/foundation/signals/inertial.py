"""Reading of the inertial unit on the platform."""

from dataclasses import dataclass

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Inertial(Reading, sources=[Source("inertial", stream=3, topic="/imu", clock="drum")]):
    """Reading of the inertial measurement unit (IMU) on the platform."""

    time: float  # s
    acceleration: Array  # (3,) m/s^2, drum: specific force, +g along z at rest
    rate: Array  # (3,) rad/s, drum
