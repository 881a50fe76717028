"""Rotation and retraction of a rigid platform as the part grows, by the nozzle's height."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import model_validator

from cablewright.arrays import Array
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.units import Angle3, Length, Positive
from cablewright.validation import Description, refusal


class ScheduleStep(Description):
    """Settings at the nozzle height ``z`` (m): a rotation vector (rad), a retraction length (m), or both."""

    z: Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]
    rotation: Angle3 | None = None
    retraction: Positive[Length] | None = None

    @model_validator(mode="after")
    def _sets_something(self) -> Self:
        if self.rotation is None and self.retraction is None:
            raise ValueError("sets nothing: give rotation or retraction")
        if self.rotation is not None and math.hypot(*self.rotation) > math.pi:
            raise refusal("rotation", "must be no longer than pi, half a turn")
        return self


class Schedule:
    """Linear interpolation of settings between heights; constant below the lowest and above the highest."""

    def __init__(self, heights: tuple[ScheduleStep, ...]) -> None:
        """*heights* are in rising order."""
        self.heights = heights

    @property
    def turns(self) -> bool:
        """Whether it sets a rotation."""
        return any(height.rotation is not None for height in self.heights)

    def rotations(self, z: Array) -> Array:
        """Rotation vectors (k, 3), rad, at heights *z* (k,), m; zero where the schedule has none.

        Each component is interpolated alone: rotations that differ much need steps between them.
        """
        known = [(height.z, height.rotation) for height in self.heights if height.rotation is not None]
        if not known:
            return np.zeros((len(z), 3))
        at, values = zip(*known, strict=True)
        return np.stack([np.interp(z, at, part) for part in np.transpose(values)], axis=-1)

    def retractions(self, z: Array) -> Array | None:
        """Retraction lengths (k,), m, at heights *z* (k,), m; None where the schedule has none."""
        known = [(height.z, height.retraction) for height in self.heights if height.retraction is not None]
        if not known:
            return None
        at, values = zip(*known, strict=True)
        return np.asarray(np.interp(z, at, values))
