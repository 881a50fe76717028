"""`check`, `stages`: a sliced part on a robot, with a run folder, and the fewest moves of the exit points for it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated, Any, Final

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import (
    AsJson,
    BeadSize,
    Clearance,
    JobFile,
    Limits,
    OutputOptions,
    RobotOptions,
    Seed,
)
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import bead_size, check_suffix, numbers, run_path, tension_range
from cablewright.foundation.errors import InputError

_KERNELS: Final = ("inverse", "residuals", "tension changes", "linearise", "line shapes", "distances", "forward")

UncertaintyFile = Annotated[
    Path | None,
    typer.Option(
        "--uncertainty",
        metavar="TOML",
        help="TOML file of the uncertain parameters; by default the robot file's [uncertainty], and without that "
        "assumed values.",
    ),
]
StageRecords = Annotated[
    list[Path] | None,
    typer.Option(
        "--stage-record",
        metavar="FILE",
        help="Record of the calibration of a stage, for the seams; once for each stage, in their order.",
    ),
]


@command(
    "check house-printer examples/helix.toml",
    "studies.checks.result:Check",
    "studies.stages.staged_check:StagedCheck",
)
def check_command(
    *,
    robot: RobotOptions,
    job: JobFile,
    tension_limits: Limits = None,
    uncertainty: UncertaintyFile = None,
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
    stage_record: StageRecords = None,
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
    not covered. Each layer of a job with stages is checked with the exit points of its stage: docs/stages.md.
    """
    from cablewright.calibration.drift.record import load_record
    from cablewright.running import run_folders
    from cablewright.studies.stages.staged_check import check_stages

    machine, path, tensions = robot.loaded(), cw.load_job(job), tension_range(tension_limits)
    uncertain = None if uncertainty is None else cw.load_uncertainty(uncertainty)
    kernels = [each for each in _KERNELS if interference or each != "distances"]
    skipped = ("interference",) * (not interference) + ("expected-error",) * (not expected_error)
    folder = run_path(out, "check", machine.name, job.stem)
    records = [load_record(each) for each in stage_record or ()]
    if records and not path.stages:
        raise InputError(f"--stage-record: is for jobs with stages; {job} has none")
    options: dict[str, Any] = {"tension_limits": tensions, "load": robot.load, "wrench": robot.wrench}
    options |= {"clearance": clearance, "skip": skipped, "seed": seed, "bead": bead}
    with run_folders.run_folder(folder) as part, progress(*kernels) as show:
        given: dict[str, Any] = {"tension_limits": tensions, "uncertainty": uncertain, "clearance": clearance}
        given |= {"skip": skipped, "seed": seed, "bead": bead_size(bead), "progress": show, "room": part}
        if path.stages:
            staged = check_stages(machine, path, records, **given)
            options |= {"stage_records": [run_folders.file_hash(each) for each in stage_record or ()]}
            for each in staged.stages:
                (inside := part / f"stage-{each.stage.number}").mkdir()
                _write(each.check, inside, robot.robot, job, options, uncertainty)
            shutil.copyfile(inside / run_folders.MANIFEST, part / run_folders.MANIFEST)
        else:
            found = cw.check(machine, path, **given)
            show("writing report", 0, 1)
            _write(found, part, robot.robot, job, options, uncertainty)
    if path.stages:
        return answer(staged, as_json, report=folder / "stage-1" / "report.html", stages_in=folder)
    return answer(found, as_json, report=folder / "report.html", lengths=folder / "lengths.csv")


def _write(
    found: cw.Check, folder: Path, robot: str, job: Path, options: dict[str, Any], uncertainty: Path | None
) -> None:
    """Write the tables and the report of a check."""
    from cablewright.apps.report import check as report
    from cablewright.printing.layers import layer_table
    from cablewright.studies.checks.tables import write_check

    write_check(found, folder, robot, job, options, uncertainty)
    report.write(found, folder, layer_table(found.samples, found.law))


@command(
    "stages house-printer examples/helix.toml --exit-heights 12,15 --layers 2",
    "studies.stages.search:Stages",
    "studies.stages.staged_check:CheckedStage",
    "studies.stages.seam:Seam",
)
def stages_command(
    *,
    robot: RobotOptions,
    job: JobFile,
    exit_heights: Annotated[
        str,
        typer.Option("--exit-heights", metavar="Z1,Z2,..", help="Heights of the highest exit point to search, m."),
    ],
    layers: Annotated[
        int, typer.Option("--layers", metavar="N", help="Number of layers, spread over the part, that are searched.")
    ] = 12,
    tension_limits: Limits = None,
    uncertainty: UncertaintyFile = None,
    clearance: Clearance = 0.0,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.toml", help="Write the job with the stages that were found.")
    ] = None,
    output: OutputOptions,
) -> int:
    """All exit points are raised together.

    Each layer that is searched is checked alone, at each height; then the whole part is checked in the stages
    that were found. The answer is no (exit 1) if a layer fails at each height, or the whole part fails: then no job is
    written.
    """
    from cablewright.foundation.file_output import write_whole
    from cablewright.studies.stages.job_file import staged_job_text
    from cablewright.studies.stages.search import find_stages

    check_suffix(out, "--out", ".toml")
    machine, path, tensions = robot.loaded(), cw.load_job(job), tension_range(tension_limits)
    uncertain = None if uncertainty is None else cw.load_uncertainty(uncertainty)
    with progress(*_KERNELS) as show:
        found = find_stages(
            machine,
            path.model_copy(update={"stages": ()}),
            numbers(exit_heights, "--exit-heights") or (),
            layers=layers,
            tension_limits=tensions,
            uncertainty=uncertain,
            clearance=clearance,
            seed=seed,
            progress=show,
        )
    written = output.write(found, f"Stages of {job.name} on {robot.robot}")
    if out is not None and not found.refusal:
        write_whole(out, staged_job_text(job, found.job, out).encode())
    return answer(found, output.as_json, out=None if found.refusal else out, **written)
