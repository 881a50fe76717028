"""Assignment of the drives in a machine file to the winches of a robot."""

from __future__ import annotations

from cablewright.foundation.errors import InputError
from cablewright.machine.drives.axis import Axis
from cablewright.machine.drives.drum_units import scales_of
from cablewright.machine.drives.settings import WinchDriveSettings
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot


def axes_of(robot: Robot, settings: MachineSettings) -> tuple[Axis, ...]:
    """Return the drive of each winch, in the order of the winches.

    Raises `InputError` as `require_drives` and `scales_of`.
    """
    drives = require_drives(settings, robot)
    return tuple(
        Axis(line.name, drives.nodes[line.name].id, scale, drives.brake_time, _valve(drives, line.name))
        for line, scale in zip(robot.winch_lines, scales_of(robot, settings), strict=True)
    )


def _valve(settings: WinchDriveSettings, line: str) -> int:
    """The bit, as a mask, of the outputs of a *line*'s drive that opens the valve; 0: it has none."""
    valve = settings.valve
    return 1 << valve.bit if valve is not None and valve.line == line else 0


def require_drives(settings: MachineSettings, robot: Robot) -> WinchDriveSettings:
    """Return the drives of the machine. Raises `InputError` unless each winch of *robot* has one."""
    drives, lines = settings.drives, robot.winch_names
    if drives is None:
        why = 'kind = "canopen" or "ethercat" and a table [drives] are expected'
        raise InputError(f"machine {settings.name!r}: kind = {settings.kind!r}: has no real drives; {why}")
    if odd := sorted(set(drives.nodes) ^ set(lines)):
        why = f"one node for each line of the robot is expected: {', '.join(lines)}"
        raise InputError(f"drives.nodes: {odd[0]!r}: {why}")
    return drives
