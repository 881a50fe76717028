"""Choice between CANopen and EtherCAT drives by `kind` of the machine file."""

from __future__ import annotations

from collections.abc import Callable

from cablewright.machine.drives.can_bus import Port
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.ethercat.ethercat_drives import EthercatDrives
from cablewright.machine.drives.winch_drives import WinchDrives
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot


def drives_of(robot: Robot, settings: MachineSettings, port: Callable[[], Port] | None = None) -> WinchDrives:
    """Return the CANopen or EtherCAT drives of a machine; *port* opens a CAN bus in place of the file's own.

    Raises `InputError`.
    """
    return EthercatDrives(robot, settings) if settings.kind == "ethercat" else CanopenDrives(robot, settings, port)
