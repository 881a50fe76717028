"""`print`: a job printed in closed loop on a simulated machine, in a run folder from which it can be resumed."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import (
    AsJson,
    Estimator,
    JobFile,
    LayerCount,
    MachineName,
    Period,
    Plant,
    RobotName,
    Seed,
    Severity,
)
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.apps.cli.parsing import quantity, run_path
from cablewright.foundation.choices import HeightRule, LawName, WhoRecalibrates
from cablewright.foundation.errors import InputError


@options()
class SimulatedOptions:
    """Options of a simulated machine and of events during its print; not for real drives."""

    plant: Plant = "dynamic"
    period: Period = 1.0
    seed: Seed = 0
    intrusions: Annotated[
        int,
        typer.Option(
            "--intrusions",
            metavar="N",
            help="Number of times that a person interrupts the simulated light barrier during the print.",
        ),
    ] = 0
    place_layers: Annotated[
        int,
        typer.Option(
            "--place-layers",
            metavar="N",
            help="Stop after every N layers to measure the platform's position, for the estimator of encoders alone; "
            "by default never.",
        ),
    ] = 0
    place_sigma: Annotated[
        str,
        typer.Option(
            "--place-sigma",
            metavar="D",
            help="Standard deviation of each coordinate of the measured position, in m or with a unit.",
        ),
    ] = "1 mm"
    place_every: Annotated[
        str | None,
        typer.Option(
            "--place-every",
            metavar="T",
            help="Interval between measurements of the position, which begin at the start of the path; by default "
            "there are none.",
        ),
    ] = None
    place_stops: Annotated[
        int,
        typer.Option(
            "--place-stops",
            metavar="S",
            help="Number of places along one layer at which the position is measured, at each of these stops.",
        ),
    ] = 1
    place_learn: Annotated[
        bool,
        typer.Option(
            "--place-learn",
            help="Estimate length error, creep and compliance of each line from all measured positions.",
        ),
    ] = False
    place_tensions: Annotated[
        bool,
        typer.Option(
            "--place-tensions", help="Also correct the lengths by measured tensions at each measured position."
        ),
    ] = False
    damping: Annotated[
        bool,
        typer.Option(
            "--damping/--no-damping",
            help="Damp swings of the platform by the winches, from measured tilt and tensions.",
        ),
    ] = True
    real_time: Annotated[
        bool, typer.Option("--real-time", help="Run the simulation at the pace of the clock, not as fast as possible.")
    ] = False


@options()
class StageOptions:
    """Options of the recalibrations of a job with stages: docs/stages.md."""

    recalibration: Annotated[
        WhoRecalibrates,
        typer.Option(
            "--recalibration",
            help="Before each stage: a simulated person measures, or the print stops until the files are there.",
        ),
    ] = "simulated"
    accept_doubtful: Annotated[
        bool,
        typer.Option("--accept-doubtful", help="Go on after a doubtful recalibration, or a seam that is too large."),
    ] = False


@options()
class RunOptions:
    """Options of the run folder, and of resuming the print in it."""

    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Run folder for the results; by default a folder in runs/, named for robot and job.",
        ),
    ] = None
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume the interrupted print in the run folder of --out.")
    ] = False
    restart: Annotated[
        bool, typer.Option("--restart", help="Print again from the beginning in the run folder of the same print.")
    ] = False
    log: Annotated[
        str,
        typer.Option(
            "--log",
            metavar="every=N",
            help="Write only every N-th step to the log; orders, changes of state and scans are always written.",
        ),
    ] = "every=1"

    @property
    def log_every(self) -> int:
        """Return N: the first of each N steps is logged. Raises `InputError` for another text."""
        from cablewright.machine.log.head import MAX_EVERY

        name, _, number = self.log.partition("=")
        if name != "every" or not number.isdecimal() or not 1 <= int(number[:9]) <= MAX_EVERY:
            raise InputError(f"--log = {self.log[:60]!r}: expected every=N, with N from 1 to {MAX_EVERY} steps")
        return int(number)


ControlLaw = Annotated[
    LawName,
    typer.Option(
        "--control",
        help="Control law of the winches: that of Merlet and Papegay 2023 (paper), or one that uses the model of the "
        "robot (model).",
    ),
]


@command(
    "print merlet2023 examples/blind-machines.toml --layers 1 --plant quasi-static --out runs/example",
    "live.prints.print_job:PrintedJob",
    "live.prints.result:StateUse",
    "live.prints.print_job:LearntLine",
    "studies.stages.staged_print:StagedPrint",
)
def print_job_command(
    *,
    robot: RobotName,
    job: JobFile,
    machine: MachineName = None,
    layers: LayerCount = None,
    estimator: Estimator = None,
    control: ControlLaw = "model",
    height: Annotated[
        HeightRule | None,
        typer.Option(
            "--height",
            help="Height of the nozzle: relative to the measured structure (structure), or as in the job (job); "
            "by default structure if a lidar measures the structure, otherwise job.",
        ),
    ] = None,
    severity: Severity = None,
    simulated: SimulatedOptions,
    stages: StageOptions,
    run: RunOptions,
    as_json: AsJson = False,
) -> int:
    """A machine file with drives moves a real machine, by orders that you type: docs/drives.md.

    The run folder gets the log, the figures (metrics.json), a report and a mesh of the structure; of a job with stages
    one for each, and the files of the recalibrations between them (docs/stages.md). Resume an interrupted
    print with --resume and the same options. The answer is no (exit 1) if the machine stops before the end of the job.
    """
    from cablewright.apps.report import print as report
    from cablewright.foundation.units import DURATION, LENGTH
    from cablewright.studies.stages.staged_print import StagedPrint, print_stages

    path = cw.load_job(job)
    staged = bool(path.stages)
    if run.resume and run.restart:
        raise InputError("print: give either --resume or --restart, not both")
    if run.restart and staged:
        raise InputError("--restart: a job with stages begins again in another folder (--out)")
    if machine is not None and cw.load_machine(machine).kind != "simulated":
        _require_usual((simulated, stages), machine)
        for option, value, only in (("--estimator", estimator, "encoders"), ("--height", height, "job")):
            if value not in (None, only):
                raise InputError(f"{option} = {value}: on real drives it is {only}")
        return _print_on_drives(robot, job, machine, control, layers, run, as_json)
    if staged and layers is not None:
        raise InputError("--layers: is for jobs without stages; give heights in the job instead")
    name, folder = path.name, run_path(run.out, "print", cw.load(robot).name, job.stem)
    every = 0.0 if simulated.place_every is None else quantity(simulated.place_every, "--place-every", DURATION)
    options = cw.PrintOptions(
        estimator, control, height, layers, simulated.plant, simulated.period, simulated.seed, simulated.intrusions,
        severity, place_layers=simulated.place_layers, place_stops=simulated.place_stops,
        place_sigma=quantity(simulated.place_sigma, "--place-sigma", LENGTH), place_learn=simulated.place_learn,
        place_every=every, place_tensions=simulated.place_tensions, damping=simulated.damping,
        log_every=run.log_every,
    )  # fmt: skip

    def reported(found: cw.PrintedJob) -> cw.PrintedJob:
        return found.with_report(report.write(found.record, found.run.folder, name, found.step_times))

    found: cw.PrintedJob | StagedPrint
    try:
        with progress() as show:
            given: dict[str, Any] = {"machine": machine, "options": options, "resume": run.resume, "progress": show}
            given |= {"real_time": simulated.real_time}
            if staged:
                given |= {"recalibration": stages.recalibration, "accept_doubtful": stages.accept_doubtful}
                found = print_stages(robot, job, folder, report=reported, **given)
            else:
                found = reported(cw.print_job(robot, job, folder, restart=run.restart, **given))
    except KeyboardInterrupt:
        tell(f"cablewright: interrupted; --out {folder} --resume with the same options resumes the print")
        raise
    return answer(found, as_json)


def _require_usual(given: tuple[SimulatedOptions, StageOptions], machine: str) -> None:
    """Reject options of simulations, and of their recalibrations, for a *machine* on drives. Raises `InputError`."""
    for options_of, each in ((group, each) for group in given for each in fields(group)):
        if getattr(options_of, each.name) != each.default:
            option = f"--{each.name.replace('_', '-')}"
            raise InputError(f"{option}: is for simulated machines; {machine} names real drives")


def _print_on_drives(
    robot: str, job: Path, machine: str, control: LawName, layers: int | None, run: RunOptions, as_json: bool
) -> int:
    """Print on the drives of the machine file, by orders that a person types."""
    from cablewright.apps.cli.drives.machine_file import load_real
    from cablewright.apps.cli.drives.terminal import typed_orders
    from cablewright.apps.report import print as report
    from cablewright.live.drives.printing import print_on_drives
    from cablewright.running.run_folders import job_hashes, robot_hash

    described, path = cw.load(robot), cw.load_job(job)
    if path.stages:
        raise InputError(
            f"{job}: stages: are printed on simulated machines; on the drives of {machine} print each stage as a job "
            "of its own, with heights in place of stages, and the calibrated robot of that stage"
        )
    folder = run_path(run.out, "print", described.name, job.stem)
    with typed_orders() as operator:
        found = print_on_drives(
            described,
            path,
            folder,
            load_real(machine, described),
            Path(machine).with_suffix(""),
            operator,
            inputs={"robot": robot_hash(robot), **job_hashes(job, path)},
            law=control,
            layers=layers,
            resume=run.resume,
            restart=run.restart,
            log_every=run.log_every,
            say=tell,
        )
    page = report.write(found.record, folder, path.name, found.step_times)
    return answer(found.with_report(page), as_json)
