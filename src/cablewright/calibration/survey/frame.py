"""Coordinate frame of a survey (z up, y along a wall, x into the room), and features expressed in it with Jacobians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.calibration.survey.markers import Markers
from cablewright.calibration.survey.plan import MarkedFeature, SurveyPlan
from cablewright.calibration.survey.shape_fits import Linear, directions
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

_FACING: Final = {"north": (0.0, 1.0), "east": (1.0, 0.0), "south": (0.0, -1.0), "west": (-1.0, 0.0)}
"""Outward normals (x, y) of the four walls by name."""


@dataclass(frozen=True, eq=False)
class SurveyFrame:
    """The pose of the survey frame in the instrument's grid: p = rotation (grid - offset)."""

    along: str  # the wall that y follows, or "instrument"
    origin: str  # "station" or "exits"
    floor: str  # what z = 0 is: "floor", "height" or "instrument"
    azimuth: Linear  # (1,) rad, of the x axis in the grid
    offset: Linear  # (3,) m, of the origin in the grid
    outward: Mapping[MarkedFeature, float]  # 1 or -1: sign that makes each wall's fitted normal point out of the room

    @property
    def rotation(self) -> Array:
        """Rotation (3, 3) from the grid to the frame."""
        c, s = math.cos(self.azimuth.value[0]), math.sin(self.azimuth.value[0])
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def put(self, place: Linear) -> Linear:
        """Express a point (3,) of the grid in this frame, m."""
        here = self.rotation @ (place.value - self.offset.value)
        turn = np.array([here[1], -here[0], 0.0])  # per radian of the frame
        jacobian = self.rotation @ (place.jacobian - self.offset.jacobian) + np.outer(turn, self.azimuth.jacobian)
        return Linear(here, jacobian)

    def height(self, level: Linear) -> Linear:
        """Express a height (1,) of the grid in this frame, m."""
        return Linear(level.value - self.offset.value[2:], level.jacobian - self.offset.jacobian[2:])

    def wall(self, feature: MarkedFeature, found: Linear) -> tuple[Array, Linear, Linear]:
        """Express a wall (azimuth, distance) of the grid in this frame: outward normal, distance, normal's azimuth."""
        sign = self.outward[feature]
        azimuth = found.value[:1] + (0.0 if sign > 0 else math.pi) - self.azimuth.value
        n, t = directions(found.value[0])
        distance = found.value[1:] - n @ self.offset.value
        jacobian = found.jacobian[1:] - n @ self.offset.jacobian - (t @ self.offset.value) * found.jacobian[:1]
        turn = found.jacobian[:1] - self.azimuth.jacobian
        return directions(azimuth[0])[0], Linear(sign * distance, sign * jacobian), Linear(azimuth, turn)


def frame_of(
    plan: SurveyPlan,
    walls: Mapping[MarkedFeature, Linear],
    levels: Mapping[MarkedFeature, Linear],
    places: Mapping[MarkedFeature, Linear],
    markers: Markers,
    file: str,
) -> SurveyFrame:
    """Return the survey frame that *plan* requests, from walls, levels and exit points in the instrument's grid.

    Raises `InputError`, which names *file*, if the wall that y follows has no markers, or if walls are not where their
    names say.
    """
    # The instrument is in the room; without its position, so is the median of all markers.
    middle = np.median([marker.position for marker in markers.all], axis=0)
    inside = middle if markers.station is None else markers.station
    outward = {f: 1.0 if w.value[1] >= directions(w.value[0])[0] @ inside else -1.0 for f, w in walls.items()}
    along = plan.frame.along
    if along == "instrument":
        azimuth = Linear(np.zeros(1), np.zeros((1, 3 * len(markers.all))))
    else:
        follows = MarkedFeature("wall", along)
        if follows not in walls:
            others = ", ".join(f.name for f in walls) or "none"
            raise InputError(
                f"{file}: no marker on wall {along!r}, which the frame's y axis follows; put two there, or set the "
                f"plan's frame.along to another wall (marked: {others}), or to 'instrument' for its own directions"
            )
        found = walls[follows][:1]
        turned = found.value + (math.pi if outward[follows] > 0 else 0.0)  # x points into the room
        azimuth = Linear(turned, found.jacobian)
    offset, floor = _offset(plan, levels, places, markers, file)
    frame = SurveyFrame(along, plan.frame.origin, floor, azimuth, offset, outward)
    if along == "west":
        _check_names(frame, walls, file)
    return frame


def _offset(
    plan: SurveyPlan,
    levels: Mapping[MarkedFeature, Linear],
    places: Mapping[MarkedFeature, Linear],
    markers: Markers,
    file: str,
) -> tuple[Linear, str]:
    """Return the origin in the grid, and what z = 0 is."""
    station = np.zeros(3) if markers.station is None else markers.station
    value, jacobian = np.array([station[0], station[1], 0.0]), np.zeros((3, 3 * len(markers.all)))
    if plan.frame.origin == "exits":
        exits = [place for feature, place in places.items() if feature.kind == "exit"]
        if not exits:
            raise InputError(f"{file}: frame.origin = 'exits', but no exit point is marked")
        value[:2] = np.mean([place.value[:2] for place in exits], axis=0)
        jacobian[:2] = np.mean([place.jacobian[:2] for place in exits], axis=0)
    level, floor = levels.get(MarkedFeature("floor", "")), "instrument"
    if level is not None:
        value[2], jacobian[2], floor = level.value[0], level.jacobian[0], "floor"
    elif plan.instrument.height is not None:
        value[2], floor = station[2] - plan.instrument.height, "height"
    return Linear(value, jacobian), floor


def _check_names(frame: SurveyFrame, walls: Mapping[MarkedFeature, Linear], file: str) -> None:
    """Raise `InputError` for a wall whose normal is more than 45 degrees off the direction that its name says."""
    for feature, found in walls.items():
        facing = _FACING.get(feature.name)
        normal = frame.wall(feature, found)[0]
        if facing is not None and normal[:2] @ np.array(facing) < math.sqrt(0.5):
            near = max(_FACING, key=lambda name: float(normal[:2] @ np.array(_FACING[name])))
            raise InputError(
                f"{file}: wall {feature.name} is where {near} should be, seen from the west wall with z up; are the "
                "names mixed up?"
            )
