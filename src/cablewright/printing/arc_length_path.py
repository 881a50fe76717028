"""The path by its arc length: points, tangents and layers at a distance along it.

`cablewright.models.path_offset` has the offset of points from it.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.printing.path import Samples


class PathPoint(NamedTuple):
    """A point of the path and the unit tangent there."""

    position: Array  # (3,) m
    tangent: Array  # (3,)


@dataclass(frozen=True, eq=False)
class LayerVisits:
    """v visits of layers in the order of the path, each from its ``begin`` to the next one's. Read-only arrays."""

    number: NDArray[np.int32]  # (v,) the layer's number, from 1; 0 before the first
    begin: Array  # (v,) m along the path


@dataclass(frozen=True, eq=False)
class Track:
    """k - 1 straight pieces between k points, by distance along the path, with travel moves. Read-only arrays."""

    positions: Array  # (k, 3) m
    distance: Array  # (k,) m, strictly increasing from 0
    layer: NDArray[np.int32]  # (k - 1,) of each piece
    laying: Mask  # (k - 1,) whether material is laid along it
    visits: LayerVisits
    along_x: Array  # (k - 1,) unit vectors in plan view; those of a vertical piece are the previous piece's
    along_y: Array
    level: Array  # (k - 1,) m, lengths in plan view

    @classmethod
    def of(cls, samples: Samples, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Track:
        """Return the path of *samples*, shifted by *shift* (3,), m, for example from the nozzle to the platform."""
        positions = samples.positions + np.asarray(shift, dtype=np.float64)
        way = np.diff(positions[:, :2], axis=0)
        level = np.hypot(way[:, 0], way[:, 1])
        upright = level < 1e-9
        with np.errstate(invalid="ignore", divide="ignore"):
            along = way / level[:, None]
        along = _filled(along, upright)
        layer, laying = samples.layer[1:].copy(), samples.extruding[1:].copy()
        first = np.concatenate([[0], np.flatnonzero(np.diff(layer)) + 1])
        visits = LayerVisits(layer[first], samples.distance[first])
        columns = [np.ascontiguousarray(c) for c in (*along.T, np.where(upright, 0.0, level))]
        made: list[NDArray[Any]] = [positions, layer, laying, visits.number, visits.begin, *columns]
        for column in made:
            column.setflags(write=False)
        return cls(positions, samples.distance, layer, laying, visits, *columns)

    @property
    def length(self) -> float:
        """Length of the path, m."""
        return float(self.distance[-1])

    def piece(self, distance: float) -> int:
        """Return the index of the piece at *distance*, m: of two the later one, beyond the ends the first or last."""
        return min(max(bisect_right(self.distance.data, distance) - 1, 0), len(self.layer) - 1)

    def at(self, distance: float) -> PathPoint:
        """Return the point at *distance*, m, along the path, clamped at both ends of the path."""
        i = self.piece(distance)
        start, end = self.positions[i], self.positions[i + 1]
        begin, after = self.distance[i : i + 2].tolist()
        whole = after - begin
        tangent = (end - start) / whole
        return PathPoint(start + tangent * min(max(distance - begin, 0.0), whole), tangent)

    def places(self, distances: ArrayLike) -> Array:
        """Return points (k, 3), m, at *distances* (k,), m, clamped at both ends of the path."""
        along = np.asarray(distances, dtype=np.float64)
        return np.stack([np.interp(along, self.distance, column) for column in self.positions.T], axis=-1)

    def pieces(self, distances: ArrayLike) -> NDArray[np.int64]:
        """Return the pieces (k,) at *distances* (k,), m, as `piece`."""
        found = np.searchsorted(self.distance, distances, side="right") - 1
        return np.asarray(np.clip(found, 0, len(self.layer) - 1))


def _filled(along: Array, upright: Mask) -> Array:
    """Return unit vectors (n, 2); an *upright* piece gets the previous piece's, else the next one's, else x."""
    if upright.all():
        return np.tile([1.0, 0.0], (len(along), 1))
    number = np.where(upright, -1, np.arange(len(along)))
    before = np.maximum.accumulate(number)
    return np.asarray(along[np.where(before < 0, int(np.argmin(upright)), before)])
