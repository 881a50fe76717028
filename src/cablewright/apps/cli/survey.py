"""`survey`: winch exits, sheave axes and walls from a total station's file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import print_json, tell
from cablewright.errors import InputError
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cablewright.calibration.survey.result import Survey
    from cablewright.robot import Robot


def survey(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Leica GSI-8 or GSI-16, or CSV.")],
    plan: Annotated[
        Path | None,
        typer.Option("--plan", metavar="PLAN.toml", help="Markers, instrument and frame, where they differ."),
    ] = None,
    robot: Annotated[
        str | None, typer.Option("--robot", metavar="ROBOT", help="Whose lines the markers' numbers count.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.toml", help="Write the robot with the exits found.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Exits, sheave axes and walls from markers, in a frame along the west wall, each with its sigma."""
    from cablewright.calibration.survey.survey import survey as evaluate

    check_plot(plot)
    if out is not None and robot is None:
        raise InputError(f"--out = {str(out)!r}: there is no --robot whose exits it could have")
    own = None if robot is None else _described(robot)
    found = evaluate(file, plan, robot=None if own is None else own[0])
    notes = list(found.notes)
    if out is not None and own is not None:
        notes += _write(own, found, out)
    if plot is not None:
        found.plot(plot)
    if as_json:
        written = {"robot": None if out is None else str(out), "plot": None if plot is None else str(plot)}
        print_json(found.to_dict() | {"notes": notes} | written)
    else:
        _print(found, out, plot)
    for note in notes:
        tell(f"note: {note}")
    return 0


def _described(name: str) -> tuple[Robot, str]:
    """The robot and the text of its file."""
    from cablewright.robot import library_names, library_text, load
    from cablewright.toml_input import read_table

    return load(name), library_text(name) if name in library_names() else read_table(name)[1]


def _write(own: tuple[Robot, str], found: Survey, out: Path) -> tuple[str, ...]:
    """Write the robot as surveyed; returns what could not be taken over."""
    from cablewright.calibration.survey.surveyed_robot import surveyed
    from cablewright.robot import update

    robot, notes = surveyed(own[0], found)
    write_whole(out, update(own[1], robot).encode())
    return notes


_ZERO = {"floor": "the floor", "height": "the floor, by the instrument's height", "instrument": "the instrument's zero"}
_ORIGIN = {"station": "below the instrument", "exits": "in the middle of the exits"}


def _print(found: Survey, out: Path | None, plot: Path | None) -> None:
    """The figures for people."""
    frame = found.frame
    along = (
        "x and y of the instrument" if frame.along == "instrument" else f"y along wall {frame.along}, x into the room"
    )
    typer.echo(f"frame   {along}; origin {_ORIGIN[frame.origin]}; z = 0 is {_ZERO[frame.floor]}")
    if found.exits:
        typer.echo(f"\n{'line':<14} {'exit point, m':<32} {'sigma, mm':<15} {'winch exit, m':<32} sigma, mm")
    for one in found.exits:
        cells = (_place(one.exit_point), _sigma(one.exit_sigma), _place(one.winch_exit), _sigma(one.winch_sigma))
        typer.echo("{:<14} {:<32} {:<15} {:<32} {}".format(one.line, *cells).rstrip())
    if found.axes:
        typer.echo(f"\n{'axis':<21} {'centre, m':<32} {'sigma, mm':<15} {'direction':<25} radius, mm   arc, deg")
    for axis in found.axes:
        direction = _vector(axis.direction, 4)
        radius = f"{1e3 * axis.radius:.1f} +- {1e3 * axis.radius_sigma:.1f}"
        typer.echo(
            f"{axis.kind + ' ' + axis.line:<21} {_place(axis.point):<32} {_sigma(axis.sigma):<15} {direction:<25} "
            f"{radius:<12} {math.degrees(axis.arc):.0f}"
        )
    if found.walls:
        typer.echo(f"\n{'wall':<9} {'normal':<30} {'distance, m':<20} {'azimuth, deg':<12} {'lean, deg':<17} markers")
    for wall in found.walls:
        normal = _vector(wall.normal, 5)
        distance = f"{wall.distance:.4f} +- {wall.distance_sigma:.4f}"
        lean = "-" if math.isnan(wall.lean) else f"{math.degrees(wall.lean):.2f} +- {math.degrees(wall.lean_sigma):.2f}"
        angle = f"+- {math.degrees(wall.angle_sigma):.3f}"
        typer.echo(f"{wall.name:<9} {normal:<30} {distance:<20} {angle:<12} {lean:<17} {wall.points}")
    _print_residuals(found)
    if out is not None:
        typer.echo(f"\nrobot   {out}")
    if plot is not None:
        typer.echo(f"picture {plot}")


def _print_residuals(found: Survey) -> None:
    """One line for each marker that is checked by others or was measured more than once, and how many are not."""
    rows = [row for row in found.residuals if not (math.isnan(row.residual) and math.isnan(row.repeat))]
    if rows:
        typer.echo(f"\n{'marker':<12} {'on':<24} {'residual, mm':>12} {'expected':>9} {'shots':>6} {'repeat, mm':>11}")
    for row in rows:
        mark = "  <" if row.suspect else ""
        residual, sigma, repeat = (_mm(value) for value in (row.residual, row.sigma, row.repeat))
        typer.echo(f"{row.point:<12} {row.feature:<24} {residual:>12} {sigma:>9} {row.shots:>6} {repeat:>11}{mark}")
    if len(rows) < len(found.residuals):
        typer.echo(f"{len(found.residuals) - len(rows)} of {len(found.residuals)} markers are checked by nothing")
    if not math.isnan(found.rms):
        typer.echo(f"rms     {1e3 * found.rms:.2f} mm, {found.unit_weight:.2f} times what the instrument explains")


def _place(place: NDArray[Any] | None) -> str:
    return "-" if place is None else _vector(place, 4)


def _vector(values: NDArray[Any], digits: int) -> str:
    """Three numbers, without a minus before a zero."""
    return "(" + ", ".join(f"{round(float(value), digits) + 0.0:.{digits}f}" for value in values) + ")"


def _sigma(sigma: NDArray[Any] | None) -> str:
    return "-" if sigma is None else "{:.1f} {:.1f} {:.1f}".format(*1e3 * sigma)


def _mm(value: float) -> str:
    return "-" if math.isnan(value) else f"{1e3 * value:.2f}"
