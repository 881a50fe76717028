"""Data sheet of the light barrier around the machine."""

from collections.abc import Mapping
from typing import ClassVar, Final

from cablewright.machine.quantities import Rate
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class BarrierSensor(SensorSheet):
    """Data of the light barrier around the machine."""

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("barrier") | {"intrusions": "[simulation.barrier]"}

    rate: Rate


BARRIER: Final = Sensor("barrier", BarrierSensor, noise=())
