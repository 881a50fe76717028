"""`check`: a sliced part on a robot, with a run folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, JobFile, Limits, RobotOptions, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import bead, tension_limits


@dataclass(frozen=True, kw_only=True)
class CheckCommand:
    """A run folder keeps a report, all samples and the lengths that the winches have to pay out.

    The answer is no (exit 1) if a sample cannot be held or breaks a limit of the robot file, also while the nozzle
    accelerates; if lines touch each other, the platform, the frame or the part as it grows; or if the expected error is
    above the job's max_error. What was not checked is listed.
    """

    EXAMPLE: ClassVar = "check house-printer examples/helix.toml"
    ANSWERS: ClassVar = ("studies.checks.result:Check",)

    robot: RobotOptions
    job: JobFile
    tension_limits: Limits = None
    uncertainty: Annotated[
        Path | None,
        typer.Option(
            "--uncertainty",
            metavar="TOML",
            help="File of uncertain parameters; by default the robot file's [uncertainty], or else what is assumed.",
        ),
    ] = None
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="D", help="Distance under which a line is too near, m; 0: touching.")
    ] = 0.0
    interference: Annotated[
        bool, typer.Option("--interference/--no-interference", help="Find the distances of lines from everything.")
    ] = True
    expected_error: Annotated[
        bool, typer.Option("--expected-error/--no-expected-error", help="Find the error under uncertain parameters.")
    ] = True
    bead: Annotated[
        str | None,
        typer.Option(
            "--bead",
            metavar="WIDTH,HEIGHT",
            help="Width and height of all strands, like 1.2mm,0.6mm; by default of the job file, or of the G-code.",
        ),
    ] = None
    seed: Seed = 0
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; by default runs/check-ROBOT-JOB.")] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Check the job, write the run folder, and print."""
        from cablewright.apps.report import check as report
        from cablewright.printing.job import load_job
        from cablewright.printing.layers import layer_table
        from cablewright.robot import load_uncertainty
        from cablewright.studies import store
        from cablewright.studies.checks.check import check
        from cablewright.studies.checks.tables import write_check

        machine, job, tensions = self.robot.loaded(), load_job(self.job), tension_limits(self.tension_limits)
        strand = bead(self.bead)
        uncertain = None if self.uncertainty is None else load_uncertainty(self.uncertainty)
        wanted = {"interference": self.interference, "expected-error": self.expected_error}
        skipped = tuple(name for name, kept in wanted.items() if not kept)
        folder = self.out or Path("runs") / store.folder_name("check", machine.name, self.job.stem)
        with store.run_folder(folder) as part, progress(*self.kernels) as show:
            found = check(
                machine,
                job,
                tension_limits=tensions,
                uncertainty=uncertain,
                clearance=self.clearance,
                skip=skipped,
                seed=self.seed,
                bead=strand,
                progress=show,
                room=part,
            )
            show("writing report", 0, 1)
            options = {
                "tension_limits": tensions,
                "load": self.robot.load,
                "wrench": self.robot.wrench,
                "clearance": self.clearance,
                "skip": skipped,
                "seed": self.seed,
                "bead": self.bead,
            }
            write_check(found, part, self.robot.robot, self.job, options, self.uncertainty)
            report.write(found, part, layer_table(found.samples, found.law))
        return answer(found, self.as_json, report=folder / "report.html", lengths=folder / "lengths.csv")

    @property
    def kernels(self) -> tuple[str, ...]:
        """What is compiled for it: from the first on by this process, from the last on by others."""
        distances = ("distances",) if self.interference else ()
        return ("inverse", "residuals", "tension changes", "linearise", "line shapes", *distances, "forward")
