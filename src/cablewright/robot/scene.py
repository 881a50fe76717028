"""The surroundings: gravity, the box the platform may be in, and the beams of the frame."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from cablewright.robot.description import Description, refusal
from cablewright.units import Acceleration, Length, Positive, Vec3

MAX_SHAPES = 200
"""Beams of a frame, or boxes of a platform, at most."""


class Beam(Description):
    """A round bar of the frame that lines may touch: from ``start`` to ``end`` (m, world), rounded at both."""

    start: Vec3
    end: Vec3
    radius: Positive[Length]


class Scene(Description):
    """Gravity (along -z) and the box, from ``frame_min`` to ``frame_max`` (m, world), in which the platform may be.

    ``beams``: what lines may touch of the frame.
    """

    gravity: Positive[Acceleration] = 9.81
    frame_min: Vec3
    frame_max: Vec3
    beams: Annotated[tuple[Beam, ...], Field(max_length=MAX_SHAPES)] = ()

    @model_validator(mode="after")
    def _box_has_a_volume(self) -> Self:
        for axis, low, high in zip("xyz", self.frame_min, self.frame_max, strict=True):
            if not low < high:
                raise refusal("frame_max", f"must be above frame_min in {axis}, where they are {high:g} and {low:g} m")
        return self
