"""`import`: a robot from another program's file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer
from cablewright.choices import CableName, ReadFormatName


@dataclass(frozen=True, kw_only=True)
class ImportCommand:
    """Reads WireX, CASPR (bodies and cables), a Maslow's settings, and configurations of Klipper and RepRapFirmware.

    What the file has and a robot file has not, and what had to be assumed, is told on stderr and in comments of the
    file that is written. See docs/exchange.md.
    """

    EXAMPLE: ClassVar = "import examples/robot.wcrfx --out runs/robot.toml"
    ANSWERS: ClassVar = ("exchange.result:Imported",)

    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="File to read; of a CASPR model both.")]
    out: Annotated[Path, typer.Option("--out", metavar="FILE.toml", help="Robot file to write; it must not exist.")]
    format: Annotated[
        ReadFormatName | None, typer.Option("--format", help="Format of the file; by default by its content.")
    ] = None
    cable: Annotated[
        CableName | None,
        typer.Option(
            "--cable", help="Cable of all lines, see docs/robots.md; by default the file's, or an assumed one."
        ),
    ] = None
    cable_set: Annotated[
        str | None, typer.Option("--cable-set", metavar="ID", help="Set of cables of a CASPR model; else its default.")
    ] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Read, write and print."""
        from cablewright.errors import InputError
        from cablewright.exchange.formats import ImportOptions, read_robot
        from cablewright.exchange.result import Imported
        from cablewright.exchange.robot_toml import robot_toml
        from cablewright.file_output import write_whole
        from cablewright.robot import loads

        if self.out.suffix != ".toml":
            raise InputError(f"--out = {str(self.out)!r}: must end in .toml")
        if self.out.exists() or self.out.is_symlink():
            raise InputError(f"{self.out}: is there already; nothing is overwritten")
        found = read_robot(self.files, self.format, ImportOptions(self.cable, self.cable_set))
        text = robot_toml(found, "cablewright import")
        loads(text, str(self.out))
        write_whole(self.out, text.encode(), parents=True)
        robot = found.robot
        told = Imported(found.format, robot.name, robot.m, robot.freedoms, found.lost, found.assumed)
        return answer(told, self.as_json, file=self.out)
