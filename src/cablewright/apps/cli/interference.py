"""`interference`: how far lines keep from each other, the platform, the frame and a part, at a pose or along a job."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import BeadSize, LawOptions, OutputOptions, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.apps.cli.parsing import bead, pose_of
from cablewright.errors import InputError
from cablewright.file_output import cannot_write


@dataclass(frozen=True, kw_only=True)
class InterferenceCommand:
    """Lines sag and stretch. Either a pose or a job is given; along a job the part grows as it is printed.

    The answer is no (exit 1) if a line touches something or is nearer to it than --clearance, or if a pose cannot be
    held.
    """

    EXAMPLE: ClassVar = "interference cogiro --at 0,-1,1.5"
    ANSWERS: ClassVar = ("analyses.interference:Interference", "studies.interference:JobInterference")

    robot: RobotOptions
    job: Annotated[
        Path | None, typer.Argument(metavar="[JOB]", help="A job's TOML file, or a G-code file, instead of --at.")
    ] = None
    at: Pose = None
    mesh: Annotated[
        Path | None,
        typer.Option("--mesh", metavar="FILE.stl", help="Mesh of the part, instead of the strands that the job lays."),
    ] = None
    mesh_scale: Annotated[
        float, typer.Option("--mesh-scale", metavar="F", help="Size in m of one unit of the mesh; 0.001 for mm.")
    ] = 1.0
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="D", help="Distance under which a line is too near, m; 0: touching.")
    ] = 0.0
    ends: Annotated[
        float,
        typer.Option(
            "--ends", metavar="D", help="Length of cable at its ends, m, not compared with what it is tied to."
        ),
    ] = 0.1
    tolerance: Annotated[
        float,
        typer.Option("--tolerance", metavar="D", help="Max distance of a line from the chords that stand for it, m."),
    ] = 1e-3
    bead: BeadSize = None
    laws: LawOptions
    retraction: Retraction = None
    output: OutputOptions

    def run(self) -> int:
        """Find the distances and print them."""
        from cablewright.analyses.interference import InterferenceSettings
        from cablewright.models.statics import Model
        from cablewright.printing.job import load_job
        from cablewright.printing.stl import read_stl
        from cablewright.studies.interference import interference

        if (self.job is None) == (self.at is None):
            raise InputError("interference: expected either a JOB or --at X,Y,Z")
        if self.job is not None and self.retraction is not None:
            raise InputError("--retraction is for --at; along a job its schedule sets it")
        if self.bead is not None and (self.job is None or self.mesh is not None):
            raise InputError("--bead is for the strands that a JOB lays: give a JOB and no --mesh")
        settings = InterferenceSettings(self.ends, self.tolerance)
        model = Model.of(self.robot.loaded(), **self.laws.laws())
        part = None if self.mesh is None else read_stl(self.mesh, self.mesh_scale)
        if part is not None and not part.is_closed:
            tell("note: the mesh is not closed: what is inside is not known; distances are from its faces")
        where = pose_of(self.at, model.robot) if self.job is None else load_job(self.job)
        with TemporaryDirectory(prefix="cablewright-") as room, progress("inverse", "distances") as show:
            try:
                found = interference(
                    model,
                    where,
                    part=part,
                    clearance=self.clearance,
                    settings=settings,
                    retraction=self.retraction,
                    bead=bead(self.bead),
                    progress=show,
                    room=Path(room),
                )
            except OSError as reason:
                raise cannot_write(room, reason) from None
            written = self.output.write(found, f"Interference of {found.robot.name}")
            return answer(found, self.output.as_json, **written)
