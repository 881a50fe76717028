"""`retraction`: how far to retract the end-effector at each height, and a law for it."""

from __future__ import annotations

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
from cablewright.apps.cli.output import limits, numbers, print_json, progress
from cablewright.errors import AnswerError

if TYPE_CHECKING:
    from cablewright.analyses.workspace.retraction import RetractionStudy


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
    from cablewright.analyses.workspace.retraction import retraction as best

    check_plot(plot)
    given: dict[str, Any] = {"cable": cable, "sheave": sheave, "tension_limits": limits(tension_limits)}
    given |= {"min_length": min_length, "max_length": max_length, "steps": steps, "heights": heights}
    given |= {"tolerance": tolerance, "point": point}
    try:
        with progress() as show:
            found = best(described(robot, load, wrench), criterion, box=numbers(box, "--box"), progress=show, **given)
    except AnswerError as reason:
        if as_json:
            print_json({"status": "refused", "reason": str(reason)})
        raise
    if plot is not None:
        found.plot(plot)
    if as_json:
        print_json(found.to_dict() | {"plot": None if plot is None else str(plot)})
    else:
        _print(found)
    return 0


def _print(found: RetractionStudy) -> None:
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
