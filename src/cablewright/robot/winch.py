"""The winch: radius and capacity of its drum, its speed and torque; and whose drum a line is on instead."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Length, Positive, Speed, Torque
from cablewright.foundation.validation import Description, refusal

MAX_BUILD_UP = 1.0
"""Largest build-up of a drum, 1/m: half of its square gone after half a metre."""


class Winch(Description):
    """A winch. Each value may be unknown, None; a function that needs it then raises an error.

    ``max_speed``: highest speed of the cable; ``max_torque``: highest torque at the drum; ``capacity``: length of cable
    that the drum can hold.

    ``drum_radius``: m, to the axis of the cable that leaves the drum, of any length; or with a ``build_up`` where
    the line is ``drum_length`` (m, unstrained) long. ``build_up``: 1/m, share of its radius that the drum loses there
    per length paid out; its square falls linearly, as cable of a constant cross section leaves the spool.
    """

    drum_radius: Positive[Length] | None = None
    build_up: Annotated[float, Field(gt=0.0, le=MAX_BUILD_UP)] | None = None
    drum_length: Positive[Length] | None = None
    max_speed: Positive[Speed] | None = None
    max_torque: Positive[Torque] | None = None
    capacity: Positive[Length] | None = None

    @model_validator(mode="after")
    def _build_up_has_its_place(self) -> Self:
        if self.build_up is not None and (self.drum_radius is None or self.drum_length is None):
            raise refusal("build_up", "needs drum_radius, and drum_length, the length of the line where it is that")
        return self


class SharedWinch(Description):
    """The drum of another ``line``, on which the cable of this one is wound too.

    ``winds``: ``along``: both cables are paid out together, and the unstrained length of this line is ``offset`` (m)
    plus that of the other; ``against``: one is paid out as the other is wound up, and it is ``offset`` minus that.
    """

    line: Annotated[str, Field(min_length=1, max_length=60)]
    offset: Length = 0.0
    winds: Literal["along", "against"] = "along"

    @model_validator(mode="after")
    def _lengths_are_positive(self) -> Self:
        if self.winds == "against" and not self.offset > 0.0:
            raise refusal("offset", "must be over 0 m for cables that wind against each other: their lengths sum to it")
        return self

    @property
    def sense(self) -> float:
        """Return 1 where both cables are paid out together, else -1."""
        return 1.0 if self.winds == "along" else -1.0
