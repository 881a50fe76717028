"""Settings that change with the nozzle's height: rotation and retraction of the platform, exit points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import Field, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.units import Angle3, Length, Positive, Vec3
from cablewright.foundation.validation import Description, refusal
from cablewright.printing.modal import MAX_COORDINATE

MAX_STAGES: Final = 100
_Height = Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]


class Stage(Description):
    """Exit points from the layer at the nozzle height ``z`` (m) on.

    ``raised``: height of all exit points over those of the robot file, m. ``exit_points``: each of them instead, m,
    world, in the order of the lines of the robot file.
    """

    z: _Height
    raised: _Height | None = None
    exit_points: Annotated[tuple[Vec3, ...], Field(min_length=1, max_length=100)] | None = None

    @model_validator(mode="after")
    def _is_given_once(self) -> Self:
        if (self.raised is None) is (self.exit_points is None):
            raise refusal("raised", "give the exit points of a stage once: by raised, or by exit_points")
        return self


class ScheduleStep(Description):
    """Settings at the nozzle height ``z`` (m): a rotation vector (rad), a retraction length (m), or both."""

    z: _Height
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
