"""`survey` and `walls`: exit points and walls from a total station, and walls and the lidar's place from its scan."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, tell
from cablewright.apps.cli.parsing import interval, lasers, numbers
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole


@command("survey examples/survey.gsi --plan examples/survey.toml", "calibration.survey.result:Survey")
def survey_command(
    *,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of the total station: Leica GSI-8, GSI-16, or CSV.")
    ],
    plan: Annotated[
        Path | None,
        typer.Option(
            "--plan",
            metavar="PLAN.toml",
            help="Plan file (TOML): the part that each marker is on, standard deviations of the instrument, and "
            "coordinate frame.",
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option("--robot", metavar="ROBOT", help="Robot that the line numbers of the markers refer to."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="Robot file to write, with the computed exit points."),
    ] = None,
    output: OutputOptions,
) -> int:
    """In the result, y points along the west wall and x into the room, unless the plan changes this.

    Each result has a standard deviation. Markers with a bad fit are flagged.
    """
    from cablewright.calibration.survey.result import surveyed
    from cablewright.robot import file_text, update

    if out is not None and robot is None:
        raise InputError(f"--out = {str(out)!r}: give --robot too, the robot file that gets the surveyed exit points")
    found = cw.survey(file, plan, robot=None if robot is None else cw.load(robot))
    if out is not None and robot is not None:
        rebuilt, notes = surveyed(cw.load(robot), found)
        write_whole(out, update(file_text(robot), rebuilt).encode())
        for note in notes:
            tell(f"note: {note}")
    return answer(found, output.as_json, robot=out, **output.write(found, "Survey"))


@options("Scan")
class ScanOptions:
    """Options of the lidar scan's file."""

    unit: Annotated[
        str | None,
        typer.Option(
            "--unit",
            help="Unit of the lengths in a file that states none: m, mm, ..; by default guessed from the values.",
        ),
    ] = None
    angle_unit: Annotated[
        str | None,
        typer.Option(
            "--angle-unit",
            help="Unit of the angles in a file that states none: rad, deg, ..; by default guessed from the values.",
        ),
    ] = None
    clockwise: Annotated[
        bool,
        typer.Option(
            "--clockwise", help="The angles of the file grow clockwise, seen from above; by default counter-clockwise."
        ),
    ] = False
    columns: Annotated[
        str | None,
        typer.Option(
            "--columns", metavar="NAMES", help="Names of the columns of a file without a header: angle,distance,.."
        ),
    ] = None
    within: Annotated[
        str, typer.Option("--range", metavar="MIN,MAX", help="Smallest and largest range of the points to use, m.")
    ] = "0.05,100"
    mask: Annotated[
        str | None,
        typer.Option(
            "--mask",
            metavar="FROM,TO[,..]",
            help="Sectors FROM,TO of bearings, deg, in which the lidar sees the "
            "machine itself; points there are not used.",
        ),
    ] = None
    keep_housing: Annotated[
        bool, typer.Option("--keep-housing", help="Also use points that look like the lidar's housing.")
    ] = False
    noise: Annotated[
        float | None,
        typer.Option(
            "--noise",
            help="Standard deviation of all ranges, m; by default estimated from the data, as a function of the range.",
        ),
    ] = None
    device: Annotated[
        str | None,
        typer.Option(
            "--device",
            help="Lidar whose scan is read from a file with scans of several lidars: its column, topic or frame.",
        ),
    ] = None


@options("Room")
class RoomOptions:
    """Options of the room in which the lidar is located."""

    room: Annotated[
        Path | None,
        typer.Option(
            "--room",
            metavar="SURVEY.json",
            help="Room in which to find the pose of the lidar: JSON file with the output of `survey --json`.",
        ),
    ] = None
    yaw: Annotated[
        str,
        typer.Option(
            "--yaw", metavar="MIN,MAX", help="Range MIN,MAX of the lidar's yaw in the room, deg, in which to search."
        ),
    ] = "-45,45"
    laser: Annotated[
        str | None,
        typer.Option(
            "--laser",
            metavar="WALL=D[,..]",
            help="Distance from the lidar to a wall, measured by hand, m, as WALL=D; several are separated by commas.",
        ),
    ] = None


@command("walls examples/scan.csv", "studies.walls:Walls")
def walls_command(
    *,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="CSV or JSON with x,y or angle,distance; or a laser scan of ROS or Foxglove."
        ),
    ],
    scan: ScanOptions,
    place: RoomOptions,
    output: OutputOptions,
) -> int:
    """Prints direction, distance and straightness of each wall; with --room also position and yaw of the lidar.

    The answer is no (exit 1) if no wall is in sight, or if the position is unknown.
    """
    if place.laser is not None and place.room is None:
        raise InputError(
            f"--laser = {place.laser!r}: give --room too, the file with the walls that the distances are measured to"
        )
    names = None if scan.columns is None else [name.strip() for name in scan.columns.split(",")]
    low, high = interval(place.yaw, "--yaw")
    found = cw.walls(
        cw.read_scan(file, scan.unit, scan.angle_unit, scan.clockwise, names, scan.device),
        room=place.room,
        limits=interval(scan.within, "--range"),
        masks=_masks(scan.mask),
        noise=scan.noise,
        keep_housing=scan.keep_housing,
        yaw=(math.radians(low), math.radians(high)),
        lasers=lasers(place.laser),
    )
    return answer(found, output.as_json, **output.write(found, "Walls in a scan"))


def _masks(text: str | None) -> tuple[tuple[float, float], ...]:
    values = numbers(text, "--mask") or []
    if len(values) % 2 or not all(map(math.isfinite, values)):
        raise InputError(f"--mask = {text!r}: expected pairs of bearings, FROM,TO, in deg")
    turns = [math.radians(value) for value in values]
    return tuple(zip(turns[::2], turns[1::2], strict=True))
