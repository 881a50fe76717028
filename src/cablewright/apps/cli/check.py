"""`check`: a sliced part on a robot, with a run folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, Limits, LoadName, RobotName, Wrench, described
from cablewright.apps.cli.output import limits, print_json, progress, tell

if TYPE_CHECKING:
    from cablewright.studies.check import Check


def check(
    robot: RobotName,
    job: Annotated[Path, typer.Argument(metavar="JOB", help="A job TOML, or a G-code file.")],
    tension_limits: Limits = None,
    load: LoadName = None,
    wrench: Wrench = None,
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; runs/check-ROBOT-JOB when left out.")] = None,
    as_json: AsJson = False,
) -> int:
    """Check a job on a robot: can it print it, how far off, and what lengths must the winches pay out."""
    from cablewright.apps.report import check as report
    from cablewright.printing.job import load_job
    from cablewright.printing.layers import layer_table
    from cablewright.studies import store
    from cablewright.studies.check import check as run_check

    machine, wanted = described(robot, load, wrench), load_job(job)
    folder = out or Path("runs") / store.folder_name("check", machine.name, job.stem)
    tensions = limits(tension_limits)
    with store.run_folder(folder) as part, progress() as show:
        found = run_check(machine, wanted, tension_limits=tensions, progress=show)
        show("writing report", 0, 1)
        options = {"tension_limits": tensions, "load": load, "wrench": wrench}
        store.write_check(found, part, robot, job, options)
        report.write(found, part, layer_table(found.samples, found.law))
    page = folder / "report.html"
    if as_json:
        print_json(found.to_dict() | {"report": str(page), "lengths": str(folder / "lengths.csv")})
    else:
        _print(found, page)
    if not found.feasible:
        tell(f"cablewright: {found.verdict}")
    return 0 if found.feasible else 1


def _print(found: Check, page: Path) -> None:
    """The figures for people."""
    from cablewright.analyses.accuracy.compensation import COMPENSATIONS

    hours, minutes = divmod(round(found.law.duration / 60), 60)
    summary = {each.key: each.of(found) for each in found.figures}
    typer.echo(found.verdict)
    typer.echo(
        f"layers {found.layer_count}, {found.samples.extruded_length / 1e3:.2f} km laid, {hours} h {minutes:02d} min"
    )
    typer.echo(f"tension {summary['min_tension']:.0f} to {summary['max_tension']:.0f} N")
    for name, key in (("none", "uncompensated"), ("elastic", "elastic_only"), ("full", "compensated")):
        off = summary[f"max_error_{key}"] * 1e3
        typer.echo(f"largest error {COMPENSATIONS[name].words}: {off:.3g} mm")
    if found.robot.n == 6:
        angle = summary["max_turn_uncompensated"]
        typer.echo(f"largest turn of the platform without compensation: {angle * 1e3:.3g} mrad")
    typer.echo(f"report {page}")
