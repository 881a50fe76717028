"""`modes`: stiffness and natural frequencies of the platform at a pose, or along the boundary of a workspace."""

from __future__ import annotations

from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import Geometric, OrientedRegionOptions, OutputOptions, Pose, RobotOptions, Tensions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import pose_of
from cablewright.foundation.errors import InputError

OF_BOUNDARY = ("criterion", "box", "point", "orientations", "retraction_law")


@command("modes jung2020 --at 0.2,0.1,0.9", "analyses.modes:Modes", "analyses.workspace.boundary_modes:Boundary")
def modes_command(
    *,
    robot: RobotOptions,
    at: Pose = None,
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Modes along the boundary of the workspace instead of at one pose.")
    ] = False,
    geometric: Geometric = True,
    grid: Annotated[
        int | None, typer.Option("--grid", metavar="N", help="With --boundary: nodes along each side; by default 21.")
    ] = None,
    tensions: Tensions = None,
    region: OrientedRegionOptions,
    output: OutputOptions,
) -> int:
    """The platform swings on its lines as on springs without mass; winches stand still and nothing damps.

    Either at one pose, --at, or with --boundary at the outermost nodes of a grid over the workspace, with all modes
    at the pose whose lowest frequency is the lowest.
    """
    from cablewright.analyses.workspace.boundary_modes import GRID

    if (at is None) != boundary:
        raise InputError("modes: give either --at X,Y,Z or --boundary")
    machine, given = robot.loaded(), region.as_arguments()
    if at is not None:
        only = {key: getattr(region, key) for key in OF_BOUNDARY} | {"grid": grid, "tensions": tensions}
        for key, value in only.items():
            if value is not None:
                raise InputError(f"--{key.replace('_', '-')}: only with --boundary")
        laws = {key: given[key] for key in ("cable", "sheave", "tension_limits", "retraction")}
        found = cw.modes(machine, pose_of(at, machine) or [], geometric=geometric, **laws)
        return answer(found, output.as_json, **output.write(found, f"Modes of {machine.name}", when=found.has_modes))
    with progress() as show:
        along = cw.boundary_modes(
            machine,
            region.criterion_name,
            grid=GRID if grid is None else grid,
            geometric=geometric,
            holding=tensions,
            progress=show,
            **given,
        )
    return answer(along, output.as_json, **output.write(along, f"Modes of {machine.name}", when=along.has_modes))
