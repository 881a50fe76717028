"""`calibrate`, `simulate-calibration`: numbers of a robot from what was measured at poses; and data to try it with."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, RobotName
from cablewright.apps.cli.output import print_json, progress, tell
from cablewright.errors import AnswerError, InputError
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy import float64
    from numpy.typing import NDArray

    from cablewright.calibration.plan import CalibrationPlan
    from cablewright.calibration.result import Calibration
    from cablewright.calibration.unknowns import Unknown
    from cablewright.robot import Robot

    Array = NDArray[float64]


def calibrate(
    robot: RobotName,
    data: Annotated[Path, typer.Argument(metavar="DATA.csv", help="Columns dl_1 .. dl_m: length changes since home.")],
    datum: Annotated[
        str | None,
        typer.Option(
            "--datum", metavar="SPEC", help="Exit points to hold, like south-west,south-east.y; or inner, the default."
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option("--plan", metavar="TOML", help="Sigmas, unknowns, datum; else DATA.toml if it is there."),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the calibrated robot.")] = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE.html", help="Write the report; beside --out else.")
    ] = None,
    rough: Annotated[float, typer.Option("--rough", help="How far the file's exit points may be off, m.")] = 0.5,
    cable: Annotated[
        str, typer.Option("--cable", help="rigid; or elastic, catenary, which need tensions or measured poses.")
    ] = "rigid",
    seed: Annotated[int, typer.Option("--seed", help="Seed of the starts.")] = 0,
    as_json: AsJson = False,
) -> int:
    """Calibrate a robot from length changes at poses: exit points, home lengths, sigmas, and what stays open."""
    from cablewright.calibration.solve import calibrate as solve
    from cablewright.robot import load

    machine, asked = load(robot), _plan(plan, data, datum)
    with progress() as show:
        found = solve(machine, data, asked, seed=seed, rough=rough, cable=cable, progress=show)
    good = found.ok
    page = report or (out.with_suffix(".html") if out is not None and good else None)
    text = _updated(robot, found.robot) if out is not None and good else None
    if page is not None:
        _write_report(found, page, data)
    written = None
    if out is not None and text is not None:
        write_whole(out, text.encode())
        written = str(out)
    for note in found.notes:
        tell(f"note: {note}")
    if as_json:
        print_json(found.to_dict() | {"out": written, "report": None if page is None else str(page)})
    elif good:
        _print(found, written, page)
    if not good:
        raise AnswerError(f"not calibrated: {found.reason}")
    return 0


def simulate_calibration(
    robot: RobotName,
    poses: Annotated[int, typer.Option("--poses", help="How many; the first is home.")],
    noise: Annotated[float, typer.Option("--noise", help="Standard deviation of the encoders, m.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="CSV to write.")],
    seed: Annotated[int, typer.Option("--seed", help="Seed of poses, noise and guesses.")] = 0,
    guess: Annotated[float, typer.Option("--guess", help="How far x,y,z may be from the poses, m.")] = 0.05,
    cable: Annotated[str, typer.Option("--cable", help="rigid, elastic or catenary.")] = "rigid",
    tension_noise: Annotated[
        float | None, typer.Option("--tension-noise", help="Add tensions with this standard deviation, N.")
    ] = None,
    swivel_noise: Annotated[
        float | None, typer.Option("--swivel-noise", help="Add azimuths of the lines with this one, rad.")
    ] = None,
    tilt_noise: Annotated[
        float | None, typer.Option("--tilt-noise", help="Add the lean of a body with this one, rad.")
    ] = None,
    pose_noise: Annotated[
        float | None, typer.Option("--pose-noise", help="Measure poses with this one, m and rad, instead of guesses.")
    ] = None,
    truth: Annotated[
        Path | None, typer.Option("--truth", metavar="FILE", help="JSON with the true poses and home lengths.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Make data for calibrate: ROBOT is taken as true; x,y,z are guesses to start from, not data."""
    import json

    from cablewright.calibration.data import write_measured
    from cablewright.calibration.simulation import SensorNoise
    from cablewright.calibration.simulation import simulate_calibration as simulate
    from cablewright.robot import load

    machine = load(robot)
    sensors = SensorNoise(tension_noise, swivel_noise, tilt_noise, pose_noise)
    made = simulate(machine, poses, noise, seed=seed, guess=guess, cable=cable, sensors=sensors)
    lines = "" if cable == "rigid" else f", {cable} lines"
    made_up = f"made up: {poses} poses of {machine.name}{lines}, encoder noise {noise:g} m, seed {seed}"
    comments = (
        f"{made_up}; the first pose is home",
        f"x,y,z are guesses within {guess:g} m of the poses, not data" if pose_noise is None else "poses are measured",
        *(f"{what} noise {value:g}, SI" for what, value in vars(sensors).items() if value is not None),
    )
    write_whole(out, write_measured(made.measured, machine, comments).encode())
    if truth is not None:
        told = {"schema": 1, "poses": made.poses.tolist(), "home_lengths": made.home_lengths.tolist()}
        write_whole(truth, (json.dumps(told) + "\n").encode())
    if as_json:
        print_json(made.to_dict() | {"out": str(out)})
    else:
        typer.echo(f"{poses} poses of {machine.name}, noise {noise * 1e3:g} mm, written to {out}")
    return 0


def _plan(file: Path | None, data: Path, datum: str | None) -> CalibrationPlan:
    """What is asked: of --plan, or of the TOML beside the data; --datum counts instead of theirs."""
    from cablewright.calibration.plan import CalibrationPlan, load_plan
    from cablewright.toml_input import read_table

    beside = data.with_suffix(".toml")
    if file is None and beside != data and beside.is_file() and "lines" not in read_table(beside)[0]:
        file = beside  # not a robot's file of the same name
    asked = CalibrationPlan() if file is None else load_plan(file)
    if datum is None:
        return asked
    parts = tuple(part.strip() for part in datum.split(","))
    if asked.datum and set(asked.datum) != set(parts):
        raise InputError(f"--datum = {datum!r}: {file} has datum = {list(asked.datum)}; give one of them")
    return asked.model_copy(update={"datum": parts})


def _print_values(unknowns: Sequence[Unknown], values: Array, sigmas: Array) -> None:
    typer.echo("values")
    for unknown, value, sigma in zip(unknowns, values, sigmas, strict=True):
        size, unit = (1e3, "mm") if unknown.unit == "m" else (1.0, unknown.unit)
        typer.echo(f"  {unknown.label:<34} {value:12.6f} {unknown.unit:4} sigma {sigma * size:.3g} {unit}")


def _shown(value: float, unit: str, width: int = 0) -> str:
    """A small number with its unit: lengths in mm, angles in mrad."""
    times, shown = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}.get(unit, (1.0, unit))
    return f"{value * times:{width}.4g} {shown}"


def _updated(name: str, robot: Robot) -> str:
    """The robot's own file with the changed values, comments kept."""
    from cablewright.robot import library_names, library_text, update

    text = library_text(name) if name in library_names() else Path(name).read_text(encoding="utf-8-sig")
    return update(text, robot)


def _write_report(found: Calibration, page: Path, data: Path) -> None:
    from cablewright.apps.report.calibration import calibration_page

    write_whole(page, calibration_page(found, data.name).encode())


def _print(found: Calibration, written: str | None, page: Path | None) -> None:
    """The answer for people."""
    robot = found.problem.robot
    alone = found.alone
    lines = "" if found.problem.cable == "rigid" else f"{found.problem.cable} lines, "
    typer.echo(f"robot          {robot.name}, {lines}{found.problem.poses} poses, {found.iterations} steps")
    exact = f"encoders are exact to {found.encoder_sigma * 1e3:.4g} mm"
    exact = exact if math.isfinite(found.encoder_sigma) else "nothing tells how exact encoders are"
    typer.echo(f"lengths fit to {found.rms * 1e3:.4g} mm rms; {exact}")
    typer.echo(f"unknowns       {alone.total}, of which the data alone decide {alone.rank}")
    typer.echo(f"open           {', '.join(found.gauge) or 'nothing'}")
    held = ", ".join(found.problem.plan.datum)
    inner = "inner: exit points keep, as a whole, place and direction of the file"
    typer.echo(f"datum          {held if held and held != 'inner' else inner}")
    typer.echo("weakest")
    for each in found.weakest:
        typer.echo(f"  {_shown(each.sigma, each.unit, 10):16} {each.words}")
    _print_values(found.unknowns, found.values, found.sigma)
    for out in found.rejected:
        where = found.problem.measured.place(out.pose)
        line = "" if out.line is None else f", {out.sensor} of {out.line}"
        typer.echo(f"left out       {where}{line}: off by {_shown(out.size, out.unit)}")
    if found.suggestions:
        typer.echo("sigma of the exit points (rms, in one frame) with one more measurement, and open freedoms")
    for more in found.suggestions[:4]:
        sigmas = f"{more.before * 1e3:.3g} to {more.after * 1e3:.3g} mm"
        typer.echo(f"  {sigmas:<20} {more.open_before} to {more.open_after}   {more.words}")
    if written is not None:
        typer.echo(f"robot file     {written}")
    if page is not None:
        typer.echo(f"report         {page}")
