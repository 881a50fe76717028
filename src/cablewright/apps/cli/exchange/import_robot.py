"""`import`: a robot from another program's file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer
from cablewright.choices import CableName, ReadFormatName


@command("import examples/robot.wcrfx --out runs/robot.toml", "exchange.result:Imported")
def import_command(
    *,
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="File to read; of a CASPR model both.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.toml", help="Robot file to write; it must not exist.")],
    form: Annotated[
        ReadFormatName | None, typer.Option("--format", help="Format of the file; by default by its content.")
    ] = None,
    cable: Annotated[
        CableName | None,
        typer.Option(
            "--cable", help="Cable of all lines, see docs/robots.md; by default the file's, or an assumed one."
        ),
    ] = None,
    cable_set: Annotated[
        str | None, typer.Option("--cable-set", metavar="ID", help="Set of cables of a CASPR model; else its default.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Reads WireX, CASPR (bodies and cables), a Maslow's settings, and configurations of Klipper and RepRapFirmware.

    What the file has and a robot file has not, and what had to be assumed, is told on stderr and in comments of the
    file that is written. See docs/exchange.md.
    """
    from cablewright.exchange.formats import ImportOptions, read_robot
    from cablewright.exchange.result import Imported
    from cablewright.exchange.robot_toml import robot_toml
    from cablewright.file_output import write_whole

    if out.suffix != ".toml":
        raise cw.InputError(f"--out = {str(out)!r}: must end in .toml")
    if out.exists() or out.is_symlink():
        raise cw.InputError(f"{out}: is there already; nothing is overwritten")
    found = read_robot(files, form, ImportOptions(cable, cable_set))
    text = robot_toml(found, "cablewright import")
    cw.loads(text, str(out))
    write_whole(out, text.encode(), parents=True)
    robot = found.robot
    told = Imported(found.format, robot.name, robot.m, robot.freedoms, found.lost, found.assumed)
    return answer(told, as_json, file=out)
