"""Data sheet of the encoder of the platform's yaw drive."""

from typing import Final

from cablewright.foundation.units import Angle, NonNegative
from cablewright.machine.quantities import Rate
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet


class YawEncoder(SensorSheet):
    """Data of the encoder of the drive that turns the container about its axis, after its gear. ``deviation``: rad."""

    rate: Rate
    deviation: NonNegative[Angle] = 0.0


YAW_ENCODER: Final = Sensor("yaw_encoder", YawEncoder)
