"""`poses`: which poses to measure for a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, CalibrationPlanFile, Limits, RobotName, Seed
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import tension_limits
from cablewright.choices import PoseCriterion
from cablewright.file_output import write_whole


@dataclass(frozen=True, kw_only=True)
class PosesCommand:
    """Chosen among random poses that the lines can hold within their tension limits, in an order that moves little.

    The sigmas that they promise stand beside those of as many random poses.
    """

    EXAMPLE: ClassVar = "poses wang2021 --count 14 --candidates 100"
    ANSWERS: ClassVar = ("calibration.guidance.selection:CalibrationPoses",)

    robot: RobotName
    count: Annotated[int, typer.Option("--count", help="Number of poses.")] = 40
    criterion: Annotated[
        PoseCriterion,
        typer.Option(
            "--criterion",
            help="What is made small: the volume of all unknowns' ellipsoid, or an exit point's largest sigma.",
        ),
    ] = "d-optimal"
    candidates: Annotated[int, typer.Option("--candidates", help="Number of random poses to choose from.")] = 1000
    sigma: Annotated[float, typer.Option("--sigma", help="Standard deviation of the encoders, m.")] = 1e-4
    plan: CalibrationPlanFile = None
    tension_limits: Limits = None
    seed: Seed = 0
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE.csv", help="Write the poses as CSV.")] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Choose the poses, write and print them."""
        from cablewright.calibration.guidance.selection import calibration_poses
        from cablewright.calibration.measurements import Measured, write_measured
        from cablewright.robot import load

        machine = load(self.robot)
        found = calibration_poses(
            machine,
            self.count,
            criterion=self.criterion,
            candidates=self.candidates,
            sigma=self.sigma,
            plan=self.plan,
            tension_limits=tension_limits(self.tension_limits),
            seed=self.seed,
        )
        if self.out is not None:
            lengths = "lengths are those of the robot file, home first"
            comments = (f"poses to measure of {machine.name}, {self.criterion}; {lengths}",)
            write_whole(self.out, write_measured(Measured(found.counted, found.poses), machine, comments).encode())
        return answer(found, self.as_json, out=self.out)
