"""The platform: what the lines carry."""

from __future__ import annotations

from typing import Literal

from cablewright.robot.description import Description
from cablewright.units import Mass, Positive

__all__ = ["Platform", "PointPlatform"]


class PointPlatform(Description):
    """A mass in which all lines meet: it has three freedoms, its position (m, world)."""

    kind: Literal["point"] = "point"
    mass: Positive[Mass]

    @property
    def freedoms(self) -> int:
        """The number n of pose coordinates."""
        return 3


Platform = PointPlatform
