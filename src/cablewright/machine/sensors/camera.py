"""Data sheet of a calibrated camera in the room that sees tags on the platform."""

from __future__ import annotations

from typing import Annotated, Final, Self

import numpy as np
from pydantic import Field, Strict, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.units import Angle, NonNegative, Vec3
from cablewright.foundation.validation import Description, refusal
from cablewright.machine.quantities import Delay, Rate, Share, Span, Width
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet
from cablewright.robot.direction import Direction, facing

_Pixels = Annotated[int, Strict(), Field(ge=64, le=20_000)]
_CORNERS: Final = np.array([[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]])  # over the size of a tag


def _axes(key: str, normal: Direction, up: Direction) -> Array:
    """The axes (3, 3) to the right, to the top and along *normal*, in columns. Raises `refusal` of *key* for none."""
    try:
        return np.array(facing(normal, up)).T
    except ValueError as why:
        raise refusal(key, str(why)) from None


class PlatformTag(Description):
    """A tag on the platform: the side of its black square, its centre, and directions, platform frame.

    ``normal``: out of the paper; ``up``: to its top.
    """

    size: Span
    at: Vec3
    normal: Direction
    up: Direction = (0.0, 0.0, 1.0)

    @model_validator(mode="after")
    def _has_a_top(self) -> Self:
        _axes("up", self.normal, self.up)
        return self

    @property
    def corners(self) -> Array:
        """The corners (4, 3), m, platform frame."""
        return np.asarray(self.at + self.size * _CORNERS @ _axes("up", self.normal, self.up)[:, :2].T)


class CameraSensor(SensorSheet):
    """A camera in the room, calibrated, and the tags on the platform that it sees. Distortion is removed.

    ``at``: m, and ``looks``, ``up``: directions of its axis and of the top of its pictures, world. ``width``,
    ``height``, ``focal_length`` and ``corner_deviation``, the noise of one corner along each axis: px.
    ``place_deviation``, m, ``turn_deviation``, rad, and ``focal_deviation``, a share: standard deviations of its place
    along, and of its direction about each axis, and of the focal length. ``time_deviation``: s, of all times of
    exposure together.
    """

    rate: Rate
    at: Vec3
    looks: Direction
    up: Direction = (0.0, 0.0, 1.0)
    width: _Pixels
    height: _Pixels
    focal_length: Annotated[float, Field(ge=10.0, le=1e6)]
    corner_deviation: Annotated[float, Field(gt=0.0, le=100.0)]
    place_deviation: Annotated[Width, Field(le=1.0)] = 0.0
    turn_deviation: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    focal_deviation: Annotated[Share, Field(le=0.5)] = 0.0
    time_deviation: Annotated[Delay, Field(le=1.0)] = 0.0
    tags: Annotated[tuple[PlatformTag, ...], Field(min_length=1, max_length=50)]

    @model_validator(mode="after")
    def _has_a_top(self) -> Self:
        _axes("up", self.looks, self.up)
        return self

    @property
    def axes(self) -> Array:
        """The rotation (3, 3) from the camera's frame (x to the right, y down, z ahead) to the world."""
        return _axes("up", self.looks, self.up) * [-1.0, -1.0, 1.0]


CAMERA: Final = Sensor("camera", CameraSensor, noise=("corner_deviation",))
