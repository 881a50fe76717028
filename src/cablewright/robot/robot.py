"""A whole cable robot, as it is bolted together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Annotated, Self

from pydantic import Field, model_validator

from cablewright.errors import InputError, suggestion
from cablewright.robot.bracket import Bracket
from cablewright.robot.line import Line
from cablewright.robot.platform import Platform, PointPlatform, Retraction
from cablewright.robot.scene import Scene
from cablewright.validation import FileDescription, refusal, require_unique_names

MAX_LINES = 64


class Robot(FileDescription):
    """m lines, one platform of n freedoms, and the scene they are in. ``source`` names the paper or the origin.

    ``bracket`` is what holds each sheave, where that is known.
    """

    name: Annotated[str, Field(min_length=1, max_length=100)]
    description: str = ""
    source: str = ""
    scene: Scene
    platform: Platform
    lines: Annotated[tuple[Line, ...], Field(max_length=MAX_LINES)]
    bracket: Bracket | None = None

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if not self.lines:  # not by min_length, which also complains when every line has a fault of its own
            raise refusal("lines", "must have at least 1 entry")
        require_unique_names("lines", (line.name for line in self.lines))
        if isinstance(self.platform, PointPlatform):
            self._check_lines_meet()
        else:
            self._check_lines_differ()
        if self.retraction is not None:
            self._check_retraction(self.retraction)
        return self

    def _check_lines_meet(self) -> None:
        if len({line.platform_point for line in self.lines}) > 1:
            why = 'a point platform has all lines meet in one platform_point; one that may turn has kind = "rigid"'
            raise refusal("lines", why)

    def _check_lines_differ(self) -> None:
        if len(self.lines) > 1 and len({line.platform_point for line in self.lines}) == 1:
            raise refusal("lines", 'all platform points coincide: that is a point platform, kind = "point"')
        for one, other in combinations(self.lines, 2):  # sharing only the platform point is fine: NIST RoboCrane
            if (one.exit_point, one.platform_point) == (other.exit_point, other.platform_point):
                why = f"lines {one.name!r} and {other.name!r} are one line: same exit_point and platform_point"
                raise refusal("lines", why)

    def _check_retraction(self, retraction: Retraction) -> None:
        names = [line.name for line in self.lines]
        for name in retraction.lines:
            if name not in names:
                why = f"no line is named {name!r}; {suggestion(name, names)}"
                raise refusal("lines", why, within=("platform", "retraction"))

    @property
    def m(self) -> int:
        """The number of lines."""
        return len(self.lines)

    @property
    def n(self) -> int:
        """The number of pose coordinates, the platform's freedoms."""
        return self.platform.freedoms

    @property
    def retraction(self) -> Retraction | None:
        """The platform's retraction, if it has one."""
        return None if isinstance(self.platform, PointPlatform) else self.platform.retraction

    def under_load(self, name: str) -> Robot:
        """Return the robot with the values of its platform's load ``name`` in place, and no loads.

        Raises `UnknownName`, which lists the loads.
        """
        return self.model_copy(update={"platform": self.platform.under_load(name)})

    def under_wrench(self, force: Sequence[float], moment: Sequence[float] = (0.0, 0.0, 0.0)) -> Robot:
        """Return the robot with *force* (N) and *moment* (N m, about its origin), world, as the platform's own.

        Raises `InputError` for what is not three finite numbers each, or a moment on a point platform.
        """
        changes = {"force": _three("force", force)}
        turning = _three("moment", moment)
        if self.n == 6:
            changes["moment"] = turning
        elif any(turning):
            raise InputError(f"robot {self.name!r}: a point platform takes no moment; got {turning} N m")
        return self.model_copy(update={"platform": self.platform.model_copy(update=changes)})

    def limited(self, tension_limits: tuple[float, float]) -> Robot:
        """Return the robot with *tension_limits*, lowest and highest (N), in place of those of every line."""
        lines = tuple(line.model_copy(update={"tension_limits": tension_limits}) for line in self.lines)
        return self.model_copy(update={"lines": lines})

    def retraction_to(self, length: float) -> Retraction:
        """Return the platform's retraction. Raises `InputError` if it has none, or none that goes to ``length`` (m)."""
        retraction = self.retraction
        if retraction is None:
            raise InputError(f"robot {self.name!r} has no retraction: its platform has one length")
        if not retraction.least <= length <= retraction.most:
            reach = f"{retraction.least:g} to {retraction.most:g} m"
            raise InputError(f"retraction length {length:g} m: the platform of {self.name!r} goes from {reach}")
        return retraction

    def retracted(self, length: float) -> Robot:
        """Return the robot with its platform at the retraction ``length`` (m): the platform points that move, moved.

        Mass, centre of mass and inertia stay. Raises `InputError` if the platform has no retraction, or not this far.
        """
        retraction = self.retraction_to(length)
        lines = tuple(
            line.model_copy(update={"platform_point": retraction.moved(line.platform_point, length)})
            if line.name in retraction.lines
            else line
            for line in self.lines
        )
        changed = retraction.model_copy(update={"length": float(length)})
        platform = self.platform.model_copy(update={"retraction": changed})
        return self.model_copy(update={"platform": platform, "lines": lines})


def _three(what: str, values: Sequence[float]) -> tuple[float, ...]:
    """Return three finite numbers, or raise `InputError`."""
    try:
        parts = tuple(float(value) for value in values)
    except (TypeError, ValueError):
        parts = ()
    if len(parts) != 3 or not all(map(math.isfinite, parts)):
        raise InputError(f"{what} = {values!r}: 3 finite numbers are wanted")
    return parts
