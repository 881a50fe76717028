"""`interference`: how far lines keep from each other, the platform, the frame and a part, at a pose or along a job."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell, write_picture
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.analyses.interference import Contact, Interference, InterferenceSettings
    from cablewright.models.statics import Model
    from cablewright.studies.interference import JobInterference
    from cablewright.triangle_mesh import TriangleMesh

__all__ = ["interference"]

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
    from cablewright.printing.stl import read_stl

    check_plot(plot)
    if (job is None) == (at is None):
        raise InputError("interference: either a JOB or --at X,Y,Z is wanted")
    if job is not None and retraction is not None:
        raise InputError("--retraction is for --at; along a job its schedule sets it")
    if not (math.isfinite(clearance) and clearance >= 0.0):
        raise InputError(f"--clearance = {clearance:g}: a length of 0 or more is wanted, m")
    settings = InterferenceSettings(ends, tolerance)
    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave), limits(tension_limits))
    part = None if mesh is None else read_stl(mesh, mesh_scale)
    _notes(model, part)
    found: Interference | JobInterference
    if at is not None:
        values, found = _at(model, at, part, retraction, clearance, settings)
    else:
        assert job is not None
        values, found = _along(model, job, part, clearance, settings)
    if plot is not None:
        _draw(found, plot)
    if as_json:
        print_json(values | {"plot": None if plot is None else str(plot)})
    else:
        _print(values)
    if values["status"] != "free":
        tell(f"cablewright: {_sentence(values)}")
    return 0 if values["status"] == "free" else NO


def _notes(model: Model, part: TriangleMesh | None) -> None:
    """What the distances are not, on stderr."""
    thin = [line.name for line in model.robot.lines if line.cable.diameter is None]
    if thin:
        tell(f"the cable has no diameter, and counts as having none: line {', '.join(thin)}")
    if part is not None and not part.is_closed:
        tell("the mesh is not closed: what is inside is not known; distances are from its faces")


def _at(
    model: Model,
    at: str,
    mesh: TriangleMesh | None,
    retraction: float | None,
    clearance: float,
    settings: InterferenceSettings,
) -> tuple[dict[str, Any], Interference]:
    from cablewright.analyses.interference import KINDS
    from cablewright.analyses.interference import interference as hold
    from cablewright.models.solids import of_mesh
    from cablewright.solvers.inverse import solve_inverse

    held = solve_inverse(model, numbers(at, "--at", free=True) or [], retraction=retraction)
    found = hold(held, part=None if mesh is None else of_mesh(mesh), settings=settings)
    contacts = {kind: found.nearest(kind) for kind in KINDS}
    status = _status(found.nearest(), clearance, held.status.word if not held.ok else None)
    extra = {"pose": held.pose, "tensions": held.tensions, "bound": found.bounds[0], "first_layer": None}
    return _values(status, model, contacts, clearance, settings) | extra, found


def _along(
    model: Model, job: Path, mesh: TriangleMesh | None, clearance: float, settings: InterferenceSettings
) -> tuple[dict[str, Any], JobInterference]:
    from cablewright.printing.job import load_job
    from cablewright.studies.interference import interference_over_job

    wanted = load_job(job)
    with progress() as show:
        found = interference_over_job(model, wanted, mesh=mesh, clearance=clearance, settings=settings, progress=show)
    status = _status(found.worst, clearance, "infeasible" if found.unheld else None)
    numbers_, least = found.layers()
    worst, first = found.worst, found.first_sample
    extra = {
        "job": wanted.name,
        "first_layer": found.first_layer,
        "first_gcode_line": None if first is None else int(found.samples.line[first]),
        "layer": None if worst is None else int(found.samples.layer[worst.row]),
        "gcode_line": None if worst is None else int(found.samples.line[worst.row]),
        "samples": len(found.samples),
        "unheld": found.unheld,
        "bound": found.bound,
        "layers": numbers_,
        "layer_distances": least,
        "free_fraction": found.region.fraction,
        "free_box": [[float(axis[0]), float(axis[-1])] for axis in found.region.axes],
    }
    return _values(status, model, found.contacts, clearance, settings) | extra, found


def _status(worst: Contact | None, clearance: float, unsolved: str | None) -> str:
    """One word: touching, near, what the inverse problem says, or free."""
    if worst is not None and worst.margin <= 0.0:
        return "touching"
    if worst is not None and worst.margin < clearance:
        return "near"
    return unsolved or "free"


def _values(
    status: str, model: Model, contacts: dict[str, Contact | None], clearance: float, settings: InterferenceSettings
) -> dict[str, Any]:
    """What the JSON has in either case."""
    known = [contact for contact in contacts.values() if contact is not None]
    worst = min(known, key=lambda contact: contact.margin, default=None)
    nearest = {key: _one(contacts[kind]) for key, kind in _KINDS.items()}
    return {
        "status": status,
        "robot": model.robot.name,
        "smallest_distance": None if worst is None else worst.margin,
        "kind": None if worst is None else worst.kind,
        "pair": None if worst is None else [worst.line, worst.other],
        "place": None if worst is None else worst.place,
        **{key: None if one is None else one["distance"] for key, one in nearest.items()},
        "nearest": nearest,
        "clearance": clearance,
        "ends": settings.ends,
        "tolerance": settings.tolerance,
    }


_KINDS = {"line_line": "line", "line_platform": "platform", "line_frame": "frame", "line_part": "part"}
"""What the JSON calls the kinds of things that lines may touch."""


def _one(contact: Contact | None) -> dict[str, Any] | None:
    if contact is None:
        return None
    return {"distance": contact.margin, "pair": [contact.line, contact.other], "place": contact.place}


def _sentence(values: dict[str, Any]) -> str:
    """Why the answer is no."""
    status = values["status"]
    if status not in ("touching", "near"):
        where = f" at {values['unheld']} of {values['samples']} samples" if "samples" in values else ""
        return f"no line is too near, but the pose cannot be held{where}: {status}"
    line, other = values["pair"]
    other = f"line {other}" if values["kind"] == "line" else other
    how = "touches" if status == "touching" else "comes too near to"
    when = f" in layer {values['layer']}, G-code line {values['gcode_line']}" if "layer" in values else ""
    return f"line {line} {how} {other}: {values['smallest_distance'] * 1e3:.1f} mm{when}"


def _print(values: dict[str, Any]) -> None:
    """The distances for people, one kind a line."""
    typer.echo(f"{values['robot']}: {values['status']}")
    names = {"line_line": "other lines", "line_platform": "platform", "line_frame": "frame", "line_part": "part"}
    for key, name in names.items():
        one = values["nearest"][key]
        if one is None:
            typer.echo(f"{name:<12} nothing to touch")
            continue
        x, y, z = one["place"]
        line, other = one["pair"]
        other = f"line {other}" if key == "line_line" else other
        place = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
        typer.echo(f"{name:<12} {one['distance'] * 1e3:>10.1f} mm  line {line} from {other} at {place}")
    if "layers" in values:
        first = values["first_layer"]
        typer.echo("no layer is touched" if first is None else f"first layer touched: {first}")
        if math.isfinite(values["free_fraction"]):
            typer.echo(
                f"free beside and above the whole part: {100 * values['free_fraction']:.1f} % of where it can be held"
            )


def _draw(found: Interference | JobInterference, file: Path) -> None:
    from cablewright.apps.pictures.interference import interference_picture

    write_picture(file, interference_picture, found)
