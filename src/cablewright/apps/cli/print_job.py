"""`print`: a job printed closed-loop on a machine, simulated so far, in a run folder from which it goes on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, RobotName
from cablewright.apps.cli.output import print_json, progress, tell

if TYPE_CHECKING:
    from cablewright.progress import Progress
    from cablewright.studies.prints.plan import MachineTwin
    from cablewright.studies.prints.run import PrintRun

__all__ = ["print_job"]


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
    from cablewright.errors import UnknownName
    from cablewright.machine.simulated.simulated_machine import PLANTS
    from cablewright.printing.job import load_job
    from cablewright.robot import load
    from cablewright.studies import store
    from cablewright.studies.prints.plan import HEIGHTS, Choices, twin_of
    from cablewright.studies.prints.run import run_print

    for name, value, known in (("plant", plant, PLANTS), ("height", height or "job", HEIGHTS)):
        if value not in known:
            raise UnknownName(name, value, known)
    described, wanted = load(robot), load_job(job)
    choices = Choices(estimator, control, height, layers, plant, period, seed, intrusions)  # type: ignore[arg-type]
    twin = twin_of(described, wanted, machine, choices)
    folder = out or Path("runs") / store.folder_name("print", described.name, job.stem)
    inputs = {"robot": store.robot_hash(robot)} | store.job_hashes(job, wanted)
    options = _options(choices) | {"machine": twin.settings.model_dump(mode="json")}
    try:
        with progress() as show:
            run = run_print(twin, folder, inputs, options, resume=resume, real_time=real_time, progress=show)
            show("writing report", 0, 1)
            values = _finished(twin, run, wanted.name, show)
    except KeyboardInterrupt:
        tell(f"cablewright: stands where it was; go on with --out {folder} --resume and the same options")
        raise
    if as_json:
        print_json(values)
    else:
        _print(values)
    if not run.finished:
        tell(f"cablewright: {values['status']}: {run.reason}")
    return 0 if run.finished else 1


def _options(choices: Any) -> dict[str, Any]:
    """What was chosen, as the manifest has it."""
    import dataclasses

    return {key: value for key, value in dataclasses.asdict(choices).items() if key != "lasers"}


def _finished(twin: MachineTwin, run: PrintRun, name: str, show: Progress) -> dict[str, Any]:
    """Make and write all that is known of the print; return what is told of it."""
    import numpy as np

    from cablewright.apps.report import print as report
    from cablewright.studies.prints.finish import finish, write_metrics

    track, ground = twin.path.track, run.machine.rig.ground.field
    found, log = finish(run.folder, track, twin.path.print_speed, ground, show)
    page = report.write(found, run.folder, name, np.array(run.timing.wall))
    status = "finished" if run.finished else run.state.value
    more: dict[str, object] = {"status": status, "reason": run.reason, "log": str(log), "report": str(page)}
    told = write_metrics(run.folder, found, run.timing, more)
    return {"robot": twin.robot.name, "machine": twin.settings.name, "estimator": twin.estimator} | told


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
