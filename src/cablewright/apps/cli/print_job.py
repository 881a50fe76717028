"""`print`: a job printed closed-loop on a machine, simulated so far, in a run folder from which it goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, RobotName
from cablewright.apps.cli.output import print_json, progress, tell


def print_job(
    robot: RobotName,
    job: Annotated[Path, typer.Argument(metavar="JOB", help="A job TOML, or a G-code file.")],
    machine: Annotated[
        str | None,
        typer.Option("--machine", metavar="NAME", help="A machine's TOML file or name; that of the robot's name."),
    ] = None,
    layers: Annotated[int | None, typer.Option("--layers", metavar="N", help="The first so many; all.")] = None,
    estimator: Annotated[
        str | None, typer.Option("--estimator", help="filter, paper or encoders; by what the machine has.")
    ] = None,
    control: Annotated[str, typer.Option("--control", help="model, or the paper's: paper.")] = "model",
    height: Annotated[
        str | None, typer.Option("--height", help="structure: kept over what was laid; job: the job's own heights.")
    ] = None,
    plant: Annotated[str, typer.Option("--plant", help="dynamic, at 10 ms, or quasi-static.")] = "dynamic",
    period: Annotated[float, typer.Option("--period", metavar="T", help="Of a quasi-static step, s.")] = 1.0,
    seed: Annotated[int, typer.Option("--seed", help="Decides on the machine as built and all noise.")] = 0,
    intrusions: Annotated[
        int, typer.Option("--intrusions", metavar="N", help="Somebody walks into the light barrier so often.")
    ] = 0,
    real_time: Annotated[bool, typer.Option("--real-time", help="Each step waits for its time.")] = False,
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; runs/print-ROBOT-JOB when left out.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the print in the run folder.")] = False,
    as_json: AsJson = False,
) -> int:
    """Print a job closed-loop on a simulated machine; the run folder gets its log, its figures and a report."""
    from cablewright.apps.report import print as report
    from cablewright.printing.job import load_job
    from cablewright.robot import load
    from cablewright.studies.prints.plan import PrintOptions
    from cablewright.studies.prints.print_job import print_job as run_job
    from cablewright.studies.store import folder_name

    options = PrintOptions(estimator, control, height, layers, plant, period, seed, intrusions)  # type: ignore[arg-type]
    name = load_job(job).name
    folder = out or Path("runs") / folder_name("print", load(robot).name, job.stem)
    try:
        with progress() as show:
            found = run_job(
                robot, job, folder, machine=machine, options=options, resume=resume, real_time=real_time, progress=show
            )
            show("writing report", 0, 1)
            found = found.with_report(report.write(found.record, folder, name, found.step_times))
    except KeyboardInterrupt:
        tell(f"cablewright: stands where it was; go on with --out {folder} --resume and the same options")
        raise
    values = found.to_dict()
    if as_json:
        print_json(values)
    else:
        _print(values)
    if not found.finished:
        tell(f"cablewright: {found.status}: {found.run.reason}")
    return 0 if found.finished else 1


def _print(values: dict[str, Any]) -> None:
    """The figures for people."""
    centi = 100.0

    def line(prefix: str) -> str:
        mean, variance = values[f"{prefix}mean_path_error"], values[f"{prefix}path_error_variance"]
        max_error = values[f"{prefix}max_path_error"]
        if mean is None:
            return "not known"
        return (
            f"mean {centi * mean:.3f} cm, variance {centi**2 * variance:.4f} cm^2, at most {centi * max_error:.2f} cm"
        )

    typer.echo(f"{values['robot']}: {values['status']}, {values['layers']} layers, {values['distance']:.2f} m")
    typer.echo(f"path error, true  {line('')}")
    typer.echo(f"path error, seen  {line('estimated_')}")
    if values["mean_speed"] is not None:
        speed, variance = centi * values["mean_speed"], centi**2 * values["speed_variance"]
        typer.echo(f"speed             mean {speed:.4f} cm/s, variance {variance:.5f} (cm/s)^2")
    typer.echo(f"stops, refills    {values['barrier_stops']}, {values['refills']}")
    typer.echo(f"log               {values['log']}")
    typer.echo(f"report            {values['report']}")
