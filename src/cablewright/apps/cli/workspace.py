"""`workspace`: where a robot can be by a criterion, as a volume with its error, a surface, slices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Box,
    Count,
    Criterion,
    Grid,
    LawOfRetraction,
    Limits,
    LoadName,
    Orientations,
    Plot,
    Point,
    Retracted,
    RobotName,
    Seed,
    Sheave,
    StraightCable,
    Tolerance,
    Wrench,
    check_plot,
    described,
    retracting,
    turns,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell
from cablewright.errors import InputError, UnknownName
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from cablewright.analyses.workspace.workspace import NodeCount, Workspace

NO = 1
COUNTS = ("volume", "nodes")


def workspace(
    robot: RobotName,
    criterion: Criterion = "exact",
    count: Count = "volume",
    grid: Grid = None,
    tolerance: Tolerance = None,
    orientations: Orientations = None,
    box: Box = None,
    point: Point = "nozzle",
    retraction: Retracted = None,
    law: LawOfRetraction = None,
    cable: StraightCable = None,
    sheave: Sheave = None,
    tension_limits: Limits = None,
    load: LoadName = None,
    wrench: Wrench = None,
    wrench_box: Annotated[
        str | None,
        typer.Option("--wrench-box", metavar="FX0,FX1,FY0,..", help="Lowest and highest of each, for capacity."),
    ] = None,
    arm: Annotated[
        float, typer.Option("--arm", metavar="L", help="Arm on which a moment counts as force for capacity, m.")
    ] = 1.0,
    seed: Seed = 0,
    mesh: Annotated[
        Path | None, typer.Option("--mesh", metavar="FILE.stl|.glb", help="Write the boundary as a closed mesh, m.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Where the robot can be: volume, boundary and slices of its workspace by a criterion."""
    from cablewright.analyses.workspace import workspace as volumes

    _check_files(count, mesh, plot)
    if tolerance is not None and count == "nodes":
        raise InputError("--tolerance does not go with --count nodes, whose error is that of its grid")
    machine = described(robot, load, wrench)
    given: dict[str, Any] = {
        "cable": cable,
        "sheave": sheave,
        "tension_limits": limits(tension_limits),
        "grid": grid,
        "box": numbers(box, "--box"),
        "point": point,
        "wrench_box": _wrench_box(wrench_box, machine.n),
        "arm": arm,
        "orientations": turns(orientations),
        "retraction": retracting(retraction, law, point),
    }
    found: Workspace | NodeCount
    written: dict[str, str | None] = {}
    with progress() as show:
        if count == "nodes":
            found = volumes.count_nodes(machine, criterion, **given, progress=show)
        else:
            found = volumes.workspace(machine, criterion, tolerance=tolerance, seed=seed, **given, progress=show)
            written = _write(found, mesh, plot)
    if as_json:
        print_json(found.to_dict() | written)
    else:
        _print(found, written)
    if found.status != "ok":
        tell(f"cablewright: {found.verdict}")
    return 0 if found.status == "ok" else NO


def _check_files(count: str, mesh: Path | None, plot: Path | None) -> None:
    """Raise `InputError` unless what is asked for can be written."""
    if count not in COUNTS:
        raise UnknownName("count", count, COUNTS)
    check_plot(plot)
    if mesh is not None and mesh.suffix.lower() not in (".stl", ".glb"):
        raise InputError(f"--mesh = {str(mesh)!r}: a name that ends in .stl or .glb is wanted")
    if count == "nodes" and (mesh is not None or plot is not None):
        raise InputError("--mesh and --plot need the surface: they do not go with --count nodes")


def _wrench_box(text: str | None, n: int) -> tuple[list[float], list[float]] | None:
    """The lowest and the highest wrench; moments are zero where only forces are given."""
    values = numbers(text, "--wrench-box")
    if values is None:
        return None
    if len(values) not in (6, 2 * n):
        raise InputError(f"--wrench-box = {text!r}: 6 numbers are wanted, N, lowest and highest of each, or {2 * n}")
    values += [0.0] * (2 * n - len(values))
    return values[::2], values[1::2]


def _write(found: Workspace, mesh: Path | None, plot: Path | None) -> dict[str, str | None]:
    """Write what is asked for; nothing of an empty workspace."""
    written: dict[str, str | None] = {"mesh": None, "plot": None}
    if not found.volume:
        return written
    if mesh is not None:
        write_whole(mesh, found.mesh.stl() if mesh.suffix.lower() == ".stl" else found.mesh.glb())
        written["mesh"] = str(mesh)
    if plot is not None:
        found.plot(plot)
        written["plot"] = str(plot)
    return written


def _print(found: Workspace | NodeCount, written: dict[str, str | None]) -> None:
    """The figures for people."""
    from cablewright.analyses.workspace.workspace import Workspace

    criterion, sections = found.criterion, found.sections
    typer.echo(f"{criterion.model.robot.name}: {criterion.name}, place of the {criterion.point}")
    typer.echo(f"volume    {found.volume:.4g} m^3, give or take {found.volume_error:.2g}")
    typer.echo(f"share     {100.0 * found.fraction:.2f} % of the box of {found.box.volume:.4g} m^3")
    if isinstance(found, Workspace):
        x, y, z = found.cells
        typer.echo(f"places    {found.nodes} tried, {x} x {y} x {z} cells at last")
    else:
        typer.echo(f"nodes     {found.counted} of {found.nodes}, each an equal part of the box")
    every = max(1, len(sections["heights"]) // 10)
    typer.echo(f"{'height m':>9} {'area m^2':>10}")
    for height, area in zip(sections["heights"][::every], sections["areas"][::every], strict=True):
        typer.echo(f"{height:>9.3f} {area:>10.4f}")
    for what, file in written.items():
        if file is not None:
            typer.echo(f"{what:<9} {file}")
