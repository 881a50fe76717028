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
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell, write_picture
from cablewright.apps.cli.workspace import of_criterion
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.analyses.modes import Modes
    from cablewright.analyses.workspace.boundary_modes import Boundary
    from cablewright.models.statics import Equilibrium, Model

__all__ = ["modes"]

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
    from cablewright.analyses.workspace.boundary_modes import GRID, boundary_modes
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model

    check_plot(plot)
    if (at is None) != boundary:
        raise InputError("modes: either --at X,Y,Z or --boundary is wanted")
    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave), limits(tension_limits))
    given = {"--criterion": criterion, "--grid": grid, "--tensions": tensions, "--box": box, "--point": point}
    given |= {"--orientations": orientations, "--retraction-law": law}
    if at is not None:
        for option, value in given.items():
            if value is not None:
                raise InputError(f"{option}: only with --boundary")
        return _at(model, at, retraction, geometric, plot, as_json)
    with progress() as show:
        found = boundary_modes(
            model,
            criterion or "exact",
            grid=GRID if grid is None else grid,
            geometric=geometric,
            holding=tensions,
            box=numbers(box, "--box"),
            point=point or "nozzle",
            orientations=turns(orientations),
            retraction=retracting(retraction, law, point or "nozzle"),
            progress=show,
        )
    return _tell_boundary(found, plot, as_json)


def _at(model: Model, at: str, retraction: float | None, geometric: bool, plot: Path | None, as_json: bool) -> int:
    """Modes at one pose."""
    from cablewright.analyses.modes import modes as vibrate
    from cablewright.errors import Status
    from cablewright.models.inertia import mass_matrix
    from cablewright.models.stiffness import balanced
    from cablewright.solvers.inverse import solve_inverse

    held = solve_inverse(model, numbers(at, "--at", free=True) or [], retraction=retraction)
    mass_matrix(model.robot, held.pose)  # a body of unknown inertia is bad input, whatever the pose
    found = vibrate(held, geometric=geometric) if balanced(held) else None
    if plot is not None and found is not None:
        _draw(found, plot)
    if as_json:
        written = None if plot is None or found is None else str(plot)
        print_json(_values(held, found, geometric) | {"plot": written})
    else:
        _print_modes(held, found)
    if held.status is not Status.OK:
        tell(f"cablewright: {held.sentence()}")
    return 0 if held.status is Status.OK else NO


def _tell_boundary(found: Boundary, plot: Path | None, as_json: bool) -> int:
    """What is along the boundary, and the modes at the worst place of it."""
    from cablewright.analyses.modes import modes as vibrate

    status = "ok" if found.worst is not None else "unheld" if len(found.places) else "empty"
    geometric = found.modes.geometric
    held = None if found.worst is None else found.modes.equilibrium[found.worst]
    worst = None if held is None else vibrate(held, geometric=geometric)
    if plot is not None and held is not None:
        from cablewright.apps.pictures.boundary import boundary_picture

        write_picture(plot, boundary_picture, found)
    if as_json:
        fidelity = found.modes.equilibrium.model.fidelity  # of the modes: the question has straight lines
        values = {"status": status} | of_criterion(found.nodes.criterion) | {"cable": fidelity.cable.value}
        values |= dict.fromkeys((*_OF_POSE, *_OF_MODES)) if held is None else _values(held, worst, geometric)
        values |= {"status": status, "boundary": _boundary_values(found)}
        print_json(values | {"plot": None if plot is None or held is None else str(plot)})
    else:
        _print_boundary(found)
        if held is not None:
            typer.echo("lowest of all:")
            _print_modes(held, worst)
    if status != "ok":
        nothing = "no node of the grid is inside" if status == "empty" else "no node of the boundary can be held"
        tell(f"cablewright: {nothing}")
    return 0 if status == "ok" else NO


def _boundary_values(found: Boundary) -> dict[str, Any]:
    """Frequencies along a boundary for the JSON; null where there are none."""
    lowest, median, highest = found.spread
    return {
        "grid": found.nodes.inside.shape[0],
        "n": len(found.lowest),
        "unheld": int((~found.known).sum()),
        "out_of_limits": found.beyond,
        "tensions": found.holding,
        "least": lowest,
        "median": median,
        "greatest": highest,
        "dominant": found.dominant,
        "shares": found.shares,
        "worst_pose": None if found.worst is None else found.modes.equilibrium.pose[found.worst],
    }


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


def _draw(found: Modes, file: Path) -> None:
    from cablewright.apps.pictures.modes import modes_picture

    write_picture(file, modes_picture, found)


def _values(held: Equilibrium, found: Modes | None, geometric: bool) -> dict[str, Any]:
    """The figures of the JSON; null where the pose does not balance. Matrices of modes have a row for each mode."""
    values: dict[str, Any] = {
        "status": held.status.word,
        "robot": held.model.robot.name,
        "cable": held.model.fidelity.cable.value,
        "sheave": None if held.model.fidelity.sheave is None else held.model.fidelity.sheave.value,
        "pose": held.pose,
        "lengths": held.lengths,
        "tensions": held.tensions,
        "counts_geometric": geometric,
    }
    if found is None:
        return values | dict.fromkeys(_OF_MODES)
    parts, names = found.stiffness, _names(held)
    figures = (
        found.frequencies,
        [names[k] for k in found.dominant],
        found.participation.T,
        found.shapes.T,
        parts.total,
        parts.elastic,
        parts.geometric,
        parts.axial,
        found.line_frequencies,
        found.asymmetry,
    )
    return values | dict(zip(_OF_MODES, figures, strict=True))


_OF_POSE = ("pose", "lengths", "tensions", "counts_geometric")
_OF_MODES = (
    "frequencies",
    "dominant",
    "participation",
    "shapes",
    "stiffness",
    "elastic",
    "geometric",
    "axial_stiffness",
    "line_frequencies",
    "asymmetry",
)
"""What the JSON has of modes, in the order in which `_values` lists them."""


def _names(held: Equilibrium) -> tuple[str, ...]:
    from cablewright.analyses.modes import FREEDOMS

    return FREEDOMS[: held.model.n]


def _print_modes(held: Equilibrium, found: Modes | None) -> None:
    """The modes for people: one a line, with the share of each freedom, then the lines."""
    import numpy as np

    names = _names(held)
    typer.echo(f"{held.model.robot.name}: {held.status.word}")
    typer.echo("pose      " + "  ".join(f"{x:.6f}" for x in held.pose) + ("  m" if len(names) == 3 else "  m, rad"))
    if found is None:
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
