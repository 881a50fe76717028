"""Data sheet of the distance sensor under the valve."""

from collections.abc import Mapping
from typing import ClassVar, Final

from cablewright.machine.quantities import Rate, Span, Width
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class DistanceSensor(SensorSheet):
    """Data of the sensor of the distance from the valve along the platform's axis."""

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("distance")

    rate: Rate
    least: Width
    most: Span
    deviation: Width


DISTANCE: Final = Sensor("distance", DistanceSensor)
