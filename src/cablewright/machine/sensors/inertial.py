"""Data sheet of the inertial unit on the platform."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final

from pydantic import Field

from cablewright.foundation.units import Angle, NonNegative, Vec3
from cablewright.machine.quantities import Rate, Size
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class InertialSensor(SensorSheet):
    """Data of the accelerometer and gyro at ``place``.

    ``turn_deviation``: rad, of its mounting about each axis.
    """

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("inertial")

    rate: Rate
    place: Vec3
    acceleration_deviation: Size
    acceleration_bias: Size
    rate_deviation: Size
    rate_bias: Size
    turn_deviation: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


INERTIAL: Final = Sensor("inertial", InertialSensor, noise=("acceleration_deviation", "rate_deviation"))
