"""A line: one cable with all that it passes from the winch exit to the platform."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, StrictBool, model_validator

from cablewright.robot.cable import Cable
from cablewright.robot.sheave import Eyelet, Sheave, UniversalJoint
from cablewright.robot.winch import Winch
from cablewright.units import Force, Length, NonNegative, Vec3
from cablewright.validation import Description, refusal, require_rising

MAX_LINES = 64
"""Maximum number of lines of a robot."""

MAX_SPANS = 12
"""Maximum mechanical advantage, and maximum number of cables side by side."""

AXIS_TOLERANCE = 1e-9
"""Largest horizontal distance of a winch exit from the exit point of a sheave that turns, m: rounding."""


class Line(Description):
    """A cable with its winch, its sheave and its platform point.

    ``exit_point``: (3,) m, world: the eyelet, a point of the swivel's axis, or the centre of the universal joint.
    ``winch_exit``: (3,) m, world: start of the dead span. Without it the dead span is not modelled and adds
    ``dead_length`` (m) to the length. ``platform_point``: (3,) m, platform frame. ``tension_limits``: min and max, N.
    ``dead_elastic`` and ``arc_elastic``: whether the dead span and the cable on the sheave stretch.

    ``advantage``: the mechanical advantage, which is the number of spans between exit point and platform point: with 2
    the cable runs to a pulley on the platform and back. ``cables``: of one kind, side by side on one winch. Spans are
    taken as alike, from point to point, and pulleys as without friction; tension is that of one cable.
    """

    name: Annotated[str, Field(min_length=1, max_length=60)]
    exit_point: Vec3
    winch_exit: Vec3 | None = None
    dead_length: NonNegative[Length] = 0.0
    advantage: Annotated[int, Field(strict=True, ge=1, le=MAX_SPANS)] = 1
    cables: Annotated[int, Field(strict=True, ge=1, le=MAX_SPANS)] = 1
    dead_elastic: StrictBool = True
    arc_elastic: StrictBool = False
    platform_point: Vec3 = (0.0, 0.0, 0.0)
    cable: Cable
    sheave: Sheave
    winch: Winch = Winch()
    tension_limits: tuple[NonNegative[Force], NonNegative[Force]]

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        require_rising("tension_limits", self.tension_limits)
        if self.tension_limits[1] > self.cable.breaking_load:
            raise refusal("tension_limits", f"must end at or below the breaking load, {self.cable.breaking_load:g} N")
        if self.winch_exit is not None:
            self._check_dead_span(self.winch_exit)
        if self.advantage > 1 and not isinstance(self.sheave, Eyelet):
            raise refusal("advantage", "must be 1 over a sheave that turns; the ends of several spans are eyelets")
        if self.cables > 1 and isinstance(self.sheave, UniversalJoint):
            raise refusal("cables", "must be 1 on a universal joint, whose lever one cable balances")
        return self

    def _check_dead_span(self, winch_exit: Vec3) -> None:
        if self.dead_length:
            raise refusal("dead_length", "is for a dead span that is not modelled: leave out this or winch_exit")
        if winch_exit == self.exit_point:
            raise refusal("winch_exit", "must differ from exit_point")
        if isinstance(self.sheave, Eyelet):
            return
        offset = math.dist(winch_exit[:2], self.exit_point[:2])
        if offset > AXIS_TOLERANCE:
            where = f"is {offset:g} m off the vertical through exit_point"
            why = "a winch exit off the swivel axis leaves the cable's plane"
            raise refusal("winch_exit", f"{where}; {why}: put it on the axis, or leave it out and give dead_length")
        if self.sheave.wrap == "over" and winch_exit[2] >= self.exit_point[2]:
            raise refusal("winch_exit", "must be below exit_point for a cable that wraps over its sheave")
        if self.sheave.wrap == "under" and winch_exit[2] <= self.exit_point[2]:
            raise refusal("winch_exit", "must be above exit_point for a cable that wraps under its sheave")
