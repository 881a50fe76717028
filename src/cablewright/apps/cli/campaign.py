"""`campaign`: the same print on many machines that the tolerances allow."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

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


@dataclass(frozen=True, kw_only=True)
class CampaignCommand:
    """Each machine is built by a seed of its own and prints the job in closed loop, quasi-static by default.

    A print succeeds that ends within the allowed error. Some of the machines also print with each tolerance in turn met
    exactly: what that changes says which tolerance is worth its price. The campaign can be interrupted: the same
    command resumes it from --out, with any executor. The answer is no (exit 1) if no machine succeeds.
    """

    EXAMPLE: ClassVar = (
        "campaign merlet2023 examples/blind-machines.toml --layers 1 --machines 1 --tried 0 --out runs/campaign.jsonl"
    )
    ANSWERS: ClassVar = ("studies.campaigns.result:Campaign",)

    robot: RobotName
    job: JobFile
    machines: Annotated[int, typer.Option("--machines", metavar="N", help="How many machines are built.")] = 100
    machine: MachineName = None
    layers: LayerCount = None
    estimator: Estimator = None
    plant: Plant = "quasi-static"
    severity: Severity = None
    period: Period = 1.0
    seed: Seed = 0
    tried: Annotated[
        int | None,
        typer.Option(
            "--tried", metavar="N", help="Machines on which each tolerance is met exactly too; by default up to 10."
        ),
    ] = None
    max_error: Annotated[
        float | None,
        typer.Option(
            "--max-error", metavar="E", help="Error beside the path, m, within which a print succeeds; else the job's."
        ),
    ] = None
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.jsonl", help="Results by machine, to resume from; by default in runs/."),
    ] = None
    executor: ExecutorOptions
    output: OutputOptions

    def run(self) -> int:
        """Print on all machines, draw and print the figures."""
        from cablewright.robot import load
        from cablewright.studies.campaigns.campaign import DEFAULT_TRIED, campaign
        from cablewright.studies.prints.plan import PrintOptions
        from cablewright.studies.store import folder_name

        robot = load(self.robot)
        file = self.out or Path("runs") / f"{folder_name('campaign', robot.name, self.job.stem)}.jsonl"
        options = PrintOptions(
            self.estimator,
            layers=self.layers,
            plant=self.plant,
            period=self.period,
            seed=self.seed,
            severity=self.severity,
        )
        with self.executor.working(file) as (executor, show):
            found = campaign(
                robot,
                self.job,
                self.machines,
                machine=self.machine,
                options=options,
                tried=min(DEFAULT_TRIED, self.machines) if self.tried is None else self.tried,
                allowed_error=self.max_error,
                file=file,
                executor=executor,
                progress=show,
            )
        title = f"{found.what.job.name} on {len(found.prints)} machines of {robot.name}"
        return answer(found, self.output.as_json, file=file, **self.output.write(found, title))
