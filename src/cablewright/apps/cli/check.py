"""`check`: a sliced part on a robot, with a run folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson, BeadSize, Clearance, JobFile, Limits, RobotOptions, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import bead_size, run_path, tension_range


@command("check house-printer examples/helix.toml", "studies.checks.result:Check")
def check_command(
    *,
    robot: RobotOptions,
    job: JobFile,
    tension_limits: Limits = None,
    uncertainty: Annotated[
        Path | None,
        typer.Option(
            "--uncertainty",
            metavar="TOML",
            help="TOML file of the uncertain parameters; by default the robot file's [uncertainty], and without that "
            "assumed values.",
        ),
    ] = None,
    clearance: Clearance = 0.0,
    interference: Annotated[
        bool,
        typer.Option(
            "--interference/--no-interference", help="Compute the distances of the lines from obstacles; on by default."
        ),
    ] = True,
    expected_error: Annotated[
        bool,
        typer.Option(
            "--expected-error/--no-expected-error",
            help="Compute the expected error of the nozzle that follows from the uncertain parameters; on by default.",
        ),
    ] = True,
    bead: BeadSize = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Run folder for the results; by default a folder in runs/, named for robot and job."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Writes a run folder with a report, all samples and the cable lengths for the winches.

    The answer is no (exit 1) if a sample violates a limit of the robot, also while the nozzle accelerates; if lines
    touch an obstacle; or if the expected error exceeds the job's max_error. `not checked` lists the effects that are
    not covered.
    """
    from cablewright.apps.report import check as report
    from cablewright.printing.layers import layer_table
    from cablewright.running import store
    from cablewright.studies.checks.tables import write_check

    machine, path, tensions = robot.loaded(), cw.load_job(job), tension_range(tension_limits)
    strand = bead_size(bead)
    uncertain = None if uncertainty is None else cw.load_uncertainty(uncertainty)
    distances = ("distances",) if interference else ()
    kernels = ("inverse", "residuals", "tension changes", "linearise", "line shapes", *distances, "forward")
    wanted = {"interference": interference, "expected-error": expected_error}
    skipped = tuple(name for name, kept in wanted.items() if not kept)
    folder = run_path(out, "check", machine.name, job.stem)
    with store.run_folder(folder) as part, progress(*kernels) as show:
        found = cw.check(
            machine,
            path,
            tension_limits=tensions,
            uncertainty=uncertain,
            clearance=clearance,
            skip=skipped,
            seed=seed,
            bead=strand,
            progress=show,
            room=part,
        )
        show("writing report", 0, 1)
        options: dict[str, Any] = {"tension_limits": tensions, "load": robot.load, "wrench": robot.wrench}
        options |= {"clearance": clearance, "skip": skipped, "seed": seed, "bead": bead}
        write_check(found, part, robot.robot, job, options, uncertainty)
        report.write(found, part, layer_table(found.samples, found.law))
    return answer(found, as_json, report=folder / "report.html", lengths=folder / "lengths.csv")
