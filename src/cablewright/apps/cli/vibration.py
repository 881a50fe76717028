"""`vibration`: tension, density and modulus of a line from its natural frequency."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson, Pose, RobotName
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import pose_of
from cablewright.foundation.errors import InputError


@command(
    "vibration merlet2023 --at 0,0,1 --line north-west --frequency 11.5",
    "analyses.line_vibration:LineVibration",
)
def vibration_command(
    *,
    robot: RobotName,
    line: Annotated[str, typer.Option("--line", metavar="NAME", help="Name of the line whose vibration was measured.")],
    at: Pose = None,
    frequency: Annotated[
        float | None,
        typer.Option(
            "--frequency",
            metavar="HZ",
            help="Lowest measured frequency of the vibration perpendicular to the plane in which the line sags, Hz.",
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record",
            metavar="FILE.csv",
            help="CSV file with the record of a vibration, columns t and readings, from which the frequency is found "
            "instead of --frequency.",
        ),
    ] = None,
    in_plane: Annotated[
        float | None,
        typer.Option(
            "--in-plane",
            metavar="HZ",
            help="Lowest measured frequency of the vibration in the plane in which the line sags, Hz.",
        ),
    ] = None,
    sigma: Annotated[
        float | None,
        typer.Option(
            "--sigma",
            metavar="HZ",
            help="Standard deviation of the frequency; by default that of the record, or 0.5 %.",
        ),
    ] = None,
    tension: Annotated[
        float | None,
        typer.Option(
            "--tension", metavar="N", help="Tension of the line by a load cell, N; by default it follows from statics."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Ends of the line count as at rest, and its bending stiffness is left out.

    Compare the tension with the expected one for maintenance. Sag alone shows the modulus, below a named tension.
    """
    machine = cw.load(robot)
    pose = pose_of(at, machine)
    if pose is None:
        raise InputError("vibration: give --at X,Y,Z")
    source = frequency if record is None else record
    if source is None or (frequency is not None and record is not None):
        raise InputError("vibration: give either --frequency or --record")
    return answer(
        cw.line_vibration(machine, pose, line, source, sigma=sigma, in_plane=in_plane, tension=tension), as_json
    )
