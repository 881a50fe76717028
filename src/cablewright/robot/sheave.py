"""The sheaves that guide a cable: an eyelet, a swivel, a universal joint or a pulley.

Also a swivel or a pulley on the platform, and a wheel between winch and sheave.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from annotated_types import Ge, Le
from pydantic import Field, model_validator

from cablewright.foundation.units import ANGLE, Angle, Force, Length, NonNegative, Positive, Vec3
from cablewright.foundation.validation import Description, refusal, require_rising
from cablewright.robot.direction import Direction, cross, unit_vector

Wrap = Literal["over", "under"]
"""``over``: the cable comes from below and passes over the sheave; ``under``: from above and under it."""

_SQUARE = 1e-9  # cosine of an angle that is a right one but for rounding

_HalfTurn = Annotated[float, Ge(-math.pi), Le(math.pi), ANGLE]


class Eyelet(Description):
    """No sheave: the cable bends at one point, the line's exit point."""

    kind: Literal["eyelet"] = "eyelet"


class _TurningSheave(Description):
    """What `Swivel` and `UniversalJoint` have in common."""

    radius: Positive[Length]
    wrap: Wrap = "over"
    facing: Angle | None = None
    swing: Positive[_HalfTurn] | None = None

    @model_validator(mode="after")
    def _swing_needs_facing(self) -> Self:
        if self.swing is not None and self.facing is None:
            raise refusal("swing", "needs facing, the azimuth it swings about")
        return self


class Swivel(_TurningSheave):
    """A sheave that turns about an axis through the exit point, with its centre ``radius`` from that axis.

    ``axis``: (3,) direction of the axis, world, of any length; vertical by default. ``wrap``: ``over`` for a cable that
    comes along the axis in that direction, ``under`` against it. ``facing``: azimuth that its mounting faces, 0 is
    world +x; ``swing``: how far it can turn to either side of that; both are of a vertical axis.
    """

    kind: Literal["swivel"] = "swivel"
    axis: Direction = (0.0, 0.0, 1.0)

    @property
    def upright(self) -> bool:
        """Whether the axis points straight up."""
        return unit_vector(self.axis) == (0.0, 0.0, 1.0)

    @property
    def axis_words(self) -> str:
        """The axis as the file has it."""
        return "a vertical axis" if self.upright else f"the axis ({', '.join(f'{x:g}' for x in self.axis)})"

    @model_validator(mode="after")
    def _facing_is_of_an_upright_axis(self) -> Self:
        if self.facing is not None and not self.upright:
            raise refusal("facing", "is an azimuth about a vertical axis: leave it out with this axis")
        return self


class Pulley(Description):
    """A sheave in a fixed plane: its centre is the exit point, and the line's winch exit lies in its plane.

    ``axis``: (3,) the axis that it turns on, world, of any length; the cable travels around it from winch to platform
    by the right-hand rule. Its groove takes what pulls out of the plane.
    """

    kind: Literal["pulley"] = "pulley"
    radius: Positive[Length]
    axis: Direction


class GuideSheave(Description):
    """A wheel that stands still, on which the cable lies between its winch and its exit point.

    ``centre``: (3,) m, world. ``axis``: (3,) the axis that it turns on, world, of any length; the cable travels around
    it from winch to platform by the right-hand rule. Its groove takes what pulls out of the plane, as that of `Pulley`.
    """

    centre: Vec3
    axis: Direction
    radius: Positive[Length]


class PlatformSheave(Description):
    """A sheave on the platform, which turns about an axis through the line's platform point.

    ``radius``: also the distance of its centre from that axis. ``axis``: (3,) direction of the axis, platform frame, of
    any length: the cable comes from the frame, passes over the sheave, and runs to its anchor against that direction.
    """

    radius: Positive[Length]
    axis: Direction


class PlatformPulley(Description):
    """A wheel that stands still on the platform, with its centre in the line's platform point.

    ``axis``: (3,) the axis that it turns on, platform frame, of any length. The cable comes from the frame, travels
    around it by the right-hand rule and ``leaves`` to its anchor in that direction, (3,) platform frame, across the
    axis; the line's length counts up to there. The groove takes what pulls out of the plane, as that of `Pulley`.
    """

    radius: Positive[Length]
    axis: Direction
    leaves: Direction

    @model_validator(mode="after")
    def _leaves_in_its_plane(self) -> Self:
        along = sum(a * b for a, b in zip(unit_vector(self.axis), unit_vector(self.leaves), strict=True))
        if abs(along) > _SQUARE:
            why = f"must be across the axis, in the plane of the wheel; its angle to the axis is {_degrees(along)} deg"
            raise refusal("leaves", why)
        return self

    @property
    def end_of_arc(self) -> Vec3:
        """Unit vector, platform frame, from the centre to where the cable leaves the wheel."""
        return cross(unit_vector(self.leaves), unit_vector(self.axis))


def _degrees(cosine: float) -> str:
    return f"{math.degrees(math.acos(min(1.0, max(-1.0, cosine)))):.6g}"


class UniversalJoint(_TurningSheave):
    """A sheave at the end of a lever that is free to turn in azimuth and elevation about the exit point.

    ``lever``: distance from the joint to the sheave's centre; ``lever_weight``: weight of all parts that move with the
    lever, N; ``lever_mass_centre``: distance of its centre of mass from the joint, along the lever. ``lever_range``:
    lowest and highest angle of the lever above the horizontal. ``facing`` and ``swing`` as for `Swivel`.
    """

    kind: Literal["universal-joint"] = "universal-joint"
    lever: Positive[Length]
    lever_weight: NonNegative[Force]
    lever_mass_centre: NonNegative[Length]
    lever_range: tuple[_HalfTurn, _HalfTurn] | None = None

    @model_validator(mode="after")
    def _lever_fits(self) -> Self:
        if self.lever < self.radius:
            raise refusal("lever", f"must be at least the sheave's radius, {self.radius:g} m")
        require_rising("lever_range", self.lever_range)
        return self


Sheave = Annotated[Eyelet | Swivel | UniversalJoint | Pulley, Field(discriminator="kind")]
