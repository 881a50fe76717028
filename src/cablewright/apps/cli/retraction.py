"""`retraction`: how far to retract the end-effector at each height, and a law for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import OutputOptions, RegionOptions, RobotOptions
from cablewright.apps.cli.output import answer, progress


@dataclass(frozen=True, kw_only=True)
class RetractionCommand:
    """The workspace is found at several constant lengths; each slice of it is largest at some length.

    The law is the line through these best lengths over the height; the workspace with the law in force is found too.
    """

    EXAMPLE: ClassVar = "retraction jung2020 --criterion closed-form --steps 3 --heights 10 --tolerance 0.05"
    ANSWERS: ClassVar = ("analyses.workspace.retraction:RetractionStudy",)

    robot: RobotOptions
    min_length: Annotated[
        float | None, typer.Option("--from", metavar="L", help="Min length, m; by default the robot's.")
    ] = None
    max_length: Annotated[
        float | None, typer.Option("--to", metavar="L", help="Max length, m; by default the robot's.")
    ] = None
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of lengths tried.")] = 9
    heights: Annotated[int, typer.Option("--heights", metavar="N", help="Number of slices of the box.")] = 40
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="T", help="Error of each volume, as a share of it.")
    ] = 2e-3
    region: RegionOptions
    output: OutputOptions

    def run(self) -> int:
        """Find the best lengths and the law, draw and print them."""
        from cablewright.analyses.workspace.retraction import retraction

        with progress() as show:
            found = retraction(
                self.robot.loaded(),
                self.region.criterion_name,
                min_length=self.min_length,
                max_length=self.max_length,
                steps=self.steps,
                heights=self.heights,
                tolerance=self.tolerance,
                progress=show,
                **self.region.as_arguments(),
            )
        return answer(found, self.output.as_json, **self.output.write(found, f"Retraction of {self.robot.robot}"))
