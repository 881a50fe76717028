"""Data of a retraction's drive, and of the sensor of its length."""

from typing import Annotated, Final, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Force, Mass, NonNegative, Positive, Vec3
from cablewright.foundation.validation import refusal
from cablewright.machine.quantities import Delay, Rate, Span, Width
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet


class RetractionDrive(SensorSheet):
    """The drive of a platform's retraction, and the sensor of its length.

    ``max_speed``: m/s; ``max_force``: N along the beam; ``lag``: s. ``moving_mass``: kg of ``empty_mass`` that moves
    with the platform points, its centre at ``moving_centre``, (3,) m, platform frame, at the ``length``, m, at which
    the robot's centre of mass and inertia are given too. ``rate``: Hz, and ``deviation``: m, standard deviation of a
    reading of the length.
    """

    max_speed: Annotated[float, Field(gt=0.0, le=100.0)]
    max_force: Positive[Force]
    lag: Delay = 0.0
    moving_mass: NonNegative[Mass] = 0.0
    moving_centre: Vec3 = (0.0, 0.0, 0.0)
    length: Span | None = None
    rate: Rate
    deviation: Width = 0.0

    @model_validator(mode="after")
    def _place_is_known(self) -> Self:
        if self.moving_mass and self.length is None:
            raise refusal("length", "must be given where moving_mass is")
        return self


RETRACTION: Final = Sensor("retraction", RetractionDrive)
