"""`curves`: random closed curves to choose one from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import OutputOptions, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers


@dataclass(frozen=True, kw_only=True)
class CurvesCommand:
    """The curves are smooth, cross themselves, and lie within a rectangle; the one that covers it best comes first.

    --plot draws all of them to choose from; a job names its curve by number and seed.
    """

    EXAMPLE: ClassVar = "curves --count 8 --seed 2022"
    ANSWERS: ClassVar = ("printing.curve:Curves",)

    length: Annotated[float, typer.Option("--length", metavar="L", help="Length of each curve, m.")] = 28.0
    area: Annotated[
        str, typer.Option("--area", metavar="X,Y", help="Sides of the rectangle that encloses each curve, m.")
    ] = "3.6,8"
    count: Annotated[int, typer.Option("--count", metavar="N", help="Number of curves that are drawn at random.")] = 200
    seed: Seed = 0
    crossings: Annotated[
        int, typer.Option("--crossings", metavar="N", help="Minimum number of self-intersections of each curve.")
    ] = 2
    min_radius: Annotated[
        float, typer.Option("--min-radius", metavar="R", help="Minimum radius of curvature of each curve, m.")
    ] = 0.3
    output: OutputOptions

    def run(self) -> int:
        """Draw the curves and print them."""
        from cablewright.printing.curve import curves

        x, y = numbers(self.area, "--area", 2) or []
        with progress() as show:
            found = curves(
                self.length,
                (x, y),
                count=self.count,
                seed=self.seed,
                crossings=self.crossings,
                min_radius=self.min_radius,
                progress=show,
            )
        return answer(found, self.output.as_json, **self.output.write(found, "Curves to print"))
