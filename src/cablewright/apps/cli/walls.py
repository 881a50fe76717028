"""`walls`: the walls in a scan of a planar lidar, and where in a surveyed room the lidar is."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, tell, write_picture
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.estimation.lidar.localisation import WallPose
    from cablewright.estimation.lidar.room import Laser, RoomMap
    from cablewright.estimation.lidar.scan import LidarModel, Points
    from cablewright.estimation.lidar.scan_file import FileScan
    from cablewright.estimation.lidar.wall_lines import WallLine

__all__ = ["walls"]

_PARALLEL = math.radians(10.0)  # walls that differ by less leave the place along them open
_MAX_ROOM = 4 << 20


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

    check_plot(plot)
    if laser is not None and room is None:
        raise InputError(f"--laser = {laser!r}: there is no --room whose wall it could be")
    names = None if columns is None else [name.strip() for name in columns.split(",")]
    low, high = _pair(yaw, "--yaw")
    known = None if room is None else _room(room)
    lasers = () if laser is None else _lasers(laser)
    scan = read_scan(file, unit, angle_unit, clockwise, names)
    lidar, points, lines = _searched(scan, within, mask, noise)
    pose = None
    if known is not None:
        pose = _placed(known, lidar, scan, (math.radians(low), math.radians(high)), lasers)
    status, said = _status(lines, points)
    if plot is not None:
        from cablewright.apps.pictures.walls import walls_picture

        write_picture(plot, walls_picture, points, lines)
    if as_json:
        print_json(_values(status, scan, points, lines, lidar, known, pose, plot))
    else:
        _print(scan, points, lines, lidar, known, pose)
        if plot is not None:
            typer.echo(f"picture  {plot}")
    for note in scan.guessed:
        tell(f"note: {note}")
    if said:
        tell(said)
    if pose is not None and pose.status != "ok":
        tell(f"place: {pose.note}")
        return 1
    return 0 if lines else 1


def _searched(
    scan: FileScan, within: str, mask: str | None, noise: float | None
) -> tuple[LidarModel, Points, list[WallLine]]:
    """The points that count and the walls among them."""
    from cablewright.estimation.lidar.scan import LidarModel, estimate_noise, level_points
    from cablewright.estimation.lidar.wall_lines import LineSearch, find_lines

    low, high = _pair(within, "--range")
    masks = _masked(mask)
    if noise is not None and not 0 < noise < 1:
        raise InputError(f"--noise = {noise:g}: must be over 0 and under 1 m")
    lidar = LidarModel(min_range=low, max_range=high, masks=masks, bias_sigma=0.0)
    points = level_points(lidar, scan.angles, scan.ranges)
    lidar = LidarModel(
        min_range=low, max_range=high, masks=masks, bias_sigma=0.0, sigma=noise or estimate_noise(points)
    )
    return lidar, points, find_lines(points, lidar, LineSearch.for_noise(lidar.sigma))


def _placed(
    known: RoomMap, lidar: LidarModel, scan: FileScan, yaws: tuple[float, float], lasers: Sequence[Laser]
) -> WallPose:
    from cablewright.estimation.lidar.localisation import LidarTurn, WallSettings, start, step
    from cablewright.estimation.lidar.wall_lines import LineSearch

    search = LineSearch.for_noise(lidar.sigma)
    wide = search.merge_distance / LineSearch().merge_distance
    settings = WallSettings(
        known, (lidar,), search, yaws, near_distance=0.02 * wide, gate=0.015 * wide, distinct_distance=0.02 * wide
    )
    return step(settings, start(), LidarTurn(scan.angles, scan.ranges), lasers)[1]


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


def _room(file: Path) -> RoomMap:
    """The room that `survey --json` found."""
    from cablewright.estimation.lidar.room import RoomMap, RoomWall
    from cablewright.toml_input import read_bytes

    try:
        found = json.loads(read_bytes(file, _MAX_ROOM, "survey"))
    except (ValueError, RecursionError):
        raise InputError(f"{file}: not JSON; what `cablewright survey FILE --json` printed is wanted") from None
    try:
        sigmas = found["sigma"]["walls"]
        walls_ = [
            RoomWall(
                name,
                (float(wall["normal"][0]), float(wall["normal"][1])),
                float(wall["distance"]),
                float(sigmas[name]["angle"]),
                float(sigmas[name]["distance"]),
            )
            for name, wall in found["walls"].items()
            if not wall["normal"][2]
        ]
    except (KeyError, IndexError, TypeError, ValueError, AttributeError):
        wanted = "walls with normal and distance, and their sigma, as `cablewright survey FILE --json` prints them"
        raise InputError(f"{file}: {wanted}, are wanted") from None
    return RoomMap(tuple(walls_))


def _status(lines: Sequence[WallLine], points: Points) -> tuple[str, str]:
    """One word, and a sentence where it is not ok."""
    if not lines:
        few = f"{len(points)} points that count" if len(points) else "no point counts"
        return "no-wall", f"no wall is in sight: {few}, and no straight run of 10 points over 0.4 m among them"
    angles = [line.angle for line in lines]
    if all(abs(math.remainder(angle - angles[0], math.pi)) < _PARALLEL for angle in angles):
        return "parallel", "note: all walls in sight are nearly parallel: the place along them is not known"
    return "ok", ""


def _values(
    status: str,
    scan: FileScan,
    points: Points,
    lines: Sequence[WallLine],
    lidar: LidarModel,
    known: RoomMap | None,
    pose: WallPose | None,
    plot: Path | None,
) -> dict[str, Any]:
    return {
        "status": status,
        "walls": [
            {
                "normal": [math.cos(line.angle), math.sin(line.angle)],
                "distance": line.distance,
                "rms": math.sqrt(line.variance),
                "points": line.point_count,
                "angle": line.angle,
                "ends": line.ends,
                "length": line.length,
                "sigma_angle": math.sqrt(line.covariance[0, 0]),
                "sigma_distance": math.sqrt(line.covariance[1, 1]),
            }
            for line in lines
        ],
        "points": len(scan.ranges),
        "used": len(points),
        "on_walls": sum(line.point_count for line in lines),
        "noise": lidar.sigma,
        "length_unit": scan.length_unit,
        "angle_unit": scan.angle_unit,
        "notes": scan.guessed,
        "place": None if pose is None or known is None else _place(pose, known),
        "plot": None if plot is None else str(plot),
    }


def _place(pose: WallPose, known: RoomMap) -> dict[str, Any]:
    return {
        "status": pose.status,
        "position": pose.position,
        "yaw": pose.yaw,
        "covariance": pose.covariance,
        "confidence": pose.confidence,
        "walls": sorted({known.walls[pose.constraints[i].wall].name for i in pose.used}),
        "candidates": [
            {
                "position": one.position,
                "yaw": one.yaw,
                "variance": one.variance,
                "explained": one.explained,
                "laser_misfit": one.laser_misfit,
            }
            for one in pose.candidates
        ],
        "note": pose.note,
    }


def _print(
    scan: FileScan,
    points: Points,
    lines: Sequence[WallLine],
    lidar: LidarModel,
    known: RoomMap | None,
    pose: WallPose | None,
) -> None:
    """The figures for people."""
    angles = "" if scan.angle_unit is None else f", angles in {scan.angle_unit}"
    typer.echo(
        f"scan     {len(points)} of {len(scan.ranges)} points count; lengths in {scan.length_unit}{angles}; "
        f"noise {1e3 * lidar.sigma:.1f} mm"
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
    if pose is None or known is None:
        return
    if not math.isnan(pose.position[0]):
        x, y = pose.position
        sx, sy, syaw = (math.sqrt(value) for value in pose.covariance.diagonal())
        typer.echo(f"\nplace    x {x:.4f} +- {sx:.4f} m, y {y:.4f} +- {sy:.4f} m")
        typer.echo(f"yaw      {math.degrees(pose.yaw):.3f} +- {math.degrees(syaw):.3f} deg")
        used = ", ".join(sorted({known.walls[pose.constraints[i].wall].name for i in pose.used}))
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
