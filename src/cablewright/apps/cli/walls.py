"""`walls`: the walls in a scan of a planar lidar, and where in a surveyed room the lidar is."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, tell
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.estimation.lidar.room import Laser
    from cablewright.studies.walls import Walls


def walls(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="CSV or JSON: x,y or angle,distance; or a LaserScan.")],
    unit: Annotated[
        str | None, typer.Option("--unit", help="Of lengths that name none: m, mm, ..; else guessed.")
    ] = None,
    angle_unit: Annotated[
        str | None, typer.Option("--angle-unit", help="Of angles: rad, deg, ..; else guessed.")
    ] = None,
    clockwise: Annotated[bool, typer.Option("--clockwise", help="Angles grow clockwise, seen from above.")] = False,
    columns: Annotated[
        str | None, typer.Option("--columns", metavar="NAMES", help="Of a file without a header: angle,distance,..")
    ] = None,
    within: Annotated[str, typer.Option("--range", metavar="MIN,MAX", help="Ranges that count, m.")] = "0.05,100",
    mask: Annotated[
        str | None, typer.Option("--mask", metavar="FROM,TO[,..]", help="Bearings that see the machine itself, deg.")
    ] = None,
    noise: Annotated[float | None, typer.Option("--noise", help="Sigma of one range, m; else estimated.")] = None,
    room: Annotated[
        Path | None, typer.Option("--room", metavar="SURVEY.json", help="What `survey --json` printed: find the place.")
    ] = None,
    yaw: Annotated[str, typer.Option("--yaw", metavar="MIN,MAX", help="Yaw the lidar may have, deg.")] = "-45,45",
    laser: Annotated[
        str | None, typer.Option("--laser", metavar="WALL=D[,..]", help="Measured from the lidar to a wall, m.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Walls in a planar lidar's scan: direction, distance, and how straight; with --room the lidar's place and yaw."""
    from cablewright.estimation.lidar.scan_file import read_scan
    from cablewright.studies.walls import walls as search

    check_plot(plot)
    if laser is not None and room is None:
        raise InputError(f"--laser = {laser!r}: there is no --room whose wall it could be")
    names = None if columns is None else [name.strip() for name in columns.split(",")]
    low, high = _pair(yaw, "--yaw")
    found = search(
        read_scan(file, unit, angle_unit, clockwise, names),
        room=room,
        limits=_pair(within, "--range"),
        masks=_masked(mask),
        noise=noise,
        yaw=(math.radians(low), math.radians(high)),
        lasers=() if laser is None else _lasers(laser),
    )
    if plot is not None:
        found.plot(plot)
    if as_json:
        print_json(found.to_dict() | {"plot": None if plot is None else str(plot)})
    else:
        _print(found)
        if plot is not None:
            typer.echo(f"picture  {plot}")
    for note in found.scan.guessed:
        tell(f"note: {note}")
    if found.verdict:
        tell(found.verdict)
    if found.place is not None and found.place.pose.status != "ok":
        tell(f"place: {found.place.pose.note}")
    return 0 if found.ok else 1


def _pair(text: str, option: str) -> tuple[float, float]:
    values = numbers(text, option) or []
    if len(values) != 2 or not -math.inf < values[0] < values[1] < math.inf:
        raise InputError(f"{option} = {text!r}: two numbers that rise are wanted, MIN,MAX")
    return values[0], values[1]


def _masked(text: str | None) -> tuple[tuple[float, float], ...]:
    values = numbers(text, "--mask") or []
    if len(values) % 2 or not all(math.isfinite(value) for value in values):
        raise InputError(f"--mask = {text!r}: pairs of bearings are wanted, FROM,TO, in deg")
    turns = [math.radians(value) for value in values]
    return tuple(zip(turns[::2], turns[1::2], strict=True))


def _lasers(text: str) -> tuple[Laser, ...]:
    from cablewright.estimation.lidar.room import Laser

    found = []
    for part in text.split(","):
        wall, equals, value = part.rpartition("=")
        try:
            distance = float(value)
        except ValueError:
            distance = math.nan
        if not equals or not 0 <= distance < math.inf:
            raise InputError(f"--laser = {text!r}: WALL=DISTANCE is wanted, m, like north=2.345")
        found.append(Laser(wall.strip(), distance))
    return tuple(found)


def _print(found: Walls) -> None:
    """The figures for people."""
    scan, lines = found.scan, found.lines
    angles = "" if scan.angle_unit is None else f", angles in {scan.angle_unit}"
    typer.echo(
        f"scan     {len(found.points)} of {len(scan.ranges)} points count; lengths in {scan.length_unit}{angles}; "
        f"noise {1e3 * found.lidar.sigma:.1f} mm"
    )
    if lines:
        typer.echo(
            f"\n{'wall':>4} {'normal, deg':>18} {'distance, m':>18} {'rms, mm':>9} {'points':>7} {'length, m':>10}"
        )
    for i, line in enumerate(lines, 1):
        turn, far = math.sqrt(line.covariance[0, 0]), math.sqrt(line.covariance[1, 1])
        angle = f"{math.degrees(line.angle):.3f} +- {math.degrees(turn):.3f}"
        distance = f"{line.distance:.4f} +- {far:.4f}"
        rms = 1e3 * math.sqrt(line.variance)
        typer.echo(f"{i:>4} {angle:>18} {distance:>18} {rms:>9.2f} {line.point_count:>7} {line.length:>10.2f}")
    if found.place is None:
        return
    pose = found.place.pose
    if not math.isnan(pose.position[0]):
        x, y = pose.position
        sx, sy, syaw = (math.sqrt(value) for value in pose.covariance.diagonal())
        typer.echo(f"\nplace    x {x:.4f} +- {sx:.4f} m, y {y:.4f} +- {sy:.4f} m")
        typer.echo(f"yaw      {math.degrees(pose.yaw):.3f} +- {math.degrees(syaw):.3f} deg")
        used = ", ".join(found.place.walls)
        typer.echo(
            f"from     walls {used}; explains {100 * pose.confidence:.0f} % of the points more than any other place"
        )
    for i, one in enumerate(pose.candidates[:5], 1):
        place = f"({one.position[0]:.4f}, {one.position[1]:.4f}) m"
        spread, explained = 1e3 * math.sqrt(one.variance), 100 * one.explained
        typer.echo(
            f"{i:>4}     {place:<21} yaw {math.degrees(one.yaw):8.3f} deg, spread {spread:.2f} mm, "
            f"explains {explained:.0f} %"
        )
