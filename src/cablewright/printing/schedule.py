"""Rotation and retraction of a rigid platform as the part grows, by the nozzle's height."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.units import Angle3, Length, Positive
from cablewright.foundation.validation import Description, refusal
from cablewright.printing.modal import MAX_COORDINATE


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
            raise refusal("rotation", "must be no longer than pi rad, half a turn: are these deg?")
        return self


@dataclass(frozen=True)
class Schedule:
    """Linear interpolation of settings between heights; constant below the lowest and above the highest."""

    steps: tuple[ScheduleStep, ...]  # in rising order

    @property
    def turns(self) -> bool:
        """Whether the schedule sets a rotation."""
        return any(step.rotation is not None for step in self.steps)

    def rotations(self, z: Array) -> Array:
        """Return rotation vectors (k, 3), rad, at heights *z* (k,), m; zero if the schedule has none.

        Each component is interpolated alone: rotations that differ much need steps between them.
        """
        known = [(step.z, *step.rotation) for step in self.steps if step.rotation is not None]
        at, *columns = np.transpose(known or [(0.0, 0.0, 0.0, 0.0)])
        return np.stack([np.interp(z, at, column) for column in columns], axis=-1)

    def retractions(self, z: Array) -> Array | None:
        """Return retraction lengths (k,), m, at heights *z* (k,), m; None if the schedule has none."""
        known = [(step.z, step.retraction) for step in self.steps if step.retraction is not None]
        return np.interp(z, *np.transpose(known)) if known else None
