"""The drive that retracts a simulated platform, as arrays for the kernels."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import RETRACTION, Condition, Notice
from cablewright.kernels.plant import retracting_platform, winding
from cablewright.kernels.plant.machine_step import Drive
from cablewright.machine.sensors.retraction import RetractionDrive
from cablewright.robot import Robot

_CONDITIONS = (
    (winding.LIMITED, Condition.LIMITED),
    (winding.STALLED, Condition.STALLED),
    (winding.DRUM_END, Condition.DRUM_END),
)


class RetractionAxis:
    """The drive that retracts a robot's platform; of a robot without one, nothing that moves."""

    SAVED = ("drive.beam",)

    def __init__(self, robot: Robot, settings: RetractionDrive | None) -> None:
        """Start at the robot's own length. Raises `InputError` for a drive of a platform that has no retraction."""
        points = np.array([line.platform_point for line in robot.lines])
        self.drive = Drive(np.zeros(0), np.zeros(robot.m), points, np.zeros(1), np.zeros(1, dtype=np.int64))
        if settings is None:
            return
        own = robot.retraction
        if own is None:
            raise InputError(f"robot {robot.name!r}: its platform has no retraction that [retraction] could drive")
        numbers, along = np.zeros(retracting_platform.BEAM), np.array(own.along)
        numbers[[retracting_platform.LENGTH, retracting_platform.LEAST, retracting_platform.MOST]] = (
            own.length,
            own.least,
            own.most,
        )
        numbers[[retracting_platform.MAX_SPEED, retracting_platform.LAG, retracting_platform.MAX_FORCE]] = (
            settings.max_speed,
            settings.lag,
            settings.max_force,
        )
        numbers[retracting_platform.ALONG : retracting_platform.ALONG + 3] = along
        numbers[retracting_platform.MOVING_MASS] = settings.moving_mass
        described = own.length if settings.length is None else settings.length
        numbers[retracting_platform.MOVING : retracting_platform.MOVING + 3] = (
            np.array(settings.moving_centre) - described * along
        )
        moved = np.array([float(line.name in own.lines) for line in robot.lines])
        fixed = points - own.length * moved[:, None] * along
        self.drive = self.drive._replace(beam=numbers, moved=moved, fixed=fixed)

    @property
    def has_drive(self) -> bool:
        """Whether the platform can retract."""
        return len(self.drive.beam) > 0

    @property
    def length(self) -> float:
        """Length of the platform, m; NaN without a drive."""
        return float(self.drive.beam[retracting_platform.LENGTH]) if self.has_drive else float("nan")

    def command(self, speed: float) -> None:
        """Set the commanded *speed*, m/s; positive makes the platform longer."""
        self.drive.speed[0] = speed

    def move(self, lines: Array, pull: float, period: float) -> None:
        """Move the retraction for a *period*, s, against the *pull* (N) of lines and weight.

        The platform points of *lines* move with it.
        """
        numbers = self.drive.beam
        retracting_platform.turn_drive(numbers, float(self.drive.speed[0]), pull, period, self.drive.flags)
        self.put(lines)

    def put(self, lines: Array) -> None:
        """Write the present platform points to the packed *lines*."""
        if self.has_drive:
            retracting_platform.set_points(lines, self.drive.beam, self.drive.moved, self.drive.fixed, self.length)

    def take_notices(self) -> list[Notice]:
        """Return and clear the notices since the last call."""
        flags, self.drive.flags[0] = int(self.drive.flags[0]), 0
        return [Notice(condition, RETRACTION) for bit, condition in _CONDITIONS if flags & bit]
