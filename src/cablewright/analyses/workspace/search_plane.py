"""A plane in which a workspace is searched, by its projection along one of the world's axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.analyses.workspace.refinement import SearchBox
from cablewright.foundation.arrays import Array
from cablewright.robot import Plane, Robot
from cablewright.robot.plane import OFF_PLANE


@dataclass(frozen=True, eq=False)
class SearchPlane:
    """The plane to which a planar workspace is confined: normal . x = distance, m."""

    normal: Array  # (3,) unit vector
    distance: float

    @classmethod
    def of(cls, robot: Robot, plane: Plane, point: str) -> SearchPlane:
        """Return the plane of a *point* of the platform, ``nozzle`` or ``origin``, whose origin moves in *plane*."""
        normal = np.array(plane.across)
        aside = float(normal @ robot.platform.nozzle) if point == "nozzle" else 0.0
        return cls(normal, plane.distance + aside)

    def __str__(self) -> str:
        """The plane in words."""
        if self.is_tilted:
            return f"with normal {self.name} at {self.distance:g} m"
        return f"{self.name} = {self.distance * self.normal[self.axis]:g} m"

    @property
    def axis(self) -> int:
        """The world's axis nearest to the normal, along which the plane is projected."""
        return int(np.abs(self.normal).argmax())

    @property
    def is_tilted(self) -> bool:
        """Whether the plane is perpendicular to none of the world's axes."""
        return bool(np.count_nonzero(self.normal) > 1)

    @property
    def name(self) -> str:
        """Name of the axis across the plane, or of a tilted plane its normal."""
        return ", ".join(f"{x:.4g}" for x in self.normal) if self.is_tilted else "xyz"[self.axis]

    def onto(self, places: Array) -> Array:
        """Return *places* (N, 3), m, moved along the axis into the plane."""
        moved = places.copy()
        moved[:, self.axis] = 0.0
        moved[:, self.axis] = (self.distance - moved @ self.normal) / self.normal[self.axis]
        return moved

    def crosses(self, box: SearchBox) -> bool:
        """Whether *box* has an area in this plane: a flat box lies in it, or a tilted plane cuts the box."""
        if self.is_tilted:
            return not box.is_flat and self.area_in(box) > 0.0
        at = self.distance * self.normal[self.axis]
        return box.is_flat and box.flat_axis == self.axis and abs(float(box.low[self.axis]) - at) <= OFF_PLANE

    def area_in(self, box: SearchBox) -> float:
        """Return the area, m^2, of the part in *box*."""
        corners = np.array([box.low, box.high, box.high, box.low])
        one, two = (self.axis + 1) % 3, (self.axis + 2) % 3
        corners[:, two] = box.low[two], box.low[two], box.high[two], box.high[two]
        if self.is_tilted:
            for side, end in ((1.0, box.low), (-1.0, box.high)):
                corners = _part(corners, side * (self.onto(corners)[:, self.axis] - end[self.axis]))
        x, y = corners[:, one], corners[:, two]
        return float(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / abs(self.normal[self.axis]))


def _part(corners: Array, values: Array) -> Array:
    """Return the part of a convex polygon where a linear function, with *values* at its corners, is not negative."""
    found = []
    for one, two, a, b in zip(corners, np.roll(corners, -1, axis=0), values, np.roll(values, -1), strict=True):
        if a >= 0.0:
            found.append(one)
        if a * b < 0.0:
            found.append(one + a / (a - b) * (two - one))
    return np.array(found).reshape(-1, 3)
