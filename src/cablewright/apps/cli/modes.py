"""`modes`: stiffness and natural frequencies of the platform at a pose, or along the boundary of a workspace."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Box,
    Cable,
    Criterion,
    Geometric,
    Holding,
    LawOfRetraction,
    Limits,
    LoadName,
    Orientations,
    Plot,
    Retracted,
    RobotName,
    Sheave,
    Wrench,
    check_plot,
    described,
    retracting,
    turns,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.analyses.modes import Modes
    from cablewright.analyses.workspace.boundary_modes import Boundary

NO = 1


def modes(
    robot: RobotName,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose, m and rad; `free` where gravity decides."),
    ] = None,
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Along the boundary of the workspace instead, and at its worst place.")
    ] = False,
    geometric: Geometric = True,
    cable: Cable = "catenary",
    sheave: Sheave = None,
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    criterion: Criterion | None = None,
    grid: Annotated[int | None, typer.Option("--grid", metavar="N", help="Nodes along a side of the box; 21.")] = None,
    tensions: Holding = None,
    box: Box = None,
    point: Annotated[str | None, typer.Option("--point", help="What is at a place: nozzle or origin; nozzle.")] = None,
    orientations: Orientations = None,
    law: LawOfRetraction = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """The natural frequencies of the platform on its lines, with the stiffness that they come from."""
    from cablewright.analyses.modes import modes as vibrate
    from cablewright.analyses.workspace.boundary_modes import GRID, boundary_modes

    check_plot(plot)
    if (at is None) != boundary:
        raise InputError("modes: either --at X,Y,Z or --boundary is wanted")
    machine = described(robot, load, wrench)
    laws: dict[str, Any] = {"cable": cable, "sheave": sheave, "tension_limits": limits(tension_limits)}
    if at is not None:
        given = {"--criterion": criterion, "--grid": grid, "--tensions": tensions, "--box": box, "--point": point}
        for option, value in (given | {"--orientations": orientations, "--retraction-law": law}).items():
            if value is not None:
                raise InputError(f"{option}: only with --boundary")
        pose = numbers(at, "--at", free=True) or []
        return _show(vibrate(machine, pose, geometric=geometric, retraction=retraction, **laws), plot, as_json)
    with progress() as show:
        found = boundary_modes(
            machine,
            criterion or "exact",
            grid=GRID if grid is None else grid,
            geometric=geometric,
            holding=tensions,
            box=numbers(box, "--box"),
            point=point or "nozzle",
            orientations=turns(orientations),
            retraction=retracting(retraction, law, point or "nozzle"),
            progress=show,
            **laws,
        )
    return _show(found, plot, as_json)


def _show(found: Modes | Boundary, plot: Path | None, as_json: bool) -> int:
    """Draw and print; a no goes to stderr and gives exit code 1."""
    from cablewright.analyses.modes import Modes

    drawn = plot if found.has_modes else None
    if drawn is not None:
        found.plot(drawn)
    if as_json:
        print_json(found.to_dict() | {"plot": None if drawn is None else str(drawn)})
    elif isinstance(found, Modes):
        _print_modes(found)
    else:
        _print_boundary(found)
    if found.verdict:
        tell(f"cablewright: {found.verdict}")
    return NO if found.verdict else 0


def _print_boundary(found: Boundary) -> None:
    criterion = found.nodes.criterion
    lowest, median, highest = found.spread
    counted = "" if found.modes.geometric else ", without geometric stiffness"
    typer.echo(f"{criterion.model.robot.name}: {criterion.name}, boundary of the workspace of the {criterion.point}")
    typer.echo(f"nodes     {len(found.places)} of {found.nodes.nodes}, the outermost of {found.nodes.counted} inside")
    if found.worst is None:
        return
    typer.echo(f"lowest    {lowest:.4g} to {highest:.4g} Hz, median {median:.4g} Hz{counted}")
    shares = sorted(found.shares.items(), key=lambda item: -item[1])
    typer.echo("mostly    " + ", ".join(f"{name} at {100.0 * share:.0f} %" for name, share in shares))
    if not found.known.all():
        typer.echo(f"unheld    {int((~found.known).sum())} of {len(found.lowest)}: not counted")
    if found.beyond:
        typer.echo(f"beyond    {found.beyond} are held, but not within the limits of tension or not stably: counted")
    if found.worst_modes is not None:
        typer.echo("lowest of all:")
        _print_modes(found.worst_modes)


def _print_modes(found: Modes) -> None:
    """The modes for people: one a line, with the share of each freedom, then the lines."""
    import numpy as np

    from cablewright.analyses.modes import FREEDOMS

    held = found.equilibrium
    names = FREEDOMS[: held.model.n]
    typer.echo(f"{held.model.robot.name}: {held.status.word}")
    typer.echo("pose      " + "  ".join(f"{x:.6f}" for x in held.pose) + ("  m" if len(names) == 3 else "  m, rad"))
    if not found.has_modes:
        return
    counted = "" if found.geometric else ", without geometric stiffness"
    freedoms = "".join(f"{name:>6}" for name in names)
    typer.echo(f"{'mode':<5} {'Hz':>10}  {'mostly':<7}{freedoms}  % of energy{counted}")
    columns = zip(found.frequencies, found.dominant, found.participation.T, strict=True)
    for number, (frequency, dominant, shares) in enumerate(columns, 1):
        parts = "".join(f"{100.0 * share:>6.0f}" for share in shares)
        unstable = "  unstable" if frequency < 0 else ""
        typer.echo(f"{number:<5} {frequency:>10.4f}  {names[dominant]:<7}{parts}{unstable}")
    typer.echo(f"{'line':<14} {'tension N':>13} {'along it N/m':>13} {'sideways Hz':>13}")
    rows = zip(held.model.robot.lines, held.tensions, found.stiffness.axial, found.line_frequencies, strict=True)
    for line, tension, axial, sideways in rows:
        typer.echo(f"{line.name:<14} {tension:>13.3f} {axial:>13.0f} {sideways:>13.3f}")
    lowest, highest = np.nanmin(found.line_frequencies, initial=np.inf), found.frequencies[-1]
    if lowest < highest:
        typer.echo(f"lines swing sideways from {lowest:.2f} Hz on; modes above that may move with them")
