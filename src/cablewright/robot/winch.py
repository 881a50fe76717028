"""The winch: radius and capacity of its drum, its speed and torque."""

from __future__ import annotations

from cablewright.units import Length, Positive, Speed, Torque
from cablewright.validation import Description


class Winch(Description):
    """A winch. Each value may be unknown, None; a function that needs it then raises an error.

    ``max_speed``: of the cable; ``max_torque``: at the drum; ``capacity``: length of cable that the drum can hold.
    """

    drum_radius: Positive[Length] | None = None
    max_speed: Positive[Speed] | None = None
    max_torque: Positive[Torque] | None = None
    capacity: Positive[Length] | None = None
