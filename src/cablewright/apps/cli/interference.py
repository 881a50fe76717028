"""`interference`: how far lines keep from each other, the platform, the frame and a part, at a pose or along a job."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Cable,
    Limits,
    LoadName,
    Plot,
    Retracted,
    RobotName,
    Sheave,
    Wrench,
    check_plot,
    described,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.analyses.interference import Interference
    from cablewright.models.statics import Model
    from cablewright.studies.interference import JobInterference
    from cablewright.triangle_mesh import TriangleMesh

NO = 1


def interference(
    robot: RobotName,
    job: Annotated[Path | None, typer.Argument(metavar="[JOB]", help="A job TOML, or a G-code file.")] = None,
    at: Annotated[
        str | None, typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="A pose instead of a job, m and rad.")
    ] = None,
    mesh: Annotated[
        Path | None, typer.Option("--mesh", metavar="FILE.stl", help="The part, instead of what the job lays.")
    ] = None,
    mesh_scale: Annotated[
        float, typer.Option("--mesh-scale", metavar="F", help="What turns the mesh's numbers into m.")
    ] = 1.0,
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="D", help="Distance that is too near, m; 0: touching.")
    ] = 0.0,
    ends: Annotated[
        float, typer.Option("--ends", metavar="D", help="Cable at its ends that is not held against those, m.")
    ] = 0.1,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="D", help="How far a drawn line may be from the real, m.")
    ] = 1e-3,
    cable: Cable = "catenary",
    sheave: Sheave = None,
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """The smallest distances of the lines, sagging, from each other, the platform, the frame and a part."""
    from cablewright.analyses.interference import InterferenceSettings
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model
    from cablewright.printing.job import load_job
    from cablewright.printing.stl import read_stl
    from cablewright.studies.interference import interference as hold

    check_plot(plot)
    if (job is None) == (at is None):
        raise InputError("interference: either a JOB or --at X,Y,Z is wanted")
    if job is not None and retraction is not None:
        raise InputError("--retraction is for --at; along a job its schedule sets it")
    settings = InterferenceSettings(ends, tolerance)
    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave), limits(tension_limits))
    part = None if mesh is None else read_stl(mesh, mesh_scale)
    _notes(model, part)
    where = numbers(at, "--at", free=True) if job is None else load_job(job)
    with progress() as show:
        found = hold(
            model, where, part=part, clearance=clearance, settings=settings, retraction=retraction, progress=show
        )
    if plot is not None:
        found.plot(plot)
    if as_json:
        print_json(found.to_dict() | {"plot": None if plot is None else str(plot)})
    else:
        _print(found)
    if not found.ok:
        tell(f"cablewright: {found.verdict}")
    return 0 if found.ok else NO


def _notes(model: Model, part: TriangleMesh | None) -> None:
    """What the distances are not, on stderr."""
    thin = [line.name for line in model.robot.lines if line.cable.diameter is None]
    if thin:
        tell(f"the cable has no diameter, and counts as having none: line {', '.join(thin)}")
    if part is not None and not part.is_closed:
        tell("the mesh is not closed: what is inside is not known; distances are from its faces")


def _print(found: Interference | JobInterference) -> None:
    """The distances for people, one kind a line."""
    from cablewright.studies.interference import JobInterference

    typer.echo(f"{found.robot.name}: {found.status}")
    for name, contact in zip(("other lines", "platform", "frame", "part"), found.contacts, strict=True):
        if contact is None:
            typer.echo(f"{name:<12} nothing to touch")
            continue
        x, y, z = contact.place
        other = f"line {contact.other}" if contact.kind == "line" else contact.other
        place = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
        typer.echo(f"{name:<12} {contact.margin * 1e3:>10.1f} mm  line {contact.line} from {other} at {place}")
    if isinstance(found, JobInterference):
        first, share = found.first_layer, found.region.fraction
        typer.echo("no layer is touched" if first is None else f"first layer touched: {first}")
        if math.isfinite(share):
            typer.echo(f"free beside and above the whole part: {100 * share:.1f} % of where it can be held")
