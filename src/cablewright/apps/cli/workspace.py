"""`workspace` and `retraction`: the robot's workspace by a criterion, and the best retraction length there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import (
    CountOptions,
    ExecutorOptions,
    OrientedRegionOptions,
    OutputOptions,
    RegionOptions,
    RobotOptions,
)
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, numbers, run_path
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole


@command(
    "workspace jung2020 --criterion closed-form --count nodes --grid 9",
    "analyses.workspace.workspace:Workspace",
    "analyses.workspace.workspace:NodeCount",
    "analyses.workspace.area:WorkspaceArea",
)
def workspace_command(
    *,
    robot: RobotOptions,
    region: OrientedRegionOptions,
    volume: CountOptions,
    wrench_box: Annotated[
        str | None,
        typer.Option(
            "--wrench-box",
            metavar="FX0,FX1,FY0,..",
            help="Min and max of each force, N, and moment, N m, that the criterion capacity must balance.",
        ),
    ] = None,
    arm: Annotated[
        float,
        typer.Option(
            "--arm", metavar="L", help="Lever arm, m, that converts moments to forces for the criterion capacity."
        ),
    ] = 1.0,
    mesh: Annotated[
        Path | None,
        typer.Option(
            "--mesh",
            metavar="FILE.stl|.glb",
            help="Mesh file to write, with the boundary of the workspace as a closed surface, in m.",
        ),
    ] = None,
    executor: ExecutorOptions,
    output: OutputOptions,
) -> int:
    """A position is in the workspace if the criterion holds for every requested orientation.

    The boundary is refined until the error of the volume is small enough. A planar robot, or a flat box, has an area.
    With --workers or --cluster, the same command resumes an interrupted run.
    """
    from cablewright.analyses.workspace.criterion import is_planar

    _check_files(volume, mesh, output)
    machine, given = robot.loaded(), region.as_arguments() | {"grid": volume.grid, "arm": arm}
    given |= {"wrench_box": _wrench_box(wrench_box, machine.n)}
    criterion = region.criterion_name
    with _working(executor, machine.name) as who:
        given |= who
        planar = is_planar(machine, given["box"])
        if planar and mesh is not None:
            raise InputError(
                "--mesh: the workspace of a planar robot is an area without a surface; --json prints "
                "its outlines instead"
            )
        if planar and volume.count == "nodes":
            raise InputError(
                "--count nodes: the workspace of a planar robot is an area; give a --box with a volume, "
                "or leave --count out"
            )
        if volume.count == "nodes":
            return answer(cw.count_nodes(machine, criterion, **given), output.as_json)
        given |= {"tolerance": volume.tolerance, "seed": volume.seed}
        find = cw.workspace_area if planar else cw.workspace
        found: cw.Workspace | cw.WorkspaceArea = find(machine, criterion, **given)
        some = found.status != "empty"
        if mesh is not None and some and isinstance(found, cw.Workspace):
            write_whole(mesh, found.mesh.stl() if mesh.suffix.lower() == ".stl" else found.mesh.glb())
        written = output.write(found, f"Workspace of {robot.robot}", when=some)
    return answer(found, output.as_json, mesh=mesh if some else None, **written)


@contextmanager
def _working(executor: ExecutorOptions, name: str) -> Iterator[dict[str, Any]]:
    """Who computes, and the progress, until the block ends. Raises `InputError`, `EnvironmentFault`."""
    if not executor.asked:
        with progress() as show:
            yield {"progress": show}
        return
    from cablewright.running.executors.parallel_margins import SharedMargin
    from cablewright.running.executors.stored_results import kept_in

    file = run_path(None, "workspace", name, suffix=".results.jsonl")
    with executor.working(file) as (works, show), kept_in(file) as kept:
        yield {"progress": show, "margins": SharedMargin(works, kept)}
    file.unlink(missing_ok=True)
    with suppress(OSError):  # it holds other runs
        file.parent.rmdir()


def _check_files(volume: CountOptions, mesh: Path | None, output: OutputOptions) -> None:
    """Raise `InputError` unless what is requested can be written."""
    check_suffix(mesh, "--mesh", ".stl", ".glb")
    if volume.count == "nodes":
        drawn = (("--mesh", mesh), ("--plot", output.plot), ("--report", output.report))
        for option, value in drawn:
            if value is not None:
                raise InputError(
                    f"{option} needs the surface of the workspace, which --count nodes does not "
                    f"compute; leave one of the two out"
                )
        if volume.tolerance is not None:
            raise InputError("--tolerance is not for --count nodes, whose error depends on --grid; leave it out")


def _wrench_box(text: str | None, n: int) -> Any:
    """Min and max wrench; moments are zero where only forces are given. Raises `InputError`."""
    values = numbers(text, "--wrench-box")
    if values is None:
        return None
    if len(values) not in (6, 2 * n):
        raise InputError(f"--wrench-box = {text!r}: expected 6 numbers, N, min and max of each, or {2 * n}")
    values += [0.0] * (2 * n - len(values))
    return values[::2], values[1::2]


@command(
    "retraction jung2020 --criterion closed-form --steps 3 --heights 10 --tolerance 0.05",
    "analyses.workspace.best_retraction:RetractionStudy",
)
def retraction_command(
    *,
    robot: RobotOptions,
    min_length: Annotated[
        float | None, typer.Option("--from", metavar="L", help="Smallest retraction length, m; by default the robot's.")
    ] = None,
    max_length: Annotated[
        float | None, typer.Option("--to", metavar="L", help="Largest retraction length, m; by default the robot's.")
    ] = None,
    steps: Annotated[
        int, typer.Option("--steps", metavar="N", help="Number of retraction lengths to try in each slice.")
    ] = 9,
    heights: Annotated[
        int, typer.Option("--heights", metavar="N", help="Number of horizontal slices of the search box.")
    ] = 40,
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance",
            metavar="T",
            help="Error of each volume, as a fraction of the volume, at which the refinement stops.",
        ),
    ] = 2e-3,
    region: RegionOptions,
    output: OutputOptions,
) -> int:
    """Computes the workspace at several constant lengths, and the best length of each slice.

    The law is the line through these best lengths over the height. The workspace with this law is computed too.
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
