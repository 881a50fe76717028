"""`survey`: winch exits, sheave axes and walls from a total station's file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, tell
from cablewright.errors import InputError
from cablewright.file_output import write_whole


@command("survey examples/survey.gsi --plan examples/survey.toml", "calibration.survey.result:Survey")
def survey_command(
    *,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of the total station: Leica GSI-8, GSI-16, or CSV.")
    ],
    plan: Annotated[
        Path | None,
        typer.Option(
            "--plan",
            metavar="PLAN.toml",
            help="What markers are on, the instrument's sigmas and the frame, where not default.",
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option("--robot", metavar="ROBOT", help="Robot whose lines the numbers of the markers count."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="Write the robot's file with the exit points that were found."),
    ] = None,
    output: OutputOptions,
) -> int:
    """The frame has y along the west wall and x into the room, unless the plan says otherwise.

    Each result has its standard deviation, and markers that fit badly are marked.
    """
    from cablewright.calibration.survey.surveyed_robot import surveyed
    from cablewright.robot import file_text, update

    if out is not None and robot is None:
        raise InputError(f"--out = {str(out)!r}: there is no --robot whose exit points it could have")
    found = cw.survey(file, plan, robot=None if robot is None else cw.load(robot))
    if out is not None and robot is not None:
        rebuilt, notes = surveyed(cw.load(robot), found)
        write_whole(out, update(file_text(robot), rebuilt).encode())
        for note in notes:
            tell(f"note: {note}")
    return answer(found, output.as_json, robot=out, **output.write(found, "Survey"))
