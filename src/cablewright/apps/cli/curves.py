"""`curves`: random closed curves to choose one from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, progress
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.printing.curve import Curves

_SHOWN = 20


def curves(
    length: Annotated[float, typer.Option("--length", metavar="L", help="Once round, m.")] = 28.0,
    area: Annotated[str, typer.Option("--area", metavar="X,Y", help="Sides of what holds it, m.")] = "3.6,8",
    count: Annotated[int, typer.Option("--count", metavar="N", help="How many are drawn.")] = 200,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Same seed, same curves.")] = 0,
    crossings: Annotated[int, typer.Option("--crossings", metavar="N", help="With itself, at least.")] = 2,
    min_radius: Annotated[float, typer.Option("--least-radius", metavar="R", help="Of curvature, m.")] = 0.3,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Random closed curves for a print, the best cover of the area first; --plot draws all to choose from."""
    from cablewright.printing.curve import curves as draw

    check_plot(plot)
    sides = numbers(area, "--area") or []
    if len(sides) != 2:
        raise InputError(f"--area = {area!r}: two numbers are wanted, X,Y in m")
    side = sides[0], sides[1]
    with progress() as show:
        found = draw(length, side, count=count, seed=seed, crossings=crossings, min_radius=min_radius, progress=show)
    if plot is not None:
        found.plot(plot)
    if as_json:
        print_json(found.to_dict() | {"plot": None if plot is None else str(plot)})
    else:
        _print(found)
    return 0


def _print(found: Curves) -> None:
    typer.echo("number  crossings  least radius m  places of the area are off it by m")
    for one in found.ranked[:_SHOWN]:
        curve = one.curve
        typer.echo(f"{one.number:6d}  {len(curve.crossings):9d}  {curve.min_radius:14.3f}  {one.mean_distance:34.3f}")
    if len(found) > _SHOWN:
        typer.echo(f"and {len(found) - _SHOWN} more: --plot draws all, --json lists all")
    typer.echo(f"a job names one by its number, with seed = {found.seed}")
