"""The sheave a cable leaves by: a plain eyelet, a sheave that swivels, or a sheave on a universal joint."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from annotated_types import Ge, Le
from pydantic import Field, model_validator

from cablewright.robot.description import Description, refusal
from cablewright.units import ANGLE, Angle, Force, Length, NonNegative, Positive

Wrap = Literal["over", "under"]
"""``over``: fed from below and laid over the sheave's top. ``under``: fed from above and laid under it."""

_HalfTurn = Annotated[float, Ge(-math.pi), Le(math.pi), ANGLE]


class Eyelet(Description):
    """No sheave: the cable turns in one point, the line's exit point."""

    kind: Literal["eyelet"] = "eyelet"


class Swivel(Description):
    """A sheave that turns about the vertical axis through the exit point; its centre is ``radius`` away from that axis.

    ``facing`` is the azimuth its mounting faces (0 is world +x) and ``swing`` how far it may turn to either side.
    """

    kind: Literal["swivel"] = "swivel"
    radius: Positive[Length]
    wrap: Wrap = "over"
    facing: Angle | None = None
    swing: Positive[_HalfTurn] | None = None

    @model_validator(mode="after")
    def _swing_needs_facing(self) -> Self:
        _check_swing(self)
        return self


class UniversalJoint(Description):
    """A sheave at the end of a lever which is free to turn in azimuth and elevation about the exit point.

    ``lever`` goes from the joint to the sheave's centre; ``lever_weight`` (N) is the weight of all that moves with it,
    acting ``lever_mass_centre`` from the joint along it. ``lever_range`` bounds its angle above the horizontal.
    ``facing`` and ``swing`` are as for `Swivel`.
    """

    kind: Literal["universal-joint"] = "universal-joint"
    radius: Positive[Length]
    lever: Positive[Length]
    lever_weight: NonNegative[Force]
    lever_mass_centre: NonNegative[Length]
    wrap: Wrap = "over"
    facing: Angle | None = None
    swing: Positive[_HalfTurn] | None = None
    lever_range: tuple[_HalfTurn, _HalfTurn] | None = None

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        _check_swing(self)
        if self.lever < self.radius:
            raise refusal("lever", f"must be at least the sheave's radius, {self.radius:g} m")
        if self.lever_range is not None and not self.lever_range[0] < self.lever_range[1]:
            raise refusal("lever_range", "must rise: the lowest angle, then the highest")
        return self


def _check_swing(sheave: Swivel | UniversalJoint) -> None:
    if sheave.swing is not None and sheave.facing is None:
        raise refusal("swing", "needs facing, the azimuth it swings about")


Sheave = Annotated[Eyelet | Swivel | UniversalJoint, Field(discriminator="kind")]
