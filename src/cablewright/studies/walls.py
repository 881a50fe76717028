"""`walls`: walls in a planar lidar's scan, and the lidar's position and yaw in a surveyed room."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.calibration.survey.result import Survey
from cablewright.estimation.lidar.housing_detection import Housing, find_housing
from cablewright.estimation.lidar.localisation import WallPose, WallSettings, start, step
from cablewright.estimation.lidar.noise import Noise, estimate_noise_by_range, refine_noise
from cablewright.estimation.lidar.point_classes import MEANINGS, drop_lines_behind, kinds_off_walls, range_errors
from cablewright.estimation.lidar.room import Laser, RoomMap, RoomWall
from cablewright.estimation.lidar.scan import LidarModel, Points, level_points
from cablewright.estimation.lidar.scan_file import FileScan, read_scan
from cablewright.estimation.lidar.wall_lines import LidarTurn, LineSearch, WallLine, find_walls
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured, Result
from cablewright.foundation.toml_input import read_bytes

_PARALLEL: Final = math.radians(10.0)  # walls that differ by less leave the place along them open
_MAX_PARTS: Final = 4  # named in a note
_MAX_SURVEY: Final = 4 << 20  # bytes
WALL: Final = (
    Figure("angle", "rad", "Direction of the normal, in the lidar's frame.", digits=6),
    Figure("sigma_angle", "rad", "Its standard deviation.", "angle_sigma", "sigma", 2),
    Figure("distance", "m", "Distance from the lidar: normal . p = distance.", digits=5, shown="m"),
    Figure("sigma_distance", "m", "Its standard deviation.", "distance_sigma", "sigma", 2, shown="mm"),
    Figure("rms", "m", "Root mean square of the points' distances from the line.", digits=3, shown="mm"),
    Figure("points", "1", "Number of points.", "point_count"),
    Figure("length", "m", "Length of the wall in sight.", digits=3, shown="m"),
    Figure("normal", "1", "Unit normal of the wall.", detail=True),
    Figure("ends", "m", "Both ends, in the lidar's frame.", detail=True),
)
KIND: Final = (
    Figure("kind", "", "behind, rough, thing, corner or stray."),
    Figure("points", "1", "Number of points."),
    Figure("meaning", "", "The kind in words."),
)
HOUSING: Final = (
    Figure("begin", "rad", "First bearing.", digits=4),
    Figure("end", "rad", "Last bearing, counter-clockwise from there.", digits=4),
    Figure("distance", "m", "Median range.", digits=2, shown="m"),
    Figure("points", "1", "Number of points."),
)
CANDIDATE: Final = (
    Figure("position", "m", "Position of the lidar, in the survey's frame.", digits=5, shown="m"),
    Figure("yaw", "rad", "Yaw of the lidar.", digits=6),
    Figure("variance", "m^2", "Mean square of the points' distances from the walls.", digits=3),
    Figure("explained", "1", "Share of the points that the walls explain.", digits=3, shown="%"),
    Figure("laser_misfit", "1", "Misfit of the distances measured by hand; null without any.", detail=True),
)


@dataclass(frozen=True, eq=False, repr=False)
class LidarPlace(Result):
    """Position and yaw of the lidar in the room."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or why there is no place.", "pose.status"),
        Figure("position", "m", "Position of the lidar, in the survey's frame; null where it is not known.",
               "pose.position",
               digits=5,
               shown="m"),
        Figure("position_sigma", "m", "Its standard deviations.", lambda of: of.sigmas[:2], "sigma", 2, shown="mm"),
        Figure("yaw", "rad", "Yaw of the lidar, in the survey's frame.", "pose.yaw", digits=6),
        Figure("yaw_sigma", "rad", "Its standard deviation.", lambda of: of.sigmas[2], "sigma", 2),
        Figure("covariance", "m, rad", "Covariance of x, y and yaw.", "pose.covariance", detail=True),
        Figure("confidence", "1", "Share of the points explained beyond the next best place.", "pose.confidence",
               digits=3,
               shown="%"),
        Figure("walls", "", "Walls of the room that the place comes from."),
        Figure("candidates", "", "Places that the walls allow, the best first.", "pose.candidates", parts=CANDIDATE,
               detail=True),
        Figure("note", "", "The status in a sentence.", "pose.note", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "position", "yaw")

    pose: WallPose
    room: RoomMap

    @property
    def sigmas(self) -> Array:
        """Standard deviations of x and y, m, and yaw, rad: (3,), NaN where the position is not known."""
        return np.sqrt(np.asarray(self.pose.covariance).diagonal())

    @property
    def walls(self) -> list[str]:
        """Names of the room's walls from which the position is computed."""
        return sorted({self.room.walls[self.pose.constraints[i].wall].name for i in self.pose.used})


def _wall(line: WallLine) -> dict[str, Any]:
    return {
        "angle": line.angle,
        "sigma_angle": math.sqrt(line.covariance[0, 0]),
        "distance": line.distance,
        "sigma_distance": math.sqrt(line.covariance[1, 1]),
        "rms": math.sqrt(line.variance),
        "points": line.point_count,
        "length": line.length,
        "normal": [math.cos(line.angle), math.sin(line.angle)],
        "ends": line.ends,
    }


@dataclass(frozen=True, eq=False, repr=False)
class Walls(Pictured):
    """The walls in a scan, in the lidar's frame, and the lidar's position if a room is given."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, parallel (the place along the walls is open), or no-wall."),
        Figure("points", "1", "Number of points in the scan.", lambda found: len(found.scan.ranges)),
        Figure("used", "1", "Number of points within range and outside the masks.", lambda found: len(found.points)),
        Figure("on_walls", "1", "Number of points on walls.", lambda of: sum(line.point_count for line in of.lines)),
        Figure("noise", "m", "Standard deviation of one range at 0 m.", "lidar.sigma", digits=2, shown="mm"),
        Figure("noise_per_metre", "1", "How much that grows with each metre of range.", "lidar.sigma_per_metre",
               "noise per metre", 2, shown="%"),
        Figure("length_unit", "", "Unit of lengths in the file, or guessed.", "scan.length_unit"),
        Figure("angle_unit", "", "Unit of angles in the file, or guessed; null for x and y.", "scan.angle_unit"),
        Figure("walls", "", "Walls in sight.", lambda of: [_wall(one) for one in of.lines], parts=WALL),
        Figure("kinds", "", "Points on no wall, by kind.", parts=KIND),
        Figure("housing", "", "Parts of the device itself, left out.", parts=HOUSING),
        Figure("device", "", "Device of the scan; null where the file names none.", "scan.device", detail=True),
        Figure("notes", "", "What was guessed, chosen and left out.", detail=True),
        Figure("place", "", "Place of the lidar in the room; null without a room.", parts=LidarPlace.FIGURES),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "points", "used", "on_walls", "noise")

    scan: FileScan
    lidar: LidarModel
    points: Points
    lines: tuple[WallLine, ...]
    housing: tuple[Housing, ...]
    place: LidarPlace | None

    def __len__(self) -> int:
        """Number of walls in the scan."""
        return len(self.lines)

    def __getitem__(self, number: int) -> WallLine:
        """Return wall *number*, counted from 0."""
        return self.lines[number]

    @property
    def status(self) -> str:
        """Status of the search for walls: ``no-wall``, ``parallel`` or ``ok``."""
        if not self.lines:
            return "no-wall"
        angles = [line.angle for line in self.lines]
        parallel = all(abs(math.remainder(angle - angles[0], math.pi)) < _PARALLEL for angle in angles)
        return "parallel" if parallel else "ok"

    @property
    def ok(self) -> bool:
        """Whether there is a wall, and, if a room is given, a position."""
        return bool(self.lines) and (self.place is None or self.place.pose.status == "ok")

    @property
    def notes(self) -> tuple[str, ...]:
        """Guesses that were made, and questions that the walls leave open."""
        along = "all walls in sight are nearly parallel: the place along them is not known"
        return (*self.scan.guessed, *self._own_parts, *([along] if self.status == "parallel" else []))

    @property
    def _own_parts(self) -> list[str]:
        """Which bearings were left out, in a sentence."""
        if not self.housing:
            return []
        parts = [
            f"{math.degrees(one.begin):.1f} to {math.degrees(one.end):.1f} deg ({one.points} points at "
            f"{one.distance:.2f} m)"
            for one in self.housing
        ]
        more = f" and {len(parts) - _MAX_PARTS} more" if len(parts) > _MAX_PARTS else ""
        named = f"bearings {', '.join(parts[:_MAX_PARTS])}{more}"
        how = "--keep-housing uses them, --mask FROM,TO leaves out others"
        return [f"{named} left out as the device's own housing; {how}"]

    @property
    def kinds(self) -> list[dict[str, Any]]:
        """Points on no wall, by class: name, number and meaning."""
        found = kinds_off_walls(self.points, self.lidar.sigmas(self.points.distance), self.lines)
        return [{"kind": kind, "points": count, "meaning": MEANINGS[kind]} for kind, count in found.items()]

    @property
    def refusal(self) -> str:
        """Reason for a no, in a sentence; empty for a yes."""
        if self.status == "no-wall":
            if len(self.points) and not np.ptp(self.points.ray, axis=0).any():
                return f"no wall is in sight: all points within limits, {len(self.points)}, are at one bearing"
            few = f"{len(self.points)} points within limits" if len(self.points) else "no point within limits"
            return f"no wall is in sight: {few}, and no straight run of 10 points over 0.4 m among them"
        return "" if self.ok or self.place is None else f"place: {self.place.pose.note}"


def walls(
    scan: str | Path | FileScan,
    *,
    room: str | Path | Survey | RoomMap | None = None,
    limits: tuple[float, float] = (0.05, 100.0),
    masks: Sequence[tuple[float, float]] = (),
    noise: float | None = None,
    keep_housing: bool = False,
    yaw: tuple[float, float] = (-math.pi / 4, math.pi / 4),
    lasers: Sequence[Laser] = (),
) -> Walls:
    """Find walls in a planar lidar's *scan*, or in the file of one: direction, distance and straightness of each.

    Ranges within *limits* (m) are used, except at bearings within *masks* (pairs, rad), where the machine itself is
    seen; short runs of nearly constant range are left out too, as the device's own housing, unless *keep_housing*.
    *noise*: standard deviation of all ranges, m; by default estimated, with its growth with range. Lines behind glass
    are no walls. In a *room* (a survey, or the file with its JSON) the lidar's place and yaw are found, the yaw between
    the two values of *yaw* (rad); *lasers* are distances to walls that an operator measured. Raises `InputError` for
    contradictory options and files that cannot be used. Source: Merlet, Papegay 2023, III.A.

    Examples
    --------
    >>> import numpy as np, cablewright as cw
    >>> angles = 0.01 * np.arange(-60, 60)
    >>> scan = cw.FileScan(angles, 2.0 / np.cos(angles), "m", "rad", ())
    >>> [round(line.distance, 6) for line in cw.walls(scan, noise=1e-3).lines]
    [2.0]
    """
    if lasers and room is None:
        raise InputError(f"lasers = {lasers[0].wall}: give the room too, which has this wall")
    if noise is not None and not 0 < noise < 1:
        raise InputError(f"noise = {noise:g}: must be over 0 and under 1 m")
    known = room if room is None or isinstance(room, RoomMap) else _room(room)
    scan = scan if isinstance(scan, FileScan) else read_scan(scan)
    lidar = LidarModel(min_range=limits[0], max_range=limits[1], masks=tuple(masks), bias_sigma=0.0)
    points = level_points(lidar, scan.angles, scan.ranges)
    housing = () if keep_housing else find_housing(points)
    if housing:
        lidar = replace(lidar, masks=(*lidar.masks, *((part.begin, part.end) for part in housing)))
        points = level_points(lidar, scan.angles, scan.ranges)
    spread = Noise(noise, 0.0) if noise is not None else estimate_noise_by_range(points)
    lidar, lines = _lines(points, lidar, spread)
    if noise is None:
        far, errors = range_errors(points, lidar.sigmas(points.distance), lines)
        lidar, lines = _lines(points, lidar, refine_noise(far, errors, spread))
    place = None if known is None else LidarPlace(_placed(known, lidar, points, lines, yaw, lasers), known)
    return Walls(scan, lidar, points, tuple(lines), housing, place)


def _lines(points: Points, lidar: LidarModel, noise: Noise) -> tuple[LidarModel, list[WallLine]]:
    """The lidar with that noise, and the lines that are not behind others."""
    lidar = replace(lidar, sigma=noise.at_zero, sigma_per_metre=noise.per_metre)
    found = find_walls(points, lidar, LineSearch.for_noise(lidar.sigma))
    return lidar, drop_lines_behind(points, lidar.sigmas(points.distance), found)


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
        walls_ = [
            RoomWall(
                name,
                (float(wall["normal"][0]), float(wall["normal"][1])),
                float(wall["distance"]),
                float(wall["angle_sigma"]),
                float(wall["distance_sigma"]),
            )
            for name, wall in found["walls"].items()
            if not wall["normal"][2]
        ]
    except (KeyError, IndexError, TypeError, ValueError, AttributeError):
        keys = "walls with normal, distance, angle_sigma and distance_sigma"
        raise InputError(f"{origin}: expected {keys}, as `cablewright survey FILE --json` prints them") from None
    return RoomMap(tuple(walls_))


def _placed(
    known: RoomMap,
    lidar: LidarModel,
    points: Points,
    lines: Sequence[WallLine],
    yaws: tuple[float, float],
    lasers: Sequence[Laser],
) -> WallPose:
    """The lidar's place by the walls that were found."""
    typical = float(np.median(lidar.sigmas(points.distance))) if len(points) else lidar.sigma
    search = LineSearch.for_noise(typical)
    wide = search.merge_distance / LineSearch().merge_distance
    settings = WallSettings(
        known, (lidar,), search, yaws, near_distance=0.02 * wide, gate=0.015 * wide, distinct_distance=0.02 * wide
    )
    return step(settings, start(), LidarTurn.of(0, np.zeros(2), points.xy, lines), lasers)[1]
