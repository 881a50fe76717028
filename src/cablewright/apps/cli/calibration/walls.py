"""`walls`: the walls in a scan of a planar lidar, and where in a surveyed room the lidar is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import interval, lasers, numbers
from cablewright.errors import InputError


@dataclass(frozen=True, kw_only=True)
class ScanOptions:
    """How the scan's file is read."""

    PANEL: ClassVar = "Scan"

    unit: Annotated[
        str | None, typer.Option("--unit", help="Unit of lengths that name none: m, mm, ..; by default guessed.")
    ] = None
    angle_unit: Annotated[
        str | None,
        typer.Option("--angle-unit", help="Unit of angles that name none: rad, deg, ..; by default guessed."),
    ] = None
    clockwise: Annotated[bool, typer.Option("--clockwise", help="Angles grow clockwise, seen from above.")] = False
    columns: Annotated[
        str | None,
        typer.Option("--columns", metavar="NAMES", help="Columns of a file without a header: angle,distance,.."),
    ] = None
    within: Annotated[str, typer.Option("--range", metavar="MIN,MAX", help="Ranges that are used, m.")] = "0.05,100"
    mask: Annotated[
        str | None,
        typer.Option(
            "--mask", metavar="FROM,TO[,..]", help="Bearings, deg, at which the lidar sees the machine itself."
        ),
    ] = None
    keep_housing: Annotated[
        bool, typer.Option("--keep-housing", help="Use also what looks like the lidar's own housing.")
    ] = False
    noise: Annotated[
        float | None,
        typer.Option("--noise", help="Standard deviation of all ranges, m; by default estimated by range."),
    ] = None
    device: Annotated[
        str | None,
        typer.Option("--device", help="Device whose scan is read from a file of several: its column, topic or frame."),
    ] = None


@dataclass(frozen=True, kw_only=True)
class RoomOptions:
    """The room in which the lidar is searched."""

    PANEL: ClassVar = "Room"

    room: Annotated[
        Path | None,
        typer.Option(
            "--room", metavar="SURVEY.json", help="Room in which to find the lidar: what `survey --json` printed."
        ),
    ] = None
    yaw: Annotated[
        str, typer.Option("--yaw", metavar="MIN,MAX", help="Yaw that the lidar may have in the room, deg.")
    ] = "-45,45"
    laser: Annotated[
        str | None,
        typer.Option("--laser", metavar="WALL=D[,..]", help="Distances from the lidar to walls, measured by hand, m."),
    ] = None


@dataclass(frozen=True, kw_only=True)
class WallsCommand:
    """Each wall has a direction, a distance and how straight it is; with --room the lidar's place and yaw are found.

    The answer is no (exit 1) if no wall is in sight, or the place is not known.
    """

    EXAMPLE: ClassVar = "walls examples/scan.csv"
    ANSWERS: ClassVar = ("studies.walls:Walls",)

    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="CSV or JSON with x,y or angle,distance; or a laser scan of ROS or Foxglove."
        ),
    ]
    scan: ScanOptions
    place: RoomOptions
    output: OutputOptions

    def run(self) -> int:
        """Find the walls, draw and print them."""
        from cablewright.estimation.lidar.scan_file import read_scan
        from cablewright.studies.walls import walls

        scan, place = self.scan, self.place
        if place.laser is not None and place.room is None:
            raise InputError(f"--laser = {place.laser!r}: there is no --room whose wall it could be")
        names = None if scan.columns is None else [name.strip() for name in scan.columns.split(",")]
        low, high = interval(place.yaw, "--yaw")
        found = walls(
            read_scan(self.file, scan.unit, scan.angle_unit, scan.clockwise, names, scan.device),
            room=place.room,
            limits=interval(scan.within, "--range"),
            masks=_masks(scan.mask),
            noise=scan.noise,
            keep_housing=scan.keep_housing,
            yaw=(math.radians(low), math.radians(high)),
            lasers=lasers(place.laser),
        )
        return answer(found, self.output.as_json, **self.output.write(found, "Walls in a scan"))


def _masks(text: str | None) -> tuple[tuple[float, float], ...]:
    values = numbers(text, "--mask") or []
    if len(values) % 2 or not all(map(math.isfinite, values)):
        raise InputError(f"--mask = {text!r}: expected pairs of bearings, FROM,TO, in deg")
    turns = [math.radians(value) for value in values]
    return tuple(zip(turns[::2], turns[1::2], strict=True))
