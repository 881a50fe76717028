"""`interference`: distances of lines from each other, the platform, the frame and a part, at a pose or along a job."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import BeadSize, Clearance, LawOptions, OutputOptions, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.apps.cli.parsing import bead_size, pose_of
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import cannot_write


@command(
    "interference cogiro --at 0,-1,1.5", "analyses.interference:Interference", "studies.interference:JobInterference"
)
def interference_command(
    *,
    robot: RobotOptions,
    job: Annotated[
        Path | None, typer.Argument(metavar="[JOB]", help="A job's TOML file, or a G-code file, instead of --at.")
    ] = None,
    at: Pose = None,
    mesh: Annotated[
        Path | None,
        typer.Option("--mesh", metavar="FILE.stl", help="STL mesh of the part, instead of the strands of the job."),
    ] = None,
    mesh_scale: Annotated[
        float, typer.Option("--mesh-scale", metavar="F", help="Size in m of one unit of the mesh; 0.001 for mm.")
    ] = 1.0,
    clearance: Clearance = 0.0,
    ends: Annotated[
        float,
        typer.Option(
            "--ends",
            metavar="D",
            help="Length of cable at each end, m, that is not compared with the object at that end.",
        ),
    ] = 0.1,
    tolerance: Annotated[
        float,
        typer.Option("--tolerance", metavar="D", help="Maximum distance of a line from the chords that replace it, m."),
    ] = 1e-3,
    bead: BeadSize = None,
    laws: LawOptions,
    retraction: Retraction = None,
    output: OutputOptions,
) -> int:
    """Lines sag and stretch. Give a pose or a job; along a job the part grows.

    The answer is no (exit 1) if a distance is below --clearance, or if the lines cannot hold a pose.
    """
    if (job is None) == (at is None):
        raise InputError("interference: expected either a JOB or --at X,Y,Z")
    if job is not None and retraction is not None:
        raise InputError("--retraction is only for --at: along a job its schedule sets the retraction; leave it out")
    if bead is not None and (job is None or mesh is not None):
        raise InputError(
            "--bead is the size of the strands that a JOB lays: give a JOB and no --mesh, or leave --bead out"
        )
    settings = cw.InterferenceSettings(ends, tolerance)
    model = cw.Model.of(robot.loaded(), **laws.laws())
    part = None if mesh is None else cw.read_stl(mesh, mesh_scale)
    if part is not None and not part.is_closed:
        tell("note: the mesh is not closed, so its inside is not defined; distances are measured from its faces")
    where = pose_of(at, model.robot) if job is None else cw.load_job(job)
    with TemporaryDirectory(prefix="cablewright-") as room, progress("inverse", "distances") as show:
        try:
            found = cw.interference(
                model,
                where,
                part=part,
                clearance=clearance,
                settings=settings,
                retraction=retraction,
                bead=bead_size(bead),
                progress=show,
                room=Path(room),
            )
        except OSError as reason:
            raise cannot_write(room, reason) from None
        written = output.write(found, f"Interference of {found.robot.name}")
        return answer(found, output.as_json, **written)
