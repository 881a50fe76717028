"""`workspace`: where a robot can be by a criterion, as a volume with its error, a surface, slices."""

from __future__ import annotations

from dataclasses import asdict
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
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell, write_picture
from cablewright.errors import InputError, UnknownName
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from cablewright.analyses.workspace import criterion as criteria
    from cablewright.analyses.workspace.workspace import NodeCount, Workspace

__all__ = ["of_criterion", "workspace"]

NO = 1
COUNTS = ("volume", "nodes")
SLICES = 21  # heights that are told


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
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model

    _check_files(count, mesh, plot)
    if tolerance is not None and count == "nodes":
        raise InputError("--tolerance does not go with --count nodes, whose error is that of its grid")
    machine = described(robot, load, wrench)
    fidelity = Fidelity.of(cable or ("catenary" if criterion == "static" else "rigid"), sheave)
    given: dict[str, Any] = {
        "box": numbers(box, "--box"),
        "point": point,
        "wrench_box": _wrench_box(wrench_box, machine.n),
        "arm": arm,
        "orientations": turns(orientations),
        "retraction": retracting(retraction, law, point),
    }
    model = Model(machine, fidelity, limits(tension_limits))
    with progress() as show:
        if count == "nodes":
            return _tell_nodes(volumes.count_nodes(model, criterion, grid=grid, **given, progress=show), as_json)
        more: dict[str, Any] = {"tolerance": tolerance, "grid": grid, "seed": seed}
        found = volumes.workspace(model, criterion, **more, **given, progress=show)
    written = _write(found, mesh, plot)
    return _tell_volume(found, written, as_json)


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
        from cablewright.apps.pictures.volume import volume_picture

        write_picture(plot, volume_picture, found)
        written["plot"] = str(plot)
    return written


def of_criterion(criterion: criteria.Criterion) -> dict[str, Any]:
    """The criterion in the JSON of every command that finds a workspace."""
    from cablewright.analyses.workspace.criterion import RetractionLaw

    law, fidelity = criterion.retraction, criterion.model.fidelity
    return {
        "robot": criterion.model.robot.name,
        "criterion": criterion.name,
        "cable": fidelity.cable.value,
        "sheave": None if fidelity.sheave is None else fidelity.sheave.value,
        "point": criterion.point,
        "orientations": criterion.orientations if criterion.model.n == 6 else None,
        "retraction": None if isinstance(law, RetractionLaw) else law,
        "retraction_law": asdict(law) if isinstance(law, RetractionLaw) else None,
        "wrench_box": None if criterion.wrench_box is None else [side.tolist() for side in criterion.wrench_box],
    }


def _figures(found: Workspace | NodeCount) -> dict[str, Any]:
    """What both ways of counting have in the JSON."""
    return {
        "box": [found.box.low, found.box.high],
        "volume": found.volume,
        "volume_error": found.volume_error,
        "fraction": found.fraction,
        "nodes": found.nodes,
    }


def _tell_nodes(found: NodeCount, as_json: bool) -> int:
    status = "ok" if found.counted else "empty"
    heights, areas = found.axes[2], found.slices()
    if as_json:
        values = {"status": status} | of_criterion(found.criterion) | {"count": "nodes"} | _figures(found)
        print_json(values | {"counted": found.counted, "slices": {"heights": heights, "areas": areas}})
    else:
        _print_head(found)
        typer.echo(f"nodes     {found.counted} of {found.nodes}, each an equal part of the box")
        _print_slices(heights[:: max(1, len(heights) // 10)], areas[:: max(1, len(heights) // 10)])
    return _verdict(status)


def _tell_volume(found: Workspace, written: dict[str, str | None], as_json: bool) -> int:
    import numpy as np

    status = "empty" if not found.volume else "ok" if found.converged else "not-converged"
    heights = np.linspace(found.box.low[2], found.box.high[2], SLICES)
    areas = found.slices(heights)
    if as_json:
        values = {"status": status} | of_criterion(found.criterion) | {"count": "volume"} | _figures(found)
        values |= {"unseen": found.unseen, "cells": found.cells, "surface_area": found.mesh.area}
        print_json(values | {"slices": {"heights": heights, "areas": areas}} | written)
    else:
        _print_head(found)
        typer.echo(
            f"places    {found.nodes} tried, {found.cells[0]} x {found.cells[1]} x {found.cells[2]} cells at last"
        )
        _print_slices(heights[::2], areas[::2])
        for what, file in written.items():
            if file is not None:
                typer.echo(f"{what:<9} {file}")
    return _verdict(status)


def _print_head(found: Workspace | NodeCount) -> None:
    criterion = found.criterion
    typer.echo(f"{criterion.model.robot.name}: {criterion.name}, place of the {criterion.point}")
    typer.echo(f"volume    {found.volume:.4g} m^3, give or take {found.volume_error:.2g}")
    typer.echo(f"share     {100.0 * found.fraction:.2f} % of the box of {found.box.volume:.4g} m^3")


def _print_slices(heights: Any, areas: Any) -> None:
    typer.echo(f"{'height m':>9} {'area m^2':>10}")
    for height, area in zip(heights, areas, strict=True):
        typer.echo(f"{height:>9.3f} {area:>10.4f}")


def _verdict(status: str) -> int:
    sentences = {
        "empty": "no place in the box was found inside",
        "not-converged": "the volume's error stays over the tolerance: give a larger --tolerance, or a smaller --box "
        "around it; a workspace without thickness, as a planar robot's, has no volume",
    }
    if status == "ok":
        return 0
    tell(f"cablewright: {sentences[status]}")
    return NO
