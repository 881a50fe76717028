"""Data sheet of the accelerometers on the lines."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final

from pydantic import Field

from cablewright.foundation.units import Angle, NonNegative
from cablewright.machine.quantities import Rate, Width
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet, moved_flaws


class LineSensor(SensorSheet):
    """Data of the accelerometers on the lines, ``from_platform`` along the cable before B.

    ``bias``: rad, of each one's zero.
    """

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("line_angles")

    rate: Rate
    from_platform: Width
    deviation: NonNegative[Angle]
    bias: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


LINE_ANGLES: Final = Sensor("line_angles", LineSensor)
