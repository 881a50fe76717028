"""Data sheet of the encoders of the winches' motors."""

from collections.abc import Mapping
from typing import ClassVar, Final

from cablewright.machine.quantities import Rate
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class Encoder(SensorSheet):
    """Data of the encoders of the winches' motors."""

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("encoders")

    rate: Rate


ENCODERS: Final = Sensor("encoders", Encoder, noise=())
