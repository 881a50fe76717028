"""Sightings that pictures will show: tags where a camera would see them, and places from which it sees them well."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.calibration.sightings.detection import MIN_SIDE, SeenPicture, Sighting, mean_side
from cablewright.calibration.sightings.placing import tag_corners
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.foundation.arrays import Array
from cablewright.models.rotation import matrices
from cablewright.robot import Robot
from cablewright.robot.direction import facing

EDGE_SIGMAS: Final = (0.065, 0.055)
"""Standard deviations, px, of the sum and the difference of an edge, on rendered pictures with noise."""

_OBLIQUE: Final = 0.35  # cosine of the angle of view, under which a tag is not counted on
_BORDER: Final = 5.0  # px between a tag and the edge of the picture
_NEAREST: Final = 0.2  # m
_AROUND: Final = 8  # directions from which the camera may look
_AWAY: Final = (0.75, 1.1)  # distances from the middle of the frame, over its diagonal in the plan
_HIGH: Final = (0.3, 0.7)  # heights over that of the frame


def expected(seen: Sightings, poses: Array) -> Sightings:
    """Return the sightings, without errors, that pictures at *poses* (N, 6) would give.

    The camera stands at ``place`` and ``rotation`` of *seen*, in the world or on the platform. A tag is seen that is
    in the picture, faces the camera and is not too far away. What hides tags is not known.
    """
    layout, camera, turns = seen.layout, seen.camera, matrices(poses[:, 3:])
    size, pictures = np.array([camera.width, camera.height]), list[SeenPicture]()
    for at, (place, turn) in enumerate(zip(poses[:, :3], turns, strict=True)):
        found = list[Sighting]()
        eye, axes = seen.place, seen.rotation
        if layout.camera == "platform":
            eye, axes = place + turn @ eye, turn @ axes
        for tag in layout.tags:
            points, normal = tag_corners(tag), tag.axes[:, 2]
            if tag.mounted:
                points, normal = place + points @ turn.T, turn @ normal
            points = (points - eye) @ axes
            middle = points.mean(axis=0)
            facing_it = -float(axes.T @ normal @ middle) > _OBLIQUE * float(np.linalg.norm(middle))
            if not facing_it or points[:, 2].min() < _NEAREST:
                continue
            corners = camera.pixels(points[:, :2] / points[:, 2:])
            if (corners > _BORDER).all() and (corners < size - _BORDER).all() and mean_side(corners) > MIN_SIDE:
                found.append(_exact(tag.number, corners))
        pictures.append(SeenPicture(Path(f"pose-{at + 1}"), tuple(found), ()))
    return replace(seen, pictures=tuple(pictures), left_out=frozenset())


def _exact(number: int, corners: Array) -> Sighting:
    """Return the sighting of a tag with *corners* (4, 2), px, without errors."""
    after = np.roll(corners, -1, axis=0)
    along = (after - corners) / np.linalg.norm(after - corners, axis=1, keepdims=True)
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    values = [np.sum(normals * (corners + sign * after), axis=1) for sign in (1.0, -1.0)]
    return Sighting(number, corners, np.column_stack(values).ravel(), np.tile(EDGE_SIGMAS, 4), normals)


def standpoints(seen: Sightings, robot: Robot, middle: Array) -> Iterator[Sightings]:
    """Yield *seen* with the camera at places around the frame of *robot*, from which it looks at *middle* (3,), m."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    across = float(np.linalg.norm((high - low)[:2]))
    for turn, away, share in product(np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False), _AWAY, _HIGH):
        place = 0.5 * (low + high) + away * across * np.array([np.cos(turn), np.sin(turn), 0.0])
        place[2] = low[2] + share * (high - low)[2]
        yield replace(seen, place=place, rotation=looking(place, middle))


def looking(place: Array, at: Array) -> Array:
    """Return the rotation (3, 3) of an upright camera at *place* (3,) that looks *at* a point (3,), m."""
    x, y, z = (at - place).tolist()
    return np.array(facing((x, y, z), (0.0, 0.0, 1.0))).T * [-1.0, -1.0, 1.0]
