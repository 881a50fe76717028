"""The simulated drive that turns the container about its axis, in series with the twist of its lines."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cablewright.foundation.signals import YAW, Condition, Notice
from cablewright.machine.carried_load import YawDrive


class YawAxis:
    """A geared drive between container and suspension; without settings, one that stands at 0.

    ``angle``: rad, of the container against the suspension, which also stands without power; ``speed``: rad/s.
    """

    SAVED = ("angle", "speed")

    def __init__(self, settings: YawDrive | None) -> None:
        """Start at 0."""
        self._settings, self._commanded, self._conditions = settings, 0.0, set[Condition]()
        self.angle = self.speed = 0.0

    @property
    def has_drive(self) -> bool:
        """Whether the container can be turned."""
        return self._settings is not None

    def command(self, speed: float) -> None:
        """Set the commanded *speed* of the container's yaw drive, rad/s."""
        self._commanded = speed

    def turn(self, period: float, twist: float, stiffness: float) -> None:
        """Turn the container for a *period*, s, against the twist of the lines.

        With the drive at 0 the lines would be twisted by *twist*, rad; *stiffness*: N m/rad. The drive yields where the
        torque of the lines is over its own.
        """
        own = self._settings
        assert own is not None  # as `has_drive` says
        wanted = min(max(self._commanded, -own.max_speed), own.max_speed)
        self.speed += (wanted - self.speed) * (1.0 - math.exp(-period / own.lag) if own.lag else 1.0)
        aim = self.angle + period * self.speed
        most = own.max_torque / stiffness if stiffness else math.inf
        held = min(max(aim, -most - twist), most - twist)
        self.angle = min(max(held, -own.travel), own.travel)
        if held != aim:
            self._conditions.add(Condition.STALLED)
        if self.angle != held or wanted != self._commanded:
            self._conditions.add(Condition.LIMITED)
        if self.angle != aim:
            self.speed = 0.0

    def take_notices(self) -> Iterator[Notice]:
        """Yield and clear the notices since the last call."""
        while self._conditions:
            yield Notice(self._conditions.pop(), YAW)
