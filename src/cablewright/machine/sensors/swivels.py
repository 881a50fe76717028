"""Data sheet of the encoders of swivelling sheaves."""

from typing import Annotated, Final

from pydantic import Field

from cablewright.foundation.units import Angle, NonNegative
from cablewright.machine.quantities import Rate
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet


class SwivelSensor(SensorSheet):
    """Data of the encoders of swivelling sheaves, whose angles are in rad.

    ``bias``: standard deviation of each angle's zero, rad.
    """

    rate: Rate
    deviation: NonNegative[Angle]
    bias: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


SWIVELS: Final = Sensor("swivels", SwivelSensor)
