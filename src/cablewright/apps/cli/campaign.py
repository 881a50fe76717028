"""`campaign`: the same print on many simulated machines within the tolerances."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import (
    Estimator,
    ExecutorOptions,
    JobFile,
    LayerCount,
    MachineName,
    OutputOptions,
    Period,
    Plant,
    RobotName,
    Seed,
    Severity,
)
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import run_path


@command(
    "campaign merlet2023 examples/blind-machines.toml --layers 1 --machines 1 --tried 0 --out runs/campaign.jsonl",
    "studies.campaigns.result:Campaign",
)
def campaign_command(
    *,
    robot: RobotName,
    job: JobFile,
    machines: Annotated[
        int,
        typer.Option(
            "--machines", metavar="N", help="Number of machines, with errors drawn at random, that print the job."
        ),
    ] = 100,
    machine: MachineName = None,
    layers: LayerCount = None,
    estimator: Estimator = None,
    plant: Plant = "quasi-static",
    severity: Severity = None,
    period: Period = 1.0,
    seed: Seed = 0,
    tried: Annotated[
        int | None,
        typer.Option(
            "--tried",
            metavar="N",
            help="Number of these machines that also print with one tolerance at a time set to zero; by default up "
            "to 10.",
        ),
    ] = None,
    max_error: Annotated[
        float | None,
        typer.Option(
            "--max-error",
            metavar="E",
            help="Largest distance of the nozzle from the path, m, at which a print counts as successful; by default "
            "the allowed error in the job file.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE.jsonl",
            help="File for the result of each machine, from which the same command resumes; by default in runs/.",
        ),
    ] = None,
    executor: ExecutorOptions,
    output: OutputOptions,
) -> int:
    """Each machine has its own seed and prints the job in closed loop, quasi-static by default.

    A print succeeds if it ends within the allowed error. Some machines print again with each tolerance set to zero, to
    find the most valuable tolerance. The same command resumes an interrupted campaign from --out. The answer is no
    (exit 1) if no machine succeeds.
    """
    from cablewright.studies.campaigns.campaign import DEFAULT_TRIED

    described = cw.load(robot)
    file = run_path(out, "campaign", described.name, job.stem, suffix=".jsonl")
    options = cw.PrintOptions(estimator, layers=layers, plant=plant, period=period, seed=seed, severity=severity)
    with executor.working(file) as (works, show):
        found = cw.campaign(
            described,
            job,
            machines,
            machine=machine,
            options=options,
            tried=min(DEFAULT_TRIED, machines) if tried is None else tried,
            allowed_error=max_error,
            file=file,
            executor=works,
            progress=show,
        )
    title = f"{found.what.job.name} on {len(found.prints)} machines of {described.name}"
    return answer(found, output.as_json, file=file, **output.write(found, title))
