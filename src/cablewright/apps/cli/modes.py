"""`modes`: stiffness and natural frequencies of the platform at a pose, or along the boundary of a workspace."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import Geometric, OrientedRegionOptions, OutputOptions, Pose, RobotOptions, Tensions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers, pose_of
from cablewright.foundation.choices import SwingSignal
from cablewright.foundation.errors import InputError

OF_BOUNDARY = ("criterion", "box", "point", "orientations", "retraction_law")


@command(
    "modes jung2020 --at 0.2,0.1,0.9",
    "analyses.modes:Modes",
    "analyses.workspace.boundary_frequencies:Boundary",
    "studies.measured_modes:MeasuredModes",
)
def modes_command(
    *,
    robot: RobotOptions,
    at: Pose = None,
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Compute modes along the workspace's boundary instead of at one pose.")
    ] = False,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", metavar="LOG", help="Log of a free swing, or CSV of positions: t,x,y,z, then x2,y2,z2 and so on."
        ),
    ] = None,
    signal: Annotated[
        SwingSignal | None,
        typer.Option("--signal", help="Sensor of the log to use; by default the first of these in the log."),
    ] = None,
    span: Annotated[
        str | None,
        typer.Option(
            "--span",
            metavar="T0,T1",
            help="Start and end of the part of the log that is used, s; by default the longest time in which the "
            "winches rest, and all of a CSV file.",
        ),
    ] = None,
    geometric: Geometric = True,
    grid: Annotated[
        int | None,
        typer.Option("--grid", metavar="N", help="With --boundary: number of nodes along each side; by default 21."),
    ] = None,
    tensions: Tensions = None,
    region: OrientedRegionOptions,
    output: OutputOptions,
) -> int:
    """The platform swings on massless springs; winches stand still, without damping.

    Give one pose with --at, or use --boundary for the outermost nodes of a grid over the workspace. --log compares the
    modes with frequencies and damping of a recorded swing.
    """
    from cablewright.analyses.workspace.boundary_frequencies import GRID
    from cablewright.studies.measured_modes import measured_modes

    if log is not None and boundary:
        raise InputError("--log and --boundary: give one of them, not both")
    if log is None and (at is None) != boundary:
        raise InputError("modes: give either --at X,Y,Z or --boundary")
    machine, given = robot.loaded(), region.as_arguments()
    if log is None:
        _refuse({"signal": signal, "span": span}, "--log")
    if not boundary:
        _refuse({key: getattr(region, key) for key in OF_BOUNDARY} | {"grid": grid, "tensions": tensions}, "--boundary")
        laws = {key: given[key] for key in ("cable", "sheave", "tension_limits", "retraction")} | {
            "geometric": geometric
        }
        pose, title = pose_of(at, machine), f"Modes of {machine.name}"
        if log is not None:
            first, last = numbers(span, "--span", 2) or (None, None)
            times = None if first is None or last is None else (first, last)
            swung = measured_modes(machine, log, pose, signal=signal, span=times, **laws)
            return answer(swung, output.as_json, **output.write(swung, title))
        found = cw.modes(machine, pose or [], **laws)
        return answer(found, output.as_json, **output.write(found, title, when=found.has_modes))
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


def _refuse(given: Mapping[str, object], option: str) -> None:
    """Raise `InputError` for what is *given*, by name, and is for another *option* alone."""
    for key, value in given.items():
        if value is not None:
            raise InputError(f"--{key.replace('_', '-')}: only with {option}")
