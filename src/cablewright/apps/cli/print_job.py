"""`print`: a job printed in closed loop on a simulated machine, in a run folder from which it can be resumed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, JobFile, MachineName, Plant, RobotName, Seed, Severity
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.choices import EstimatorName, HeightRule, LawName
from cablewright.errors import InputError


@dataclass(frozen=True, kw_only=True)
class PrintJobCommand:
    """The run folder gets the log, the figures (metrics.json), a report and the structure as a mesh.

    A print that was interrupted resumes with --resume and the same options. The answer is no (exit 1) if the machine
    stops before the end of the job.
    """

    EXAMPLE: ClassVar = (
        "print merlet2023 examples/blind-machines.toml --layers 1 --plant quasi-static --out runs/example"
    )
    ANSWERS: ClassVar = ("studies.prints.print_job:PrintedJob", "studies.prints.result:StateUse")

    robot: RobotName
    job: JobFile
    machine: MachineName = None
    layers: Annotated[
        int | None, typer.Option("--layers", metavar="N", help="Print only the first N layers; by default all.")
    ] = None
    estimator: Annotated[
        EstimatorName | None,
        typer.Option(
            "--estimator",
            help="Chain of Merlet and Papegay 2023, Kalman filter of all sensors, or encoders alone; by default filter "
            "(paper for a quasi-static plant), or encoders if the machine has no lidars.",
        ),
    ] = None
    control: Annotated[
        LawName,
        typer.Option("--control", help="Control law: of Merlet and Papegay 2023, or by the machine's model."),
    ] = "model"
    height: Annotated[
        HeightRule | None,
        typer.Option(
            "--height",
            help="Height kept over the structure, or that of the job; by default structure if a lidar sees it.",
        ),
    ] = None
    plant: Plant = "dynamic"
    severity: Severity = None
    period: Annotated[float, typer.Option("--period", metavar="T", help="Time step of the quasi-static plant, s.")] = (
        1.0
    )
    seed: Seed = 0
    intrusions: Annotated[
        int, typer.Option("--intrusions", metavar="N", help="Number of simulated light-barrier interruptions.")
    ] = 0
    real_time: Annotated[bool, typer.Option("--real-time", help="Wait in each step until its time has come.")] = False
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Run folder; by default runs/print-ROBOT-JOB.")
    ] = None
    resume: Annotated[bool, typer.Option("--resume", help="Resume the print in the run folder.")] = False
    restart: Annotated[
        bool, typer.Option("--restart", help="Print again from the beginning in the run folder of the same print.")
    ] = False
    as_json: AsJson = False

    def run(self) -> int:
        """Print, write the report, and show the figures."""
        from cablewright.apps.report import print as report
        from cablewright.printing.job import load_job
        from cablewright.robot import load
        from cablewright.studies.prints.plan import PrintOptions
        from cablewright.studies.prints.print_job import print_job
        from cablewright.studies.store import folder_name

        if self.resume and self.restart:
            raise InputError("print: --resume or --restart, not both")
        name = load_job(self.job).name
        folder = self.out or Path("runs") / folder_name("print", load(self.robot).name, self.job.stem)
        options = PrintOptions(
            self.estimator, self.control, self.height, self.layers, self.plant, self.period, self.seed,
            self.intrusions, self.severity,
        )  # fmt: skip
        try:
            with progress() as show:
                found = print_job(
                    self.robot,
                    self.job,
                    folder,
                    machine=self.machine,
                    options=options,
                    resume=self.resume,
                    restart=self.restart,
                    real_time=self.real_time,
                    progress=show,
                )
                show("writing report", 0, 1)
                found = found.with_report(report.write(found.record, folder, name, found.step_times))
        except KeyboardInterrupt:
            tell(f"cablewright: interrupted; --out {folder} --resume with the same options resumes the print")
            raise
        return answer(found, self.as_json)
