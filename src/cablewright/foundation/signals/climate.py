"""Reading of temperature and humidity of the room."""

from dataclasses import dataclass

from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Climate(Reading, sources=[Source("climate", stream=7, topic="/climate")]):
    """Reading of the climate sensor."""

    time: float  # s
    temperature: float  # degrees Celsius
    humidity: float  # relative, 0 to 1
