"""Detection of tags in a picture: numbers by OpenCV, and edges to a fraction of a pixel with standard deviations.

An edge is where the light between the black border and the white margin is half, in profiles across it: blur, which is
the same on both sides, does not move it. Corners are left out, since blur rounds them. A straight edge is a curve in
the picture of a real lens, so positions along it are compared with that curve.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from scipy.ndimage import map_coordinates

from cablewright.calibration.sightings.camera import Camera
from cablewright.calibration.sightings.layout import MODULES
from cablewright.calibration.sightings.pictures import read_picture, require_camera_extra
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

MIN_SIDE: Final = 25.0
"""Smallest mean side of a tag in a picture, px: a smaller one is too far away."""

EDGES: Final = 8
"""Numbers that are measured of a tag: the sum and the difference of the distances at the ends of its four edges."""

_MARGIN: Final = 0.12  # of an edge at both ends, which is left out
_STEP: Final = 2.0  # px between profiles: nearer ones share pixels
_ROUNDS: Final = 4  # of moving the profiles to the edge
_BORDER: Final = 3.0  # px between a corner and the edge of the picture
_HALF: Final = 0.6  # modules on both sides of an edge that profiles cover, at most ...
_WIDEST: Final = 8.0  # ... px
_FLOOR: Final = 0.03  # px: standard deviation of an edge that no light and no lens explains
_GAMMA: Final = 2.2  # of a picture's grey levels
_MIN_CONTRAST: Final = 0.02  # of the white level of light
_SHARP: Final = 0.7  # modules over which blur may spread an edge
_STRAIGHT: Final = 0.5  # px: max scatter of an edge


@dataclass(frozen=True, eq=False)
class Sighting:
    """A tag in a picture: its corners, and the sum and difference of the distances at the ends of each edge."""

    number: int
    corners: Array  # (4, 2) px, from the top left clockwise
    values: Array  # (8,) px
    sigmas: Array  # (8,) px
    normals: Array  # (4, 2): across each edge, outwards

    @property
    def side(self) -> float:
        """The mean side of the tag, px."""
        return mean_side(self.corners)


@dataclass(frozen=True, eq=False)
class SeenPicture:
    """Tags found in one picture, and the reasons why others are left out."""

    path: Path
    sightings: tuple[Sighting, ...]
    left_out: tuple[str, ...]
    found: tuple[tuple[int, Array], ...] = ()  # numbers and corners (4, 2), px, of all tags, as detected


def mean_side(corners: Array) -> float:
    """Return the mean side of a quadrangle with corners (4, 2)."""
    return float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).mean())


def seen_in(
    path: Path, camera: Camera, wanted: frozenset[int], known: tuple[tuple[int, Array], ...] = ()
) -> SeenPicture:
    """Return the tags with the *wanted* numbers in a picture by *camera*, without faulty ones.

    *known*: `SeenPicture.found`, where tags were detected before, with another lens; edges are measured again.
    Raises `InputError` for a picture of another size, and for a tag that is in it twice.
    """
    picture = read_picture(path)
    height, width = picture.shape
    if (width, height) != (camera.width, camera.height):
        raise InputError(
            f"{path}: {width} x {height} pixels, but the camera's pictures have {camera.width} x {camera.height}: "
            "give pictures as the camera stored them, none turned, cropped or scaled"
        )
    found = known or tuple(detected(picture))
    counts = Counter(number for number, _ in found if number in wanted)
    for number, count in counts.items():
        if count > 1:
            raise InputError(f"{path}: tag {number} is in it {count} times; cover or remove the others")
    light, sightings, left_out = in_light(picture), list[Sighting](), list[str]()
    for number, corners in sorted((each for each in found if each[0] in wanted), key=lambda each: each[0]):
        seen = measured(light, camera, number, corners)
        if isinstance(seen, Sighting):
            sightings.append(seen)
        else:
            left_out.append(f"tag {number}: {seen}")
    if not counts:
        others = ", ".join(str(number) for number, _ in found[:8])
        left_out.append(f"shows tags {others}, none of which is in the layout" if found else "shows no tag")
    return SeenPicture(path, tuple(sightings), tuple(left_out), found)


def in_light(picture: Array) -> Array:
    """Convert grey levels, 0 to 255, to linear light (height, width), 0 to 1."""
    return np.asarray((np.asarray(picture, dtype=np.float64) / 255.0) ** _GAMMA)


def detected(picture: Array) -> Iterator[tuple[int, Array]]:
    """Yield the number and the corners (4, 2), px, of each tag of the family 36h11 in grey levels (height, width)."""
    require_camera_extra()
    import cv2

    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    settings = cv2.aruco.DetectorParameters()
    settings.minMarkerPerimeterRate = 3.0 * MIN_SIDE / max(picture.shape)  # smaller ones are named as too far
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    grey = np.clip(np.round(picture), 0.0, 255.0).astype(np.uint8)
    corners, numbers, _ = cv2.aruco.ArucoDetector(family, settings).detectMarkers(grey)
    for at, quadrangle in enumerate(corners):
        yield int(np.ravel(numbers)[at]), np.array(quadrangle, dtype=np.float64).reshape(4, 2)


def measured(light: Array, camera: Camera, number: int, corners: Array) -> Sighting | str:
    """Return a tag with its edges measured in *light* (height, width), or the reason why it cannot be used."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    if sides.mean() < MIN_SIDE:
        return f"too far: its side is {sides.mean():.3g} px; at least {MIN_SIDE:g} px are required"
    width = _area(corners) / sides.max()  # between the farther ones of its edges
    if width < 0.5 * MIN_SIDE:
        return f"seen too obliquely: it is {width:.3g} px wide; at least {0.5 * MIN_SIDE:g} px are required"
    if corners.min() < _BORDER or (corners > np.array(light.shape[::-1]) - 1.0 - _BORDER).any():
        return "at the edge of the picture"
    module, ends = width / MODULES, np.zeros((4, 2, 2))
    for _ in range(_ROUNDS):
        edges = [_edge(light, camera, corners[at], corners[(at + 1) % 4], module) for at in range(4)]
        if any(edge is None for edge in edges):
            return "its edges are blurred, covered or without contrast"
        for at, edge in enumerate(edges):
            assert edge is not None
            both = corners[[at, (at + 1) % 4]]
            ends[at] = both + np.outer([edge.offset - edge.rise, edge.offset + edge.rise], edge.normal)
        moved = np.array([_crossing(ends[at - 1], ends[at]) for at in range(4)])
        if not np.abs(moved - corners).max() < module:
            return "its edges are not those of a square"
        corners = moved
    found = [edge for edge in edges if edge is not None]
    scatter = float(np.sqrt(np.mean([edge.scatter**2 for edge in found])))
    if scatter > _STRAIGHT:
        return f"its edges are not straight: they scatter by {scatter:.2g} px"
    normals = np.array([edge.normal for edge in found])
    values = np.array(
        [(each @ (one + two), each @ (one - two)) for each, (one, two) in zip(normals, ends, strict=True)]
    )
    shares = np.array([(2.0 / np.sqrt(edge.count), edge.share) for edge in found])
    sigmas = np.hypot(shares * scatter, _FLOOR * np.array([2.0, 1.0]))
    return Sighting(number, corners, values.ravel(), sigmas.ravel(), normals)


@dataclass(frozen=True, eq=False)
class _Edge:
    """An edge against the straight line between two corners: how far it is outwards at the middle, and more at the end.

    ``scatter``: of the profiles about it, px, of which there are ``count``; ``share``: standard deviation of the
    difference at the ends over that.
    """

    normal: Array  # (2,)
    offset: float  # px
    rise: float  # px
    scatter: float
    count: int
    share: float


def _edge(light: Array, camera: Camera, one: Array, two: Array, module: float) -> _Edge | None:
    """Return the edge near the line from corner *one* to *two* (2,), px; None where there is none that is sharp."""
    length = float(np.linalg.norm(two - one))
    along = (two - one) / length
    normal, reach = np.array([along[1], -along[0]]), (0.5 - _MARGIN) * length  # corners go round with y down
    at = np.arange(-reach, reach + 1e-9, _STEP)
    at -= at.mean()
    half = min(_HALF * module, _WIDEST)
    across = np.linspace(-half, half, 2 * int(np.ceil(2.0 * half)) + 1)
    line, place = _bow(camera, one, two, normal, at), 0.5 * (one + two) + np.outer(at, along)
    points = place[:, None] + (line[:, None, None] + across[:, None]) * normal  # (s, q, 2)
    seen = map_coordinates(light, [points[..., 1], points[..., 0]], order=1, mode="nearest")
    outer = np.abs(across) > 0.5 * half
    black, white = (
        np.polyval(np.polyfit(at, seen[:, outer & side].mean(axis=1), 1), at) for side in (across < 0.0, across > 0.0)
    )
    contrast = white - black
    if (contrast < _MIN_CONTRAST * white.max()).any() or (contrast < 0.3 * white).any():
        return None
    shown = (seen - black[:, None]) / contrast[:, None]
    slope = float(np.gradient(shown.mean(axis=0), across).max())
    if slope * _SHARP * module < 1.0:
        return None
    off = half - np.trapezoid(shown, across, axis=1)
    rate, offset = np.polyfit(at, off, 1)
    spread = float(np.sqrt(np.sum((off - offset - rate * at) ** 2) / (len(at) - 2)))
    return _Edge(normal, float(offset), 0.5 * length * float(rate), spread, len(at), length / float(np.sqrt(at @ at)))


def _bow(camera: Camera, one: Array, two: Array, normal: Array, at: Array) -> Array:
    """Return how far (s,) a straight edge is outwards of the line between its ends, *at* (s,) along it, px."""
    ends = camera.directions(np.array([one, two]))
    points = camera.pixels(ends[0] + np.linspace(0.0, 1.0, 17)[:, None] * (ends[1] - ends[0])) - 0.5 * (one + two)
    return np.interp(at, points @ ((two - one) / np.linalg.norm(two - one)), points @ normal)


def _area(corners: Array) -> float:
    """Return the area of a quadrangle (4, 2)."""
    one, two = corners[2] - corners[0], corners[3] - corners[1]
    return 0.5 * abs(float(one[0] * two[1] - one[1] * two[0]))


def _crossing(first: Array, second: Array) -> Array:
    """Return the point (2,) where two lines cross, each through two points (2, 2); NaN for parallel ones."""
    ways = np.column_stack([first[1] - first[0], second[0] - second[1]])
    if abs(np.linalg.det(ways)) < 1e-9:
        return np.full(2, np.nan)
    return np.asarray(first[0] + ways[:, 0] * np.linalg.solve(ways, second[0] - first[0])[0])
