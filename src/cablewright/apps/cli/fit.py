"""`fit`: whether a part fits a robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import OutputOptions, RobotOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import quantity, tension_range
from cablewright.foundation.units import LENGTH


@command("fit house-printer examples/house.gcode", "studies.part_fit:Fit")
def fit_command(
    *,
    robot: RobotOptions,
    part: Annotated[Path, typer.Argument(metavar="PART", help="A job's TOML, G-code, or an STL file in mm.")],
    tension_limits: Annotated[
        str | None,
        typer.Option(
            "--tension-limits",
            metavar="MIN,MAX",
            help="Smallest and largest allowed tension of every line, N; by default those of the robot file.",
        ),
    ] = None,
    max_error: Annotated[
        str | None,
        typer.Option(
            "--max-error",
            metavar="L",
            help="Largest allowed expected error of the nozzle, in m or like '1 mm'; by default there is no limit.",
        ),
    ] = None,
    output: OutputOptions,
) -> int:
    """Tries positions, and rotations if none fits, on a grid of reachable points, and verifies the best one.

    The answer is no (exit 1) if the part fits nowhere at its own scale. `check` covers lines against the part, motion
    and winches.
    """
    from cablewright.studies.part_fit import fit

    machine, tensions = robot.loaded(), tension_range(tension_limits)
    if tensions is not None:
        machine = machine.limited(tensions)
    allowed = None if max_error is None else quantity(max_error, "--max-error", LENGTH)
    whole = part if part.suffix.lower() == ".stl" else cw.load_job(part)
    with progress() as show:
        found = fit(machine, whole, max_error=allowed, progress=show)
    return answer(found, output.as_json, **output.write(found, f"{part.name} in {robot.robot}"))
