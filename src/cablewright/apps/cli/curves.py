"""`curves`: random closed curves to choose one from."""

from __future__ import annotations

from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import OutputOptions, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers


@command("curves --count 8 --seed 2022", "printing.random_curve:Curves")
def curves_command(
    *,
    length: Annotated[float, typer.Option("--length", metavar="L", help="Length of each curve, m.")] = 28.0,
    area: Annotated[
        str,
        typer.Option("--area", metavar="X,Y", help="Sides X,Y of the rectangle into which each curve has to fit, m."),
    ] = "3.6,8",
    count: Annotated[int, typer.Option("--count", metavar="N", help="Number of random curves.")] = 200,
    seed: Seed = 0,
    crossings: Annotated[
        int, typer.Option("--crossings", metavar="N", help="Minimum number of self-intersections of each curve.")
    ] = 2,
    min_radius: Annotated[
        float, typer.Option("--min-radius", metavar="R", help="Minimum radius of curvature of each curve, m.")
    ] = 0.3,
    output: OutputOptions,
) -> int:
    """The curves are smooth, cross themselves, and lie within a rectangle. The one with the best coverage comes first.

    --plot draws all of them. A job selects its curve by number and seed.
    """
    x, y = numbers(area, "--area", 2) or []
    with progress() as show:
        found = cw.curves(
            length,
            (x, y),
            count=count,
            seed=seed,
            crossings=crossings,
            min_radius=min_radius,
            progress=show,
        )
    return answer(found, output.as_json, **output.write(found, "Curves to print"))
