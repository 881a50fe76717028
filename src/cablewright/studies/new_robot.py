"""A new robot in a folder of its own: its robot file, a machine file, and a first part to check and to print."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import whole_folder, write_whole
from cablewright.foundation.results import Figure, Result
from cablewright.machine.files import machine_names
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.printing.trial_part import GCODE, first_part
from cablewright.robot import library_names, loads
from cablewright.robot.new_robot import Outline, robot_file

ROBOT, MACHINE, PART = "robot.toml", "machine.toml", "part.toml"
"""Names of the files."""


@dataclass(frozen=True, repr=False)
class Written(Result):
    """A file that was written for a new robot."""

    FIGURES: ClassVar = (
        Figure("file", "", "Name of the file."),
        Figure("content", "", "What it describes."),
    )

    file: str
    content: str


@dataclass(frozen=True, repr=False)
class NewRobot(Result):
    """The folder of a new robot."""

    FIGURES: ClassVar = (
        Figure("name", "", "Name of the robot."),
        Figure("description", "", "Description of the robot in a sentence."),
        Figure("folder", "", "Folder that was made."),
        Figure("check", "", "Command that checks the part on the robot."),
        Figure("print", "", "Command that prints it on the simulated machine.", "print_"),
        Figure("files", "", "Files in it.", parts=Written.FIGURES),
    )

    name: str
    description: str
    folder: str
    check: str
    print_: str
    files: tuple[Written, ...]
    notes: tuple[str, ...] = ()


def new_robot(outline: Outline, folder: str | Path | None = None) -> NewRobot:
    """Write the files of a new robot to *folder*, which is made; default: of the robot's name, in the working folder.

    Values that *outline* does not have are assumed, and marked so in the files. Raises `InputError` where the folder is
    there already, `EnvironmentFault` where it cannot be written.
    """
    if outline.name in {*library_names(), *machine_names()}:
        raise InputError(f"name = {outline.name!r}: a robot or machine of the library has it; choose another")
    place = Path(outline.name if folder is None else folder)
    if place.exists() or place.is_symlink():
        raise InputError(f"{place}: exists already and is not overwritten; choose another name")
    text = robot_file(outline)
    robot = loads(text, f"{place / ROBOT}")
    job, gcode = first_part(robot.name, robot.scene.frame_min, robot.scene.frame_max)
    files = {
        ROBOT: (text, "the robot, with the uncertainty of its numbers"),
        PART: (job, "a first part: its G-code, bead and speeds"),
        GCODE: (gcode, "a square of three layers" if outline.size[1] else "a wall of three layers"),
        MACHINE: (machine_file(robot), "the machine, with a simulation to print on"),
    }
    with whole_folder(place) as part:
        for name, (content, _) in files.items():
            write_whole(part / name, content.encode())
    written = tuple(Written(name, content) for name, (_, content) in files.items())
    return NewRobot(
        name=outline.name,
        description=robot.description,
        folder=str(place),
        check=f"cablewright check {place / ROBOT} {place / PART}",
        print_=f"cablewright print {place / ROBOT} {place / PART} --machine {place / MACHINE}",
        files=written,
    )
