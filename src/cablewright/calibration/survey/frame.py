"""The frame of a survey: z up, y along a wall, x into the room; and everything in it with its motion per marker."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.survey.markers import Markers
from cablewright.calibration.survey.plan import Feature, SurveyPlan
from cablewright.calibration.survey.shape_fits import Linear
from cablewright.errors import InputError

_FACING: Final = {"north": (0.0, 1.0), "east": (1.0, 0.0), "south": (0.0, -1.0), "west": (-1.0, 0.0)}
"""Where the normals of the four walls point, by their names."""


@dataclass(frozen=True, eq=False)
class SurveyFrame:
    """How the answer's frame lies in the instrument's grid: p = rotation (grid - offset)."""

    along: str  # the wall that y follows, or "instrument"
    origin: str  # "station" or "exits"
    floor: str  # what z = 0 is: "floor", "height" or "instrument"
    azimuth: Linear  # (1,) rad, of the x axis in the grid
    offset: Linear  # (3,) m, of the origin in the grid
    outward: Mapping[Feature, float]  # 1 or -1: what each wall's normal is to be multiplied by to leave the room

    @property
    def rotation(self) -> Array:
        """(3, 3), from the grid."""
        c, s = math.cos(self.azimuth.value[0]), math.sin(self.azimuth.value[0])
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def put(self, place: Linear) -> Linear:
        """Bring a place (3,) of the grid here."""
        here = self.rotation @ (place.value - self.offset.value)
        turn = np.array([here[1], -here[0], 0.0])  # per radian of the frame
        motion = self.rotation @ (place.motion - self.offset.motion) + np.outer(turn, self.azimuth.motion)
        return Linear(here, motion)

    def height(self, level: Linear) -> Linear:
        """Bring a height (1,) here."""
        return Linear(level.value - self.offset.value[2:], level.motion - self.offset.motion[2:])

    def wall(self, feature: Feature, found: Linear) -> tuple[Array, Linear, Linear]:
        """Bring a wall (azimuth, distance) here: its normal, its distance and the normal's azimuth."""
        sign = self.outward[feature]
        azimuth = found.value[:1] + (0.0 if sign > 0 else math.pi) - self.azimuth.value
        normal = np.array([math.cos(azimuth[0]), math.sin(azimuth[0]), 0.0])
        n = np.array([math.cos(found.value[0]), math.sin(found.value[0]), 0.0])
        t = np.array([-n[1], n[0], 0.0])
        distance = found.value[1:] - n @ self.offset.value
        motion = found.motion[1:] - n @ self.offset.motion - (t @ self.offset.value) * found.motion[:1]
        turn = found.motion[:1] - self.azimuth.motion
        return normal, Linear(sign * distance, sign * motion), Linear(azimuth, turn)


def frame_of(
    plan: SurveyPlan,
    walls: Mapping[Feature, Linear],
    levels: Mapping[Feature, Linear],
    places: Mapping[Feature, Linear],
    inside: Array,
    markers: Markers,
    origin: str,
) -> SurveyFrame:
    """Lay the frame. ``inside``: a place in the room, in the grid; ``origin`` names the file in messages.

    Raises `InputError` if the wall that y follows is not marked, or if walls are not where their names say.
    """
    outward = {f: 1.0 if w.value[1] >= _normal(w) @ inside else -1.0 for f, w in walls.items()}
    along = plan.frame.along
    if along == "instrument":
        azimuth = Linear(np.zeros(1), np.zeros((1, 3 * len(markers.all))))
    else:
        follows = Feature("wall", along)
        if follows not in walls:
            others = ", ".join(f.name for f in walls) or "none"
            raise InputError(
                f"{origin}: no marker on wall {along!r}, which the frame's y axis follows; put two there, or name in "
                f"the plan's frame.along another wall (marked: {others}), or 'instrument' for its own directions"
            )
        found = walls[follows][:1]
        turned = found.value + (math.pi if outward[follows] > 0 else 0.0)  # x goes into the room
        azimuth = Linear(turned, found.motion)
    offset, floor = _offset(plan, levels, places, markers, origin)
    frame = SurveyFrame(along, plan.frame.origin, floor, azimuth, offset, outward)
    if along == "west":
        _check_names(frame, walls, origin)
    return frame


def _offset(
    plan: SurveyPlan, levels: Mapping[Feature, Linear], places: Mapping[Feature, Linear], markers: Markers, origin: str
) -> tuple[Linear, str]:
    """Return the origin in the grid, and what z = 0 is."""
    columns = 3 * len(markers.all)
    station = np.zeros(3) if markers.station is None else markers.station
    value, motion = np.array([station[0], station[1], 0.0]), np.zeros((3, columns))
    if plan.frame.origin == "exits":
        exits = [place for feature, place in places.items() if feature.kind == "exit"]
        if not exits:
            raise InputError(f"{origin}: frame.origin = 'exits', but no exit point is marked")
        value[:2] = np.mean([place.value[:2] for place in exits], axis=0)
        motion[:2] = np.mean([place.motion[:2] for place in exits], axis=0)
    floor = levels.get(Feature("floor", ""))
    if floor is not None:
        value[2], motion[2] = floor.value[0], floor.motion[0]
        return Linear(value, motion), "floor"
    if plan.instrument.height is not None:
        value[2] = station[2] - plan.instrument.height
        return Linear(value, motion), "height"
    return Linear(value, motion), "instrument"


def _check_names(frame: SurveyFrame, walls: Mapping[Feature, Linear], origin: str) -> None:
    """Refuse walls that do not face where their names say, by more than half a right angle."""
    for feature, found in walls.items():
        facing = _FACING.get(feature.name)
        normal = frame.wall(feature, found)[0]
        if facing is not None and normal[:2] @ np.array(facing) < math.sqrt(0.5):
            near = max(_FACING, key=lambda name: float(normal[:2] @ np.array(_FACING[name])))
            raise InputError(
                f"{origin}: wall {feature.name} is where {near} should be, seen from the west wall with z up; are the "
                "names mixed up?"
            )


def _normal(wall: Linear) -> Array:
    return np.array([math.cos(wall.value[0]), math.sin(wall.value[0]), 0.0])
