"""`modes`: stiffness and natural frequencies of the platform at a pose."""

from __future__ import annotations

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
from cablewright.apps.cli.output import limits, numbers, print_json, tell, write_picture

if TYPE_CHECKING:
    from cablewright.analyses.modes import Modes
    from cablewright.models.statics import Equilibrium

__all__ = ["modes"]

NO = 1


def modes(
    robot: RobotName,
    at: Annotated[
        str, typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose, m and rad; `free` where gravity decides.")
    ],
    geometric: Annotated[
        bool,
        typer.Option(
            "--geometric/--no-geometric", help="Whether what tension adds to the stiffness counts for the frequencies."
        ),
    ] = True,
    cable: Cable = "catenary",
    sheave: Sheave = None,
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """The natural frequencies of the platform on its lines, with the stiffness that they come from."""
    from cablewright.analyses.modes import modes as vibrate
    from cablewright.errors import Status
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.inertia import mass_matrix
    from cablewright.models.statics import Model
    from cablewright.models.stiffness import balanced
    from cablewright.solvers.inverse import solve_inverse

    check_plot(plot)
    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave), limits(tension_limits))
    held = solve_inverse(model, numbers(at, "--at", free=True) or [], retraction=retraction)
    mass_matrix(model.robot, held.pose)  # a body of unknown inertia is bad input, whatever the pose
    found = vibrate(held, geometric=geometric) if balanced(held) else None
    if plot is not None and found is not None:
        _draw(found, plot)
    if as_json:
        written = None if plot is None or found is None else str(plot)
        print_json(_values(held, found, geometric) | {"plot": written})
    else:
        _print(held, found)
    if held.status is not Status.OK:
        tell(f"cablewright: {held.sentence()}")
    return 0 if held.status is Status.OK else NO


def _draw(found: Modes, file: Path) -> None:
    from cablewright.apps.report.modes_picture import modes_picture

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


def _print(held: Equilibrium, found: Modes | None) -> None:
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
