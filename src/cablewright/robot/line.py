"""A line: one cable with its winch, guides and platform point."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Self

from pydantic import Discriminator, Field, StrictBool, Tag, model_validator

from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Force, Length, Mass, NonNegative, Positive, Stiffness, Vec3
from cablewright.foundation.validation import Description, refusal, require_rising
from cablewright.robot.cable import Cable
from cablewright.robot.dead_span import DeadSpan, Guide, dead_span
from cablewright.robot.direction import unit_vector
from cablewright.robot.mount import Compliance, compliance_matrix
from cablewright.robot.sheave import (
    Eyelet,
    GuideSheave,
    PlatformPulley,
    PlatformSheave,
    Pulley,
    Sheave,
    Swivel,
    UniversalJoint,
)
from cablewright.robot.winch import SharedWinch, Winch

MAX_LINES = 64
"""Maximum number of lines of a robot."""

MAX_SPANS = 12
"""Maximum mechanical advantage, and maximum number of cables side by side."""

MAX_GUIDES = 24
"""Maximum number of eyelets and wheels between winch exit and exit point."""

AXIS_TOLERANCE = 1e-9
"""Distance up to which a winch exit is on a swivel's axis, or in a pulley's plane, m: rounding."""


def _guide_tag(given: object) -> str:
    """Return which of `Guide` a value of a file is, in brackets: `validation` leaves such a tag out."""
    return "[wheel]" if isinstance(given, dict | GuideSheave) else "[point]"


_Guide = Annotated[Annotated[Vec3, Tag("[point]")] | Annotated[GuideSheave, Tag("[wheel]")], Discriminator(_guide_tag)]


def _end_tag(given: object) -> str:
    """As `_guide_tag`, of a sheave on the platform."""
    still = isinstance(given, PlatformPulley) or (isinstance(given, dict) and "leaves" in given)
    return "[pulley]" if still else "[swivel]"


_End = Annotated[
    Annotated[PlatformSheave, Tag("[swivel]")] | Annotated[PlatformPulley, Tag("[pulley]")], Discriminator(_end_tag)
]


class Line(Description):
    """A cable with its winch, its sheave and its platform point.

    ``exit_point``: (3,) m, world: the eyelet, a point of the swivel's axis, or the centre of the universal joint or of
    the pulley.
    ``winch_exit``: (3,) m, world: start of the dead span. Without it the dead span is not modelled and adds
    ``dead_length`` (m) to the length. ``platform_point``: (3,) m, platform frame. ``tension_limits``: min and max, N.
    ``dead_elastic`` and ``arc_elastic``: whether the dead span and the cable on the sheave stretch.

    ``advantage``: the mechanical advantage, which is the number of spans between exit point and platform point: with 2
    the cable runs to a pulley on the platform and back. ``cables``: number of equal cables side by side on one winch.
    Spans are taken as equal, from point to point, and pulleys as frictionless; tension is that of one cable.

    ``guides``: eyelets, (3,) m, world, and wheels that the cable passes from the winch exit on, before the exit point.
    ``platform_sheave``: sheave on the platform on which the cable ends, instead of at its platform point.

    ``exit_compliance``: m/N, by which the mount of the exit point is displaced per force of the cable on it: that of
    the free span, and of the dead span where it is modelled; else the winch is on the same mount. ``exit_point`` is
    where it is without load. ``spring``: N/m, the rate of one between the winch and all cables of the line.

    ``counterweight``: kg, that hangs on all cables of the line where others have a winch: below ``winch_exit``, or else
    below the exit point. It gives their tension, and the platform's pose their length.

    ``shared_winch``: the other line on whose drum the cable is; ``winch`` is then that drum too.
    """

    name: Annotated[str, Field(min_length=1, max_length=60)]
    exit_point: Vec3
    exit_compliance: Compliance | None = None
    spring: Positive[Stiffness] | None = None
    counterweight: Positive[Mass] | None = None
    winch_exit: Vec3 | None = None
    guides: Annotated[tuple[_Guide, ...], Field(max_length=MAX_GUIDES)] = ()
    dead_length: NonNegative[Length] = 0.0
    advantage: Annotated[int, Field(strict=True, ge=1, le=MAX_SPANS)] = 1
    cables: Annotated[int, Field(strict=True, ge=1, le=MAX_SPANS)] = 1
    dead_elastic: StrictBool = True
    arc_elastic: StrictBool = False
    platform_point: Vec3 = (0.0, 0.0, 0.0)
    platform_sheave: _End | None = None
    cable: Cable
    sheave: Sheave
    winch: Winch = Winch()
    shared_winch: SharedWinch | None = None
    tension_limits: tuple[NonNegative[Force], NonNegative[Force]]

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        require_rising("tension_limits", self.tension_limits)
        if self.tension_limits[1] > self.cable.breaking_load:
            raise refusal("tension_limits", f"must end at or below the breaking load, {self.cable.breaking_load:g} N")
        self._check_path()
        if self.counterweight is not None:
            self._check_counterweight()
        if self.winch_exit is not None:
            self._check_dead_span(self.winch_exit)
        if self.advantage > 1 and not (isinstance(self.sheave, Eyelet) and self.platform_sheave is None):
            raise refusal("advantage", "must be 1 over a sheave that turns; the ends of several spans are eyelets")
        if self.cables > 1 and isinstance(self.sheave, UniversalJoint):
            raise refusal("cables", "must be 1 on a universal joint, whose lever one cable balances")
        return self

    @property
    def mount_gives(self) -> bool:
        """Whether the mount of the exit point is compliant."""
        return self.exit_compliance is not None and any(map(any, compliance_matrix(self.exit_compliance)))

    @property
    def gives_by(self) -> str:
        """Key of a compliance besides the cable's, which proofs do not support; empty if there is none."""
        if self.mount_gives:
            return "exit_compliance"
        return "spring" if self.spring is not None else ""

    @property
    def mount_out_of_plane_by(self) -> str:
        """Key of the mount that takes the line out of its vertical plane; empty if none does."""
        if self.exit_compliance is None:
            return ""
        if not isinstance(self.exit_compliance, float) and self.mount_gives:
            return "a compliant mount with a matrix"
        if isinstance(self.sheave, Eyelet) and self.winch_exit is not None and self._from_axis()[1] > AXIS_TOLERANCE:
            return "a compliant mount with the winch beside the axis"
        return ""

    @property
    def may_give(self) -> bool:
        """Whether the mount of the exit point can be compliant: not with a cable from aside of a swivel's axis."""
        return not self.is_aside

    @property
    def turned_off_by(self) -> str:
        """What turns its swivel out of the plane of the free cable and the exit point without load; empty: nothing."""
        if self.is_aside:
            return "a winch aside of its swivel's axis, which turns its sheave out of the plane of the free cable"
        mount = self.mount_out_of_plane_by
        return mount and f"{mount}, which turns its azimuth by as much as it goes aside"

    @property
    def in_plane(self) -> bool:
        """Whether a winch holds the line and it lies in one vertical plane with its sag, without guides before that."""
        is_fixed = isinstance(self.sheave, Pulley) or self.platform_sheave is not None or bool(self.guides)
        leans = isinstance(self.sheave, Swivel) and (self.is_aside or not self.sheave.upright)
        return not (self.counterweight is not None or is_fixed or leans or self.mount_out_of_plane_by)

    @property
    def swivel_axis(self) -> Vec3:
        """The unit vector of the axis about which the line turns at its exit point: a swivel's, else the vertical."""
        return unit_vector(self.sheave.axis) if isinstance(self.sheave, Swivel) else (0.0, 0.0, 1.0)

    @property
    def has_upright_swivel(self) -> bool:
        """Whether the line's sheave swivels about the vertical axis along which the cable arrives."""
        return isinstance(self.sheave, Swivel) and self.sheave.upright and not self.is_aside

    @property
    def has_arc(self) -> bool:
        """Whether the cable lies on a sheave at one or both ends of the free span."""
        return not isinstance(self.sheave, Eyelet) or self.platform_sheave is not None

    @property
    def way(self) -> str:
        """Words for the path of its cable from a given winch exit, beginning with a comma; empty if straight."""
        wheels = sum(isinstance(guide, GuideSheave) for guide in self.guides)
        over = f", straight over {len(self.guides)} guides" if self.guides else ""
        over += f", of which {wheels} are wheels" if wheels else ""
        return over + (", from a winch aside of the sheave's axis" if self.is_aside else "")

    @property
    def holder(self) -> str:
        """Words for the device that holds the cable at its other end: winch or counterweight."""
        if self.counterweight is not None:
            return f"a counterweight of {self.counterweight:g} kg, whose tension is given"
        spring = "" if self.spring is None else f" with a spring that gives by {1e6 / self.spring:.4g} mm per kN"
        return f"a winch{spring}"

    @property
    def radii(self) -> tuple[float, ...]:
        """The radii of the sheaves and wheels that the cable runs over, m."""
        passed = (self.sheave, self.platform_sheave, *self.guides)
        return tuple(each.radius for each in passed if not isinstance(each, Eyelet | tuple | None))

    @property
    def is_aside(self) -> bool:
        """Whether the cable comes to its swivel from a point that is not on the swivel's axis."""
        return isinstance(self.sheave, Swivel) and self.last_guide is not None and self._from_axis()[1] > AXIS_TOLERANCE

    def _from_axis(self) -> tuple[float, float]:
        """Where the cable comes from: how far along the axis of its sheave, from the exit point, and aside of it, m."""
        assert self.last_guide is not None
        assert not isinstance(self.sheave, Pulley)
        axis = unit_vector(self.sheave.axis) if isinstance(self.sheave, Swivel) else (0.0, 0.0, 1.0)
        away = tuple(c - a for c, a in zip(self.last_guide, self.exit_point, strict=True))
        along = sum(a * d for a, d in zip(axis, away, strict=True))
        return along, math.hypot(*(d - along * a for a, d in zip(axis, away, strict=True)))

    @property
    def last_guide(self) -> Vec3 | None:
        """The point (m, world) from which the cable comes to its exit point: of a guide, or the winch exit."""
        if not self.guides:
            return self.winch_exit
        last = self.guides[-1]
        return last if isinstance(last, tuple) else self.dead_span().last.start

    def dead_span(self, wheels: bool = True) -> DeadSpan:
        """The path of the cable from its modelled winch exit to its exit point, or to a pulley there.

        Without *wheels* those are points, their centres. Raises `InputError` where no cable runs so.
        """
        try:
            return self._dead_span(wheels)
        except InputError as fault:
            raise InputError(f"line {self.name!r}: guides: {fault}") from None

    def _dead_span(self, wheels: bool = True) -> DeadSpan:
        assert self.winch_exit is not None
        guides: tuple[Guide, ...] = self.guides
        if not wheels:
            guides = tuple(each if isinstance(each, tuple) else each.centre for each in guides)
        elif isinstance(self.sheave, Pulley):
            wheel = GuideSheave(centre=self.exit_point, axis=self.sheave.axis, radius=self.sheave.radius)
            return dead_span(self.winch_exit, guides, wheel)
        return dead_span(self.winch_exit, guides, self.exit_point)

    def _check_path(self) -> None:
        if isinstance(self.sheave, UniversalJoint) and not self.in_plane:
            keys = ("counterweight", "guides", "platform_sheave")
            key = next((key for key in keys if getattr(self, key)), None)
            if key is None:
                raise refusal("exit_compliance", "must be one number on a universal joint, the same in all directions")
            raise refusal(key, "is for lines without a universal joint")
        if self.guides:
            self._check_guides()
        if self.is_aside and self.exit_compliance is not None:
            raise refusal("exit_compliance", "is not for a swivel whose cable comes from aside of its axis")
        if isinstance(self.sheave, Pulley):
            self._check_pulley(self.sheave)
        elif isinstance(self.sheave, Swivel) and self.sheave.swing is not None and not self.in_plane:
            raise refusal(
                "swing",
                "is of lines in a vertical plane, without guides or a platform_sheave",
                ("sheave",),
            )
        if self.is_aside and isinstance(self.sheave, Swivel):
            along, offset = self._from_axis()
            if math.hypot(along, offset - self.sheave.radius) <= self.sheave.radius:
                key = "guides" if self.guides else "winch_exit"
                raise refusal(key, f"is within reach of the sheave, whose radius is {self.sheave.radius:g} m")

    def _check_counterweight(self) -> None:
        if self.spring is not None:
            raise refusal("spring", "has no effect where a counterweight gives the tension: leave it out")
        if self.winch != Winch():
            raise refusal("winch", "is not for a line with a counterweight, which hangs where its winch would be")

    def _check_guides(self) -> None:
        if self.winch_exit is None:
            raise refusal("guides", "needs winch_exit, where the cable comes from")
        for one, two in pairwise((self.winch_exit, *self.guides, self.exit_point)):
            if one == two:
                where = f"{list(two)} m" if isinstance(two, tuple) else "a wheel"
                raise refusal("guides", f"{where} follows itself: a cable passes a point once")
        if not isinstance(self.sheave, Pulley) and all(isinstance(guide, tuple) for guide in self.guides):
            return
        try:
            last = self._dead_span().last.start
        except InputError as fault:
            raise refusal("guides", str(fault)) from None
        if isinstance(self.guides[-1], GuideSheave) and self.is_aside:
            where = f"guide {len(self.guides)}: the cable leaves this wheel {self._from_axis()[1]:g} m off the axis of"
            raise refusal("guides", f"{where} its swivel, at {[round(x, 6) for x in last]} m: put an eyelet behind it")

    def _check_pulley(self, pulley: Pulley) -> None:
        """Reject a cable that does not come in the pulley's plane, from outside of it."""
        if self.last_guide is None:
            raise refusal("winch_exit", "is needed for a pulley, whose arc begins where the cable comes to it")
        away = tuple(c - a for c, a in zip(self.last_guide, self.exit_point, strict=True))
        across = abs(sum(n * d for n, d in zip(unit_vector(pulley.axis), away, strict=True)))
        key = "guides" if self.guides else "winch_exit"
        if across > AXIS_TOLERANCE * max(1.0, math.hypot(*away)):
            raise refusal(key, f"is {across:g} m out of the plane of the pulley, in which the cable must come to it")
        if not math.hypot(*away) > pulley.radius:
            raise refusal(key, f"is inside the pulley, whose radius is {pulley.radius:g} m")

    def _check_dead_span(self, winch_exit: Vec3) -> None:
        if self.dead_length:
            raise refusal("dead_length", "is for a dead span that is not modelled: leave out this or winch_exit")
        if winch_exit == self.exit_point:
            raise refusal("winch_exit", "must differ from exit_point")
        if isinstance(self.sheave, Eyelet | Pulley):
            return
        self._check_side(self.sheave)

    def _check_side(self, sheave: Swivel | UniversalJoint) -> None:
        """Reject a cable that does not come to its sheave from the side that its wrap says."""
        key = "guides" if self.guides else "winch_exit"
        upright = isinstance(sheave, UniversalJoint) or sheave.upright
        along, offset = self._from_axis()
        if isinstance(sheave, UniversalJoint) and offset > AXIS_TOLERANCE:
            where = f"is {offset:g} m off the vertical through exit_point"
            raise refusal(key, f"{where}; the cable of a universal joint comes along it: put it there")
        if sheave.wrap == "over" and along >= 0.0:
            where = "below exit_point" if upright else "before exit_point along the axis"
            raise refusal(key, f"must be {where} for a cable that wraps over its sheave")
        if sheave.wrap == "under" and along <= 0.0:
            where = "above exit_point" if upright else "beyond exit_point along the axis"
            raise refusal(key, f"must be {where} for a cable that wraps under its sheave")
