"""Sensors of a machine by data sheet and tape measure: positions, rates, ranges and noise.

A deviation is the noise of one reading; a bias is constant for one unit, and its number is the standard deviation over
all units of the kind. Each sensor has a module here: modules are found, not listed.
"""

from typing import Any, Final

from cablewright.foundation.discovery import declared
from cablewright.machine.sensors.sensor_declaration import Sensor

SENSORS: Final[tuple[Sensor[Any], ...]] = tuple(
    sorted(declared(__name__, __path__, Sensor), key=lambda sensor: sensor.stream)
)
"""All sensors that are read at a rate, by their streams."""
