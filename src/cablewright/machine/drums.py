"""The winch drums of a robot, with the cable layers of a machine file."""

from __future__ import annotations

from cablewright.foundation.errors import InputError
from cablewright.machine.coils import coil_of
from cablewright.machine.settings import MachineSettings
from cablewright.models.drum import WinchDrum, drum_of
from cablewright.robot import Robot


def drums_of(robot: Robot, machine: MachineSettings | None = None) -> tuple[WinchDrum, ...]:
    """Return the drum of each winch: with coils by the *machine*'s capacity, width and pitch, else as in the file.

    Raises `InputError` for a line without a drum radius, or, with a machine, without a cable diameter.
    """
    found = []
    for line in robot.winch_lines:
        bare = drum_of(line)
        if bare is None:
            raise InputError(
                f"line {line.name!r} has no winch.drum_radius, which is needed to convert turns of its winch: give "
                f"it in [winch]"
            )
        found.append(
            bare if machine is None else WinchDrum(bare.radius, coil_of(line, machine.winch), machine.winch.held)
        )
    return tuple(found)
