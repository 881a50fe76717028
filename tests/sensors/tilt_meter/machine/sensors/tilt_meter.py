"""Data sheet of a tilt meter."""

from typing import Final

from cablewright.foundation.units import Angle, NonNegative
from cablewright.machine.quantities import Rate
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet


class TiltSheet(SensorSheet):
    """Noise and zero, standard deviations, rad."""

    rate: Rate
    deviation: NonNegative[Angle]
    bias: NonNegative[Angle] = 0.0


TILT_METER: Final = Sensor("tilt_meter", TiltSheet)
