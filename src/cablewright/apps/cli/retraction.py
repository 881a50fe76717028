"""`retraction`: how far to retract the end-effector at each height, and a law for it."""

from __future__ import annotations

from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import OutputOptions, RegionOptions, RobotOptions
from cablewright.apps.cli.output import answer, progress


@command(
    "retraction jung2020 --criterion closed-form --steps 3 --heights 10 --tolerance 0.05",
    "analyses.workspace.retraction:RetractionStudy",
)
def retraction_command(
    *,
    robot: RobotOptions,
    min_length: Annotated[
        float | None, typer.Option("--from", metavar="L", help="Min length, m; by default the robot's.")
    ] = None,
    max_length: Annotated[
        float | None, typer.Option("--to", metavar="L", help="Max length, m; by default the robot's.")
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of lengths tried.")] = 9,
    heights: Annotated[int, typer.Option("--heights", metavar="N", help="Number of slices of the box.")] = 40,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="T", help="Error of each volume, as a share of it.")
    ] = 2e-3,
    region: RegionOptions,
    output: OutputOptions,
) -> int:
    """The workspace is found at several constant lengths; each slice of it is largest at some length.

    The law is the line through these best lengths over the height; the workspace with the law in force is found too.
    """
    with progress() as show:
        found = cw.retraction(
            robot.loaded(),
            region.criterion_name,
            min_length=min_length,
            max_length=max_length,
            steps=steps,
            heights=heights,
            tolerance=tolerance,
            progress=show,
            **region.as_arguments(),
        )
    return answer(found, output.as_json, **output.write(found, f"Retraction of {robot.robot}"))
