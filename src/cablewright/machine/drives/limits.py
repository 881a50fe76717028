"""Check of the drive limits of a machine file against the robot's file, before anything is sent."""

from __future__ import annotations

import math
from typing import Final

from cablewright.foundation.errors import InputError
from cablewright.machine.drives.drum_units import scales_of
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot

_BREAKING_SHARE: Final = 0.5  # of a line's breaking load, as the guard of every machine
_PERIODS: Final = 3  # between two commands, at least, before a drive misses one
_SLOWEST: Final = 0.15  # s for that: a state of a drive is not believed much longer
_BLIND: Final = 0.15  # m of cable that may run at full speed before a drive, or this computer, notices
_STOP: Final = 0.25  # m of cable in which a drive stops from full speed


def require_limits(robot: Robot, settings: MachineSettings, origin: str = "") -> None:
    """Raise `InputError` for tensions or times of a machine file that exceed limits of the robot.

    *origin*: name of the file in messages.
    """
    drives, where = settings.drives, origin or f"machine {settings.name!r}"
    assert drives is not None
    for line in robot.lines:
        most = min(line.tension_limits[1], _BREAKING_SHARE * (line.cable.breaking_load or math.inf))
        for key, tension in (("tension", drives.tension), ("jog_tension", drives.jog_tension)):
            if tension is not None and tension > most:
                why = f"line {line.name} of {robot.name} may pull {most:g} N at most"
                raise InputError(f"{where}: drives.{key} = {tension:g} N: {why}")
    shortest = min(drives.command_timeout, drives.heartbeat_timeout, _SLOWEST)
    if _PERIODS * settings.period > shortest:
        why = f"{_PERIODS} periods have to fit into drives.command_timeout, drives.heartbeat_timeout and {_SLOWEST:g} s"
        raise InputError(f"{where}: period = {settings.period:g} s: {why}: {shortest / _PERIODS:g} s is allowed")
    fastest = max(scale.speed_of_cable for scale in scales_of(robot, settings))
    for key in ("heartbeat_timeout", "command_timeout", "answer_timeout", "following_time"):
        time = getattr(drives, key)
        if time * fastest > _BLIND:
            why = f"cable runs at up to {fastest:g} m/s, and {_BLIND:g} m of it at most may run unwatched"
            raise InputError(f"{where}: drives.{key} = {time:g} s: {why}: {_BLIND / fastest:.3g} s is allowed")
    least = fastest * fastest / (2.0 * _STOP)
    if drives.deceleration < least:
        why = f"cable runs at up to {fastest:g} m/s and has to stop within {_STOP:g} m: {least:.3g} m/s^2 at least"
        raise InputError(f"{where}: drives.deceleration = {drives.deceleration:g} m/s^2: {why} is allowed")
