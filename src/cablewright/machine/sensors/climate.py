"""Data sheet of thermometer and hygrometer."""

from collections.abc import Mapping
from typing import ClassVar, Final

from cablewright.machine.quantities import Rate, Share, Size
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class ClimateSensor(SensorSheet):
    """Data of the sensor of temperature and relative humidity."""

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("climate_sensor")

    rate: Rate
    temperature_deviation: Size
    humidity_deviation: Share


CLIMATE: Final = Sensor(
    "climate", ClimateSensor, key="climate_sensor", noise=("temperature_deviation", "humidity_deviation")
)
