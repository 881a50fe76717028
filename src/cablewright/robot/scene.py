"""The surroundings: gravity and the box the platform may be in."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from cablewright.robot.description import Description, refusal
from cablewright.units import Acceleration, Positive, Vec3

__all__ = ["Scene"]


class Scene(Description):
    """Gravity (along -z) and the box, from ``frame_min`` to ``frame_max`` (m, world), in which the platform may be."""

    gravity: Positive[Acceleration] = 9.81
    frame_min: Vec3
    frame_max: Vec3

    @model_validator(mode="after")
    def _box_has_a_volume(self) -> Self:
        for axis, low, high in zip("xyz", self.frame_min, self.frame_max, strict=True):
            if not low < high:
                raise refusal("frame_max", f"must be above frame_min in {axis}, where they are {high:g} and {low:g} m")
        return self
