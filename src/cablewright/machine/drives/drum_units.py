"""Conversion of one winch's units: rad, rad/s and N m of its drum to the integers of its drive, and back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.machine.coils import coil_of
from cablewright.machine.settings import MachineSettings
from cablewright.models.support_table import Capability, require
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot


@dataclass(frozen=True)
class Scale:
    """A winch and its drive. Angles and speeds of drums pay cable out where they are positive.

    ``counts``: position counts per radian of the drum; ``speed``: units of 0x60FF per rad/s; ``torque``: per mille of
    the motor's rated torque per N m. All three have the sign of the node's direction. ``ratio``: turns of the motor for
    one of the drum. ``radii``: smallest and largest at which cable leaves, m. ``max_speed``: rad/s; ``max_torque``: N
    m: limits of the drum. ``cables``: number of cables on the drum that pull one way; the tension is that of one cable.
    On an ``opposed`` drum others pull the other way, so that a tension is the difference that its torque shows.
    """

    counts: float
    speed: float
    torque: float
    ratio: float
    radii: tuple[float, float]
    max_speed: float
    max_torque: float
    cables: int = 1
    opposed: bool = False

    @property
    def speed_of_cable(self) -> float:
        """Largest speed of the cable that a drive can command, m/s."""
        return self.max_speed * self.radii[1]

    def tension(self, torque: float) -> float:
        """Return the tension, N, that a *torque* (N m, of the drum) holds at the smallest radius: never understated."""
        return -torque / (self.radii[0] * self.cables)

    def torque_of(self, tension: float) -> float:
        """Return the torque, N m of the drum, at which the *tension*, N, is not exceeded at any radius."""
        return -tension * self.radii[0] * self.cables


def scales_of(robot: Robot, settings: MachineSettings) -> tuple[Scale, ...]:
    """Return the unit conversion of each winch of *robot*. Raises `InputError` for limits that a drive cannot take.

    The limit of a drum's speed is the least of the machine's and the robot's, that of the cable at the largest radius;
    of its torque the least of both and of its lines' largest tensions at the smallest radius.
    """
    require(robot, Capability.DRIVES)
    drives, winch, lines, found = settings.drives, settings.winch, WinchLines.of(robot), []
    assert drives is not None
    per_radian = winch.counts * winch.ratio / math.tau
    cables = np.array([line.cables for line in robot.lines])
    strengths = cables * np.array([line.tension_limits[1] for line in robot.lines])
    for line, senses, opposed in zip(robot.winch_lines, lines.senses, lines.opposed.tolist(), strict=True):
        coil = coil_of(line, winch)
        low, high = float(coil.radii.min()), coil.radius(coil.angle(winch.held))
        sign = drives.nodes[line.name].direction
        speed_unit = float(winch.counts) if drives.speed_unit is None else drives.speed_unit
        own_speed, own_torque = line.winch.max_speed, line.winch.max_torque
        max_speed = min(winch.max_speed, math.inf if own_speed is None else own_speed / high)
        strongest = low * max(float(strengths @ (senses == way)) for way in (1.0, -1.0))
        max_torque = min(winch.max_torque, strongest, math.inf if own_torque is None else own_torque)
        torque = 1000.0 / (winch.ratio * drives.rated_torque)
        if not 1.0 <= max_torque * torque <= 65535.0:
            why = f"{max_torque:g} N m at a drum are {max_torque * torque:g} per mille of it: 1 to 65535 are expected"
            raise InputError(f"drives.rated_torque = {drives.rated_torque:g} N m: {why}; check its unit")
        found.append(
            Scale(
                sign * per_radian,
                sign * speed_unit * winch.ratio / math.tau,
                sign * torque,
                winch.ratio,
                (low, high),
                max_speed,
                max_torque,
                int(cables @ (senses == 1.0)),
                opposed,
            )
        )
    return tuple(found)
