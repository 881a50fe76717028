"""One line: everything from a winch's exit to the platform that one cable passes."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, StrictBool, model_validator

from cablewright.robot.cable import Cable
from cablewright.robot.description import Description, refusal
from cablewright.robot.sheave import Eyelet, Sheave, Swivel, UniversalJoint
from cablewright.robot.winch import Winch
from cablewright.units import Force, Length, NonNegative, Vec3

AXIS_TOLERANCE = 1e-9
"""How far a winch exit may be off the vertical through the exit point, m: rounding, not geometry."""


class Line(Description):
    """A cable with its winch, its sheave and the point it is tied to.

    ``exit_point``: (3,) m, world: the eyelet, a point of the swivel's axis, or the centre of the universal joint.
    ``winch_exit``: (3,) m, world: where the dead span begins. Without it the dead span is not modelled and counts
    ``dead_length`` (m). ``platform_point``: (3,) m, platform frame. ``tension_limits``: lowest and highest, N.
    ``dead_elastic`` and ``arc_elastic`` say whether the dead span and the cable on the sheave stretch.
    """

    name: Annotated[str, Field(min_length=1, max_length=60)]
    exit_point: Vec3
    winch_exit: Vec3 | None = None
    dead_length: NonNegative[Length] = 0.0
    dead_elastic: StrictBool = True
    arc_elastic: StrictBool = False
    platform_point: Vec3 = (0.0, 0.0, 0.0)
    cable: Cable
    sheave: Sheave
    winch: Winch = Winch()
    tension_limits: tuple[NonNegative[Force], NonNegative[Force]]

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        self._check_tension_limits()
        if self.winch_exit is not None:
            self._check_dead_span(self.winch_exit)
        return self

    def _check_tension_limits(self) -> None:
        low, high = self.tension_limits
        if not low < high:
            raise refusal("tension_limits", "must rise: the lowest tension, then the highest")
        if high > self.cable.breaking_load:
            raise refusal("tension_limits", f"must end at or below the breaking load, {self.cable.breaking_load:g} N")

    def _check_dead_span(self, winch_exit: Vec3) -> None:
        if self.dead_length:
            raise refusal("dead_length", "is for a dead span that is not modelled: leave out this or winch_exit")
        if winch_exit == self.exit_point:
            raise refusal("winch_exit", "must differ from exit_point")
        if not isinstance(self.sheave, Eyelet):
            self._check_feed(winch_exit, self.sheave)

    def _check_feed(self, winch_exit: Vec3, sheave: Swivel | UniversalJoint) -> None:
        offset = math.dist(winch_exit[:2], self.exit_point[:2])
        if offset > AXIS_TOLERANCE:
            where = f"is {offset:g} m off the vertical through exit_point"
            why = "a winch exit off the swivel axis leaves the cable's plane"
            raise refusal("winch_exit", f"{where}; {why}: put it on the axis, or leave it out and give dead_length")
        if sheave.wrap == "over" and winch_exit[2] >= self.exit_point[2]:
            raise refusal("winch_exit", "must be below exit_point for a cable that wraps over its sheave")
        if sheave.wrap == "under" and winch_exit[2] <= self.exit_point[2]:
            raise refusal("winch_exit", "must be above exit_point for a cable that wraps under its sheave")
