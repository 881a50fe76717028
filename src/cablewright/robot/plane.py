"""A plane that carries the platform across it: a board, a table, guides."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, Self

from pydantic import model_validator

from cablewright.foundation.units import Length, Vec3
from cablewright.foundation.validation import Description, refusal
from cablewright.robot.direction import Direction, unit_vector

LEVEL: Final = 1e-9
"""Share of a plane's normal that is not vertical, below which the plane is level."""

OFF_PLANE = 1e-6
"""Distance from its plane, m, and rotation out of it, rad, up to which a pose counts as in the plane, and is moved into
it: coordinates in mm with three decimals are 0.9 um off a tilted plane at most."""


class Plane(Description):
    """A plane in which the platform's origin stays; a rigid platform can rotate about the plane's normal only.

    ``normal``: (3,) world, across the plane, not zero, of any length. ``distance``: m, of the plane from the world's
    origin along the normal. The plane takes all forces along its normal, and from a rigid platform all moments about
    other axes. ``one_sided``: whether the plane only pushes, along its normal, as a board does; false: the plane holds
    both ways, as guides do; None: not given, and assumed to push only, which is the safe side. ``gcode_zero``: m,
    world, zero of G-code whose X and Y are along the plane (see `directions`) and whose Z moves the tool alone, as for
    wall plotters and routers; None: G-code is in the world's coordinates.
    """

    normal: Direction
    distance: Length = 0.0
    one_sided: bool | None = None
    gcode_zero: Vec3 | None = None

    @model_validator(mode="after")
    def _zero_is_in_it(self) -> Self:
        if self.gcode_zero is not None and abs(self.height(self.gcode_zero)) > OFF_PLANE:
            raise refusal("gcode_zero", f"is {self.height(self.gcode_zero):g} m off the plane: give a point in it")
        return self

    @property
    def across(self) -> Vec3:
        """Unit normal of the plane, in the direction of ``normal``."""
        return unit_vector(self.normal)

    @property
    def pulls(self) -> bool:
        """Whether the plane holds the platform in both directions."""
        return self.one_sided is False

    @property
    def axis(self) -> int | None:
        """The world's axis across the plane, from 0; None where the plane is tilted."""
        along = [k for k, number in enumerate(self.across) if number]
        return along[0] if len(along) == 1 else None

    @property
    def directions(self) -> tuple[Vec3, Vec3]:
        """Return two unit vectors in the plane, world: the first is level, the second points up the plane.

        Seen against the normal, the first points to the right. In a level plane they are x and y. In a plane that
        holds both ways the first points towards x.
        """
        x, y, z = self.across
        level = math.hypot(x, y)
        if self.pulls and (y > 0.0 or (y == 0.0 and x < 0.0)):
            x, y, z = -x, -y, -z
        right = (1.0, 0.0, 0.0) if level < LEVEL else (-y / level + 0.0, x / level + 0.0, 0.0)
        return right, (y * right[2] - z * right[1], z * right[0] - x * right[2], x * right[1] - y * right[0])

    def height(self, point: Iterable[float]) -> float:
        """Return the distance of a point (m, world) from the plane, positive along the normal."""
        return sum(a * b for a, b in zip(self.across, point, strict=True)) - self.distance

    def __str__(self) -> str:
        """The plane in words, for messages."""
        if self.axis is None:
            x, y, z = self.across
            return f"with normal {x:.4g}, {y:.4g}, {z:.4g} at {self.distance:g} m"
        return f"{'xyz'[self.axis]} = {self.distance * self.across[self.axis]:g} m"
