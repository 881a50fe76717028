"""A whole cable robot, as it is bolted together."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, Self

from pydantic import Field, model_validator

from cablewright.robot.description import Description, refusal
from cablewright.robot.line import Line
from cablewright.robot.platform import Platform
from cablewright.robot.scene import Scene

__all__ = ["NEWEST_SCHEMA", "Robot"]

NEWEST_SCHEMA = 1
MOST_LINES = 64


class Robot(Description):
    """m lines, one platform of n freedoms, and the scene they are in. ``source`` names the paper or the origin."""

    schema_version: Annotated[int, Field(alias="schema", strict=True, ge=1, le=NEWEST_SCHEMA)] = NEWEST_SCHEMA
    name: Annotated[str, Field(min_length=1, max_length=100)]
    description: str = ""
    source: str = ""
    scene: Scene
    platform: Platform
    lines: Annotated[tuple[Line, ...], Field(max_length=MOST_LINES)]

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        if not self.lines:  # not by min_length, which also complains when every line has a fault of its own
            raise refusal("lines", "must have at least 1 entry")
        name, count = Counter(line.name for line in self.lines).most_common(1)[0]
        if count > 1:
            raise refusal("lines", f"{count} lines are named {name!r}; each needs a name of its own")
        return self

    @model_validator(mode="after")
    def _lines_meet(self) -> Self:
        if len({line.platform_point for line in self.lines}) > 1:
            raise refusal("lines", "a point platform has all lines meet in one platform_point")
        return self

    @property
    def m(self) -> int:
        """The number of lines."""
        return len(self.lines)

    @property
    def n(self) -> int:
        """The number of pose coordinates, the platform's freedoms."""
        return self.platform.freedoms
