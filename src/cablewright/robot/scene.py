"""The surroundings: gravity, the box in which the platform may be, and the beams of the frame."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Acceleration, Length, NonNegative, Positive, Vec3
from cablewright.foundation.validation import Description, require_box

MAX_SHAPES = 200
"""Maximum number of beams of a frame, or of boxes of a platform."""


class Beam(Description):
    """A round bar of the frame that lines may touch: from ``start`` to ``end`` (m, world), rounded at both."""

    start: Vec3
    end: Vec3
    radius: Positive[Length]


class Scene(Description):
    """Gravity (along -z) and the box from ``frame_min`` to ``frame_max`` (m, world) in which the platform may be.

    ``beams``: the parts of the frame that lines may touch.
    """

    gravity: NonNegative[Acceleration] = 9.81
    frame_min: Vec3
    frame_max: Vec3
    beams: Annotated[tuple[Beam, ...], Field(max_length=MAX_SHAPES)] = ()

    @model_validator(mode="after")
    def _box_has_a_volume(self) -> Self:
        require_box("frame_min", self.frame_min, "frame_max", self.frame_max)
        return self
