"""The winch: what its drum can pay out, how fast and against what."""

from __future__ import annotations

from cablewright.robot.description import Description
from cablewright.units import Length, Positive, Speed, Torque


class Winch(Description):
    """A winch. Each value may be unknown; what needs it then says so.

    ``max_speed`` is the cable's, ``max_torque`` is at the drum, ``capacity`` is the length of cable the drum can hold.
    """

    drum_radius: Positive[Length] | None = None
    max_speed: Positive[Speed] | None = None
    max_torque: Positive[Torque] | None = None
    capacity: Positive[Length] | None = None
