"""`curves`: random closed curves to choose one from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, progress, write_picture
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.printing.curve import Curve

__all__ = ["curves"]

_MAX_COUNT = 1000
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
    from cablewright.printing.curve import Wanted, draw_many, ranked

    check_plot(plot)
    sides = numbers(area, "--area") or []
    if len(sides) != 2:
        raise InputError(f"--area = {area!r}: two numbers are wanted, X,Y in m")
    if not 1 <= count <= _MAX_COUNT:
        raise InputError(f"--count = {count}: from 1 to {_MAX_COUNT} are allowed")
    if seed < 0:
        raise InputError(f"--seed = {seed}: 0 or more is wanted")
    wanted = Wanted(length, (sides[0], sides[1]), crossings, min_radius)
    with progress() as show:
        found = draw_many(wanted, seed, count, show)
    order = ranked(found, wanted.area)
    if plot is not None:
        from cablewright.apps.pictures.curves import curves_picture

        write_picture(plot, curves_picture, [(number, found[number]) for number in order], wanted)
    rows = [_row(number, found[number], distance) for number, distance in order.items()]
    if as_json:
        print_json({"status": "ok", "seed": seed, "curves": rows, "plot": None if plot is None else str(plot)})
    else:
        _print(rows, seed)
    return 0


def _row(number: int, curve: Curve, distance: float) -> dict[str, Any]:
    return {
        "number": number,
        "length": curve.length,
        "crossings": len(curve.crossings),
        "least_radius": curve.min_radius,
        "least_angle": float(curve.crossings[:, 2].min()) if len(curve.crossings) else None,
        "mean_distance": distance,
    }


def _print(rows: list[dict[str, Any]], seed: int) -> None:
    typer.echo("number  crossings  least radius m  places of the area are off it by m")
    for row in rows[:_SHOWN]:
        typer.echo(
            f"{row['number']:6d}  {row['crossings']:9d}  {row['least_radius']:14.3f}  {row['mean_distance']:34.3f}"
        )
    if len(rows) > _SHOWN:
        typer.echo(f"and {len(rows) - _SHOWN} more: --plot draws all, --json lists all")
    typer.echo(f"a job names one by its number, with seed = {seed}")
