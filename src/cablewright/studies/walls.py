"""`walls`: walls in a planar lidar's scan, and the lidar's place and yaw in a surveyed room."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Final

from cablewright.calibration.survey.result import Survey
from cablewright.errors import InputError
from cablewright.estimation.lidar.localisation import LidarTurn, WallPose, WallSettings, start, step
from cablewright.estimation.lidar.room import Laser, RoomMap, RoomWall
from cablewright.estimation.lidar.scan import LidarModel, Points, estimate_noise, level_points
from cablewright.estimation.lidar.scan_file import FileScan, read_scan
from cablewright.estimation.lidar.wall_lines import LineSearch, WallLine, find_lines
from cablewright.results import Figure, Pictured, Result
from cablewright.toml_input import read_bytes

_PARALLEL: Final = math.radians(10.0)  # if all walls differ by less, the place along them is unknown
_MAX_SURVEY: Final = 4 << 20  # bytes
_CANDIDATE: Final = ("position", "yaw", "variance", "explained", "laser_misfit")


@dataclass(frozen=True, eq=False, repr=False)
class LidarPlace(Result):
    """Place and yaw of the lidar in the room."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or why there is no place.", "pose.status"),
        Figure("position", "m", "Of the lidar, in the survey's frame; none where it is not known.", "pose.position"),
        Figure("yaw", "rad", "Of the lidar.", "pose.yaw"),
        Figure("covariance", "m, rad", "Of x, y and yaw.", "pose.covariance"),
        Figure("confidence", "1", "Share of the points explained beyond the next best place.", "pose.confidence"),
        Figure("walls", "", "Those of the room that the place comes from."),
        Figure(
            "candidates",
            "",
            "Places that the walls allow, the best first.",
            lambda place: [{name: getattr(one, name) for name in _CANDIDATE} for one in place.pose.candidates],
        ),
        Figure("note", "", "The status in a sentence.", "pose.note"),
    )
    HEADLINES: ClassVar = ("status", "position", "yaw")

    pose: WallPose
    room: RoomMap

    @property
    def walls(self) -> list[str]:
        """Names of the room's walls from which the place is computed."""
        return sorted({self.room.walls[self.pose.constraints[i].wall].name for i in self.pose.used})


def _wall(line: WallLine) -> dict[str, Any]:
    return {
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


@dataclass(frozen=True, eq=False, repr=False)
class Walls(Pictured):
    """The walls in a scan, in the lidar's frame, and the lidar's place if a room is given."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, parallel (the place along the walls is open), or no-wall."),
        Figure(
            "walls", "m, rad", "The walls, normal . p = distance.", lambda found: [_wall(one) for one in found.lines]
        ),
        Figure("points", "1", "In the scan.", lambda found: len(found.scan.ranges)),
        Figure("used", "1", "Points that count.", lambda found: len(found.points)),
        Figure("on_walls", "1", "Points on walls.", lambda found: sum(line.point_count for line in found.lines)),
        Figure("noise", "m", "Sigma of one range.", "lidar.sigma"),
        Figure("length_unit", "", "Of the file, or guessed.", "scan.length_unit"),
        Figure("angle_unit", "", "Of the file, or guessed; none for x and y.", "scan.angle_unit"),
        Figure("notes", "", "Sentences on what was guessed.", "scan.guessed"),
        Figure("place", "", "The lidar's place in the room; none without a room."),
    )
    HEADLINES: ClassVar = ("status", "points", "used", "on_walls", "noise")

    scan: FileScan
    lidar: LidarModel
    points: Points
    lines: tuple[WallLine, ...]
    place: LidarPlace | None

    def __len__(self) -> int:
        """Number of walls in the scan."""
        return len(self.lines)

    def __getitem__(self, number: int) -> WallLine:
        """Return wall *number*, counted from 0."""
        return self.lines[number]

    @property
    def status(self) -> str:
        """``no-wall``, ``parallel`` or ``ok``."""
        if not self.lines:
            return "no-wall"
        angles = [line.angle for line in self.lines]
        parallel = all(abs(math.remainder(angle - angles[0], math.pi)) < _PARALLEL for angle in angles)
        return "parallel" if parallel else "ok"

    @property
    def ok(self) -> bool:
        """Whether there is a wall, and, if a room is given, a place."""
        return bool(self.lines) and (self.place is None or self.place.pose.status == "ok")

    @property
    def verdict(self) -> str:
        """The status in a sentence; empty if it is ok."""
        if self.status == "no-wall":
            few = f"{len(self.points)} points within limits" if len(self.points) else "no point within limits"
            return f"no wall is in sight: {few}, and no straight run of 10 points over 0.4 m among them"
        if self.status == "parallel":
            return "note: all walls in sight are nearly parallel: the place along them is not known"
        return ""


def walls(
    scan: str | Path | FileScan,
    *,
    room: str | Path | Survey | RoomMap | None = None,
    limits: tuple[float, float] = (0.05, 100.0),
    masks: Sequence[tuple[float, float]] = (),
    noise: float | None = None,
    yaw: tuple[float, float] = (-math.pi / 4, math.pi / 4),
    lasers: Sequence[Laser] = (),
) -> Walls:
    """Walls in a planar lidar's *scan*, or in the file of one: direction, distance and straightness of each.

    Ranges within *limits* (m) are used, except at bearings within *masks* (pairs, rad), where the machine itself is
    seen. *noise*: standard deviation of one range, m; estimated by default. In a *room* (a survey, or the file with its
    JSON) the lidar's place and yaw are found, the yaw between the two values of *yaw* (rad); *lasers* are distances to
    walls that an operator measured. Raises `InputError` for contradictory options and files that cannot be used.
    Source: Merlet, Papegay 2023, III.A.

    Examples
    --------
    >>> import numpy as np, cablewright as cw
    >>> angles = 0.01 * np.arange(-60, 60)
    >>> scan = cw.FileScan(angles, 2.0 / np.cos(angles), "m", "rad", ())
    >>> [round(line.distance, 6) for line in cw.walls(scan, noise=1e-3).lines]
    [2.0]
    """
    if lasers and room is None:
        raise InputError(f"lasers = {lasers[0].wall}: there is no room whose wall it could be")
    if noise is not None and not 0 < noise < 1:
        raise InputError(f"noise = {noise:g}: must be over 0 and under 1 m")
    known = room if room is None or isinstance(room, RoomMap) else _room(room)
    scan = scan if isinstance(scan, FileScan) else read_scan(scan)
    lidar = LidarModel(min_range=limits[0], max_range=limits[1], masks=tuple(masks), bias_sigma=0.0)
    points = level_points(lidar, scan.angles, scan.ranges)
    lidar = replace(lidar, sigma=noise or estimate_noise(points))
    lines = tuple(find_lines(points, lidar, LineSearch.for_noise(lidar.sigma)))
    place = None if known is None else LidarPlace(_placed(known, lidar, scan, yaw, lasers), known)
    return Walls(scan, lidar, points, lines, place)


def _room(survey: str | Path | Survey) -> RoomMap:
    """The room of a survey, or of a file with the output of `survey --json`."""
    if isinstance(survey, Survey):
        return _room_of(survey.to_dict(), "survey")
    file = Path(survey)
    try:
        found = json.loads(read_bytes(file, _MAX_SURVEY, "survey"))
    except (ValueError, RecursionError):
        raise InputError(f"{file}: not JSON; expected the output of `cablewright survey FILE --json`") from None
    return _room_of(found, str(file))


def _room_of(found: Any, origin: str) -> RoomMap:
    """The vertical walls among the figures of a survey."""
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
        expected = "walls with normal and distance, and their sigma, as `cablewright survey FILE --json` prints them"
        raise InputError(f"{origin}: expected {expected}") from None
    return RoomMap(tuple(walls_))


def _placed(
    known: RoomMap, lidar: LidarModel, scan: FileScan, yaws: tuple[float, float], lasers: Sequence[Laser]
) -> WallPose:
    search = LineSearch.for_noise(lidar.sigma)
    wide = search.merge_distance / LineSearch().merge_distance
    settings = WallSettings(
        known, (lidar,), search, yaws, near_distance=0.02 * wide, gate=0.015 * wide, distinct_distance=0.02 * wide
    )
    return step(settings, start(), LidarTurn(scan.angles, scan.ranges), lasers)[1]
