"""The command `poses`, which proposes the poses to measure for a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson, CalibrationPlanFile, Limits, RobotName, Seed
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import tension_range
from cablewright.foundation.choices import PoseCriterion
from cablewright.foundation.file_output import write_whole


@command("poses wang2021 --count 14 --candidates 100", "calibration.guidance.pose_selection:CalibrationPoses")
def poses_command(
    *,
    robot: RobotName,
    count: Annotated[int, typer.Option("--count", help="Number of poses to choose for the calibration.")] = 40,
    criterion: Annotated[
        PoseCriterion,
        typer.Option(
            "--criterion",
            help="Quantity that the poses minimise: the volume of the confidence ellipsoid of all unknowns, or the "
            "largest standard deviation of an exit point.",
        ),
    ] = "d-optimal",
    candidates: Annotated[
        int, typer.Option("--candidates", help="Number of random poses from which the best are chosen.")
    ] = 1000,
    sigma: Annotated[
        float, typer.Option("--sigma", help="Standard deviation of the encoder readings, as cable length in m.")
    ] = 1e-4,
    plan: CalibrationPlanFile = None,
    tension_limits: Limits = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.csv", help="CSV file to write, with the chosen poses.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Selects among random poses that the lines can hold within their limits, in an order with short travel.

    Prints the resulting sigmas beside those of as many random poses.
    """
    from cablewright.calibration.measurements import write_measured

    machine = cw.load(robot)
    found = cw.calibration_poses(
        machine,
        count,
        criterion=criterion,
        candidates=candidates,
        sigma=sigma,
        plan=plan,
        tension_limits=tension_range(tension_limits),
        seed=seed,
    )
    if out is not None:
        lengths = "lengths are those of the robot file, home first"
        comments = (f"poses to measure of {machine.name}, {criterion}; {lengths}",)
        write_whole(out, write_measured(cw.Measured(found.counted, found.poses), machine, comments).encode())
    return answer(found, as_json, out=out)
