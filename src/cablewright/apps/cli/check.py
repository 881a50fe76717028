"""`check`: a sliced part on a robot, with a run folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, JobFile, Limits, RobotOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import tension_limits


@dataclass(frozen=True, kw_only=True)
class CheckCommand:
    """A run folder keeps a report, all samples and the lengths that the winches have to pay out.

    The answer is no (exit 1) if a sample cannot be held, or breaks a limit of the robot file.
    """

    EXAMPLE: ClassVar = "check house-printer examples/helix.toml"
    ANSWERS: ClassVar = ("studies.checks.result:Check",)

    robot: RobotOptions
    job: JobFile
    tension_limits: Limits = None
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; by default runs/check-ROBOT-JOB.")] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Check the job, write the run folder, and print."""
        from cablewright.apps.report import check as report
        from cablewright.printing.job import load_job
        from cablewright.printing.layers import layer_table
        from cablewright.studies import store
        from cablewright.studies.checks.check import check

        machine, job, tensions = self.robot.loaded(), load_job(self.job), tension_limits(self.tension_limits)
        folder = self.out or Path("runs") / store.folder_name("check", machine.name, self.job.stem)
        with store.run_folder(folder) as part, progress() as show:
            found = check(machine, job, tension_limits=tensions, progress=show)
            show("writing report", 0, 1)
            options = {"tension_limits": tensions, "load": self.robot.load, "wrench": self.robot.wrench}
            store.write_check(found, part, self.robot.robot, self.job, options)
            report.write(found, part, layer_table(found.samples, found.law))
        return answer(found, self.as_json, report=folder / "report.html", lengths=folder / "lengths.csv")
