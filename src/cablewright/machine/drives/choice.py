"""Which drives a machine file means: by its kind."""

from collections.abc import Callable

from cablewright.machine.drives.bus import Port
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.ethercat.ethercat_drives import EthercatDrives
from cablewright.machine.drives.protocol import WinchDrives
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot


def drives_of(robot: Robot, settings: MachineSettings, port: Callable[[], Port] | None = None) -> WinchDrives:
    """The drives of a machine; *port* opens another CAN bus than that of the file. Raises `InputError`."""
    return EthercatDrives(robot, settings) if settings.kind == "ethercat" else CanopenDrives(robot, settings, port)
