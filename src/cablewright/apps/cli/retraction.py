"""`retraction`: how far to retract the end-effector at each height, and a law for it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Box,
    Criterion,
    Limits,
    LoadName,
    Plot,
    Point,
    RobotName,
    Sheave,
    StraightCable,
    Wrench,
    check_plot,
    described,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, write_picture
from cablewright.errors import AnswerError

if TYPE_CHECKING:
    from cablewright.analyses.workspace.retraction import Retracting

__all__ = ["retraction"]


def retraction(
    robot: RobotName,
    min_length: Annotated[
        float | None, typer.Option("--from", metavar="L", help="Shortest length, m; the robot's.")
    ] = None,
    max_length: Annotated[
        float | None, typer.Option("--to", metavar="L", help="Longest length, m; the robot's.")
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Lengths tried.")] = 9,
    heights: Annotated[int, typer.Option("--heights", metavar="N", help="Slices of the box.")] = 40,
    criterion: Criterion = "exact",
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="T", help="Error of each volume as a share of it.")
    ] = 2e-3,
    box: Box = None,
    point: Point = "nozzle",
    cable: StraightCable = None,
    sheave: Sheave = None,
    tension_limits: Limits = None,
    load: LoadName = None,
    wrench: Wrench = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """The best retraction length at each height, the line through it, and the workspace with that law in force."""
    from cablewright.analyses.workspace.retraction import best_retraction
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model

    check_plot(plot)
    machine = described(robot, load, wrench)
    fidelity = Fidelity.of(cable or ("catenary" if criterion == "static" else "rigid"), sheave)
    model = Model(machine, fidelity, limits(tension_limits))
    given: dict[str, Any] = {
        "min_length": min_length,
        "max_length": max_length,
        "steps": steps,
        "heights": heights,
        "tolerance": tolerance,
        "point": point,
    }
    try:
        with progress() as show:
            found = best_retraction(model, criterion, box=numbers(box, "--box"), progress=show, **given)
    except AnswerError as reason:
        if as_json:
            print_json({"status": "refused", "reason": str(reason)})
        raise
    if plot is not None:
        _draw(found, plot)
    if as_json:
        _print_json(found, plot)
    else:
        _print(found)
    return 0


def _draw(found: Retracting, file: Path) -> None:
    from cablewright.apps.pictures.retraction import retraction_picture

    write_picture(file, retraction_picture, found)


def _print_json(found: Retracting, plot: Path | None) -> None:
    criterion = found.held.criterion
    print_json(
        {
            "status": "ok",
            "robot": criterion.model.robot.name,
            "criterion": criterion.name,
            "cable": criterion.model.fidelity.cable.value,
            "point": criterion.point,
            "box": [found.held.box.low, found.held.box.high],
            "lengths": found.lengths,
            "heights": found.heights,
            "areas": found.areas,
            "volumes": found.volumes,
            "best_lengths": found.best,
            "best_areas": found.best_areas,
            "best_volume": found.best_volume,
            "law": asdict(found.law) | {"fitted_heights": found.heights[found.fitted]},
            "law_volume": found.held.volume,
            "law_volume_error": found.held.volume_error,
            "law_share": found.share,
            "plot": None if plot is None else str(plot),
        }
    )


def _print(found: Retracting) -> None:
    """For people: the volumes, the law, and the best length by height."""
    criterion, law = found.held.criterion, found.law
    typer.echo(f"{criterion.model.robot.name}: {criterion.name}, heights of the {criterion.point}")
    for length, volume in zip(found.lengths, found.volumes, strict=True):
        typer.echo(f"always {length:.3f} m          {volume:8.4f} m^3")
    typer.echo(f"best at each height     {found.best_volume:8.4f} m^3")
    typer.echo(f"with the law            {found.held.volume:8.4f} m^3, {100.0 * found.share:.1f} % of the best")
    sign = "-" if law.intercept < 0 else "+"
    typer.echo(
        f"law       l = {law.slope:.3f} z {sign} {abs(law.intercept):.3f} m, from {law.least:g} to {law.most:g} m"
    )
    at = found.heights[found.fitted]
    typer.echo(f"fitted to {len(at)} slices from {at[0]:.3f} to {at[-1]:.3f} m high")
    typer.echo(f"{'height m':>9} {'best m':>8} {'area m^2':>9}")
    every = max(1, len(found.heights) // 10)
    for height, best, area in list(zip(found.heights, found.best, found.best_areas, strict=True))[every // 2 :: every]:
        typer.echo(f"{height:>9.3f} {best:>8.3f} {area:>9.4f}")
