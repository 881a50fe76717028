"""Surveyed walls that lidars localise by: lines seen from above, in the reference frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

MAX_WALLS: Final = 24


@dataclass(frozen=True)
class RoomWall:
    """A vertical wall ``normal . p = distance``; its unit normal points out of the room. Sigmas are the survey's.

    That of the distance holds ``reference`` m along the wall, from the foot of the origin's perpendicular and along the
    normal turned by a quarter to the left; the error of the direction is independent of it there.
    """

    name: str
    normal: tuple[float, float]
    distance: float  # m
    angle_sigma: float = 0.0  # rad
    distance_sigma: float = 0.0  # m
    reference: float = 0.0  # m

    @property
    def along(self) -> tuple[float, float]:
        """Unit vector along the wall: the normal rotated by a quarter to the left."""
        return -self.normal[1], self.normal[0]

    @property
    def azimuth(self) -> float:
        """Azimuth of the normal, rad."""
        return math.atan2(self.normal[1], self.normal[0])

    @property
    def kind(self) -> str:
        """``C`` if it bounds y more than x, else ``D``: the types of constraint of Merlet and Papegay 2023, III.A."""
        return "C" if abs(self.normal[1]) > abs(self.normal[0]) else "D"


@dataclass(frozen=True)
class Laser:
    """An operator's reading of a laser distance meter: from the platform point, horizontally, to a wall; m."""

    wall: str
    distance: float
    sigma: float = 3e-3


@dataclass(frozen=True)
class RoomMap:
    """The upright walls of a room. Raises `InputError` for too many, equal names, or normals not of length 1."""

    walls: tuple[RoomWall, ...]

    def __post_init__(self) -> None:
        if not len(self.walls) <= MAX_WALLS:
            raise InputError(f"room: {len(self.walls)} walls; at most {MAX_WALLS} are expected")
        names = [wall.name for wall in self.walls]
        for wall in self.walls:
            if names.count(wall.name) > 1:
                raise InputError(f"room: two walls are named {wall.name!r}")
            size = math.hypot(*wall.normal)
            if not (abs(size - 1.0) < 1e-6 and math.isfinite(wall.distance)):
                raise InputError(
                    f"room: wall {wall.name!r}: a unit normal and a finite distance are expected, not a normal "
                    f"of length {size:g} and {wall.distance:g} m"
                )

    @classmethod
    def of(cls, walls: Mapping[str, tuple[Sequence[float], float]]) -> RoomMap:
        """Build a room from normals and distances by name; normals may have a third number, 0 of an upright wall."""
        upright = {name: wall for name, wall in walls.items() if len(wall[0]) < 3 or not wall[0][2]}
        return cls(tuple(RoomWall(name, (n[0], n[1]), float(d)) for name, (n, d) in upright.items()))

    @cached_property
    def normals(self) -> Array:
        """Unit normals (w, 2), out of the room."""
        return np.array([wall.normal for wall in self.walls])

    @cached_property
    def distances(self) -> Array:
        """Distances (w,), m, along the normals."""
        return np.array([wall.distance for wall in self.walls])

    @cached_property
    def azimuths(self) -> Array:
        """Azimuths (w,) of the normals, rad."""
        return np.array([wall.azimuth for wall in self.walls])

    @cached_property
    def numbers(self) -> Array:
        """The walls (w, 5), as the kernels `wall_matches` need them."""
        each = [(wall.azimuth, *wall.normal, wall.distance, wall.reference) for wall in self.walls]
        return np.array(each, dtype=np.float64).reshape(-1, 5)

    @cached_property
    def angle_sigmas(self) -> Array:
        """Standard deviations (w,) of the azimuths, rad."""
        return np.array([wall.angle_sigma for wall in self.walls])

    @cached_property
    def distance_sigmas(self) -> Array:
        """Standard deviations (w,) of the distances, m."""
        return np.array([wall.distance_sigma for wall in self.walls])

    def index(self, name: str) -> int:
        """Return the index of the wall with a given name. Raises `InputError`."""
        for i, wall in enumerate(self.walls):
            if wall.name == name:
                return i
        raise InputError(f"room: no wall {name!r}; it has {', '.join(wall.name for wall in self.walls)}")
