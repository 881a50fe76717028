"""`poses`: which poses to measure for a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cablewright.apps.cli.options import AsJson, Limits, RobotName
from cablewright.apps.cli.output import limits, print_json
from cablewright.file_output import write_whole


def poses(
    robot: RobotName,
    count: Annotated[int, typer.Option("--count", help="How many poses.")] = 40,
    criterion: Annotated[
        str, typer.Option("--criterion", help="d-optimal, or worst-sigma of an exit point.")
    ] = "d-optimal",
    candidates: Annotated[int, typer.Option("--candidates", help="Random poses to choose from.")] = 1000,
    sigma: Annotated[float, typer.Option("--sigma", help="Standard deviation of the encoders, m.")] = 1e-4,
    plan: Annotated[
        Path | None, typer.Option("--plan", metavar="TOML", help="As for calibrate: what is unknown.")
    ] = None,
    tension_limits: Limits = None,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the candidates.")] = 0,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the poses as CSV.")] = None,
    as_json: AsJson = False,
) -> int:
    """Poses that tell most of what a calibration looks for, within tension limits, in an order that moves little."""
    from cablewright.calibration.data import write_measured
    from cablewright.calibration.poses import calibration_poses
    from cablewright.calibration.problem import Measured
    from cablewright.robot import load

    machine = load(robot)
    found = calibration_poses(
        machine,
        count,
        criterion=criterion,
        candidates=candidates,
        sigma=sigma,
        plan=plan,
        tension_limits=limits(tension_limits),
        seed=seed,
    )
    if out is not None:
        comments = (f"poses to measure of {machine.name}, {criterion}; lengths are those of the file, home first",)
        write_whole(out, write_measured(Measured(found.counted, found.poses), machine, comments).encode())
    if as_json:
        print_json(found.to_dict() | {"out": None if out is None else str(out)})
        return 0
    typer.echo(f"{count} poses of {candidates} candidates, {criterion}, encoders {sigma * 1e3:g} mm")
    typer.echo(f"sigma of exit points   rms {found.sigma_rms * 1e3:.3g} mm, worst {found.sigma_worst * 1e3:.3g} mm")
    typer.echo(f"as many random poses   rms {found.random_rms * 1e3:.3g} mm, worst {found.random_worst * 1e3:.3g} mm")
    typer.echo(f"travel                 {found.travel:.1f} m; in the order drawn {found.travel_unordered:.1f} m")
    if out is not None:
        typer.echo(f"written to             {out}")
    return 0
