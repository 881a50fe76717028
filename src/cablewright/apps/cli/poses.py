"""`poses`: which poses to measure for a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cablewright.apps.cli.options import AsJson, Limits, RobotName
from cablewright.apps.cli.output import limits, print_json
from cablewright.errors import InputError
from cablewright.file_output import write_whole

__all__ = ["poses"]

MAX_CANDIDATES = 20_000
MAX_POSES = 500


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
    from cablewright.calibration.plan import load_plan
    from cablewright.calibration.poses import choose
    from cablewright.calibration.problem import Measured
    from cablewright.robot import load

    for option, value, limit in (("--count", count, MAX_POSES), ("--candidates", candidates, MAX_CANDIDATES)):
        if not 1 <= value <= limit:
            raise InputError(f"{option} = {value}: from 1 to {limit} are wanted")
    if seed < 0:
        raise InputError(f"--seed = {seed}: must not be negative")
    if not 0.0 < sigma < 1.0:
        raise InputError(f"--sigma = {sigma:g}: over 0 and under 1 m is wanted")
    machine, within = load(robot), limits(tension_limits)
    if within is not None:
        machine = machine.limited(within)
    found = choose(
        machine,
        count,
        criterion=criterion,
        candidates=candidates,
        sigma=sigma,
        plan=None if plan is None else load_plan(plan),
        seed=seed,
    )
    if out is not None:
        comments = (f"poses to measure of {machine.name}, {criterion}; lengths are those of the file, home first",)
        write_whole(out, write_measured(Measured(found.counted, found.poses), machine, comments).encode())
    told = {
        "status": "ok",
        "robot": machine.name,
        "criterion": criterion,
        "count": count,
        "sigma_rms": found.sigma_rms,
        "sigma_worst": found.sigma_worst,
        "random_sigma_rms": found.random_rms,
        "random_sigma_worst": found.random_worst,
        "travel": found.travel,
        "travel_unordered": found.travel_unordered,
        "poses": found.poses,
        "counted": found.counted,
        "out": None if out is None else str(out),
    }
    if as_json:
        print_json(told)
        return 0
    typer.echo(f"{count} poses of {candidates} candidates, {criterion}, encoders {sigma * 1e3:g} mm")
    typer.echo(f"sigma of exit points   rms {found.sigma_rms * 1e3:.3g} mm, worst {found.sigma_worst * 1e3:.3g} mm")
    typer.echo(f"as many random poses   rms {found.random_rms * 1e3:.3g} mm, worst {found.random_worst * 1e3:.3g} mm")
    typer.echo(f"travel                 {found.travel:.1f} m; in the order drawn {found.travel_unordered:.1f} m")
    if out is not None:
        typer.echo(f"written to             {out}")
    return 0
