"""How a rigid platform is held as the part grows: its rotation and its retraction, by the nozzle's height."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import BaseModel, ConfigDict, model_validator

from cablewright.arrays import Array
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.units import Angle3, Length, Positive


class ScheduleStep(BaseModel):
    """What is set at one height of the nozzle, m: a rotation vector (rad), a retraction length (m), or both."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    z: Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]
    rotation: Angle3 | None = None
    retraction: Positive[Length] | None = None

    @model_validator(mode="after")
    def _sets_something(self) -> Self:
        if self.rotation is None and self.retraction is None:
            raise ValueError("sets nothing: rotation or retraction is wanted")
        if self.rotation is not None and math.hypot(*self.rotation) > math.pi:
            raise ValueError("rotation is longer than pi, half a turn")
        return self


class Schedule:
    """Settings between heights: linear; constant below the lowest and above the highest, so that one holds always."""

    def __init__(self, heights: tuple[ScheduleStep, ...]) -> None:
        """Take *heights* in rising order."""
        self.heights = heights

    @property
    def turns(self) -> bool:
        """Whether it sets a rotation."""
        return any(height.rotation is not None for height in self.heights)

    def rotations(self, z: Array) -> Array:
        """Rotation vectors (k, 3), rad, at heights *z* (k,), m; none set is unrotated.

        Components are interpolated one by one: heights whose rotations differ much want others between them.
        """
        known = [(height.z, height.rotation) for height in self.heights if height.rotation is not None]
        if not known:
            return np.zeros((len(z), 3))
        at, values = zip(*known, strict=True)
        return np.stack([np.interp(z, at, part) for part in np.transpose(values)], axis=-1)

    def retractions(self, z: Array) -> Array | None:
        """Retraction lengths (k,), m, at heights *z* (k,), m; None where none is set."""
        known = [(height.z, height.retraction) for height in self.heights if height.retraction is not None]
        if not known:
            return None
        at, values = zip(*known, strict=True)
        return np.asarray(np.interp(z, at, values))
