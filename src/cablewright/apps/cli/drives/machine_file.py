"""Machine files of real machines, for the commands that move them."""

from __future__ import annotations

import cablewright as cw


def load_real(file: str, robot: cw.Robot) -> cw.MachineSettings:
    """Return the machine of a file, after checking that its limits are within those of the robot.

    Raises `InputError`, which names file, key and value.
    """
    from cablewright.machine.drives.drives_of_winches import require_drives
    from cablewright.machine.drives.limits import require_limits
    from cablewright.machine.settings import require_robot

    settings = cw.load_machine(file)
    require_robot(settings, robot.name)
    require_drives(settings, robot)
    require_limits(robot, settings, file)
    return settings
