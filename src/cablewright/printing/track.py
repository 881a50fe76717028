"""The path by its arc length, and the offset of points from it.

A path crosses itself and lies above itself, so that the nearest point of the whole path may be on the wrong branch: the
search is limited to a range about the expected distance. Offsets are in plan view, positive to the left of the path.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.printing.path import Samples

WITHIN: Final = 0.5
"""Half the range along the path in which the nearest point is searched, m."""

_SAME: Final = 1e-12  # m^2: of points at equal squared distances the one nearest along the path counts
_MAX_PAIRS: Final = 500_000  # of points and pieces per batch, to limit memory


class PathPoint(NamedTuple):
    """A point of the path and the unit tangent there."""

    position: Array  # (3,) m
    tangent: Array  # (3,)


class Nearest(NamedTuple):
    """The nearest point of the path in plan view: its distance along the path, and the offset from the path."""

    distance: float  # m from the path's beginning
    offset: float  # m; positive is left of the path


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
    _x: Array
    _y: Array
    _along_x: Array  # (k - 1,) unit vectors in plan view; those of a vertical piece are the previous piece's
    _along_y: Array
    _level: Array  # (k - 1,) m, lengths in plan view

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
        columns = [np.ascontiguousarray(c) for c in (*positions.T[:2], *along.T, np.where(upright, 0.0, level))]
        made: list[NDArray[Any]] = [positions, layer, laying, visits.number, visits.begin, *columns]
        for column in made:
            column.setflags(write=False)
        return cls(positions, samples.distance, layer, laying, visits, *columns)

    @property
    def length(self) -> float:
        """Length of the path, m."""
        return float(self.distance[-1])

    def piece(self, distance: float) -> int:
        """Return the piece at *distance*, m: of two the one that begins there, beyond the ends the first or last."""
        return min(max(bisect_right(self.distance.data, distance) - 1, 0), len(self.layer) - 1)

    def at(self, distance: float) -> PathPoint:
        """Return the point at *distance*, m, clamped at both ends of the path."""
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

    def nearest(self, point: Sequence[float] | Array, around: float, within: float = WITHIN) -> Nearest:
        """Return the path point nearest to *point* (2 or more), m, in plan view.

        Only pieces up to *within* (m) along the path from the distance *around* (m) count. Beyond the path's ends the
        offset is from the path's straight continuation. A point above a vertical piece is at its lower end.
        """
        first, stop = self._window(around, within)
        part = slice(first, stop)
        ux, uy = self._along_x[part], self._along_y[part]
        x, y = point[0] - self._x[part], point[1] - self._y[part]
        along = x * ux
        along += y * uy
        np.maximum(along, 0.0, out=along)
        np.minimum(along, self._level[part], out=along)
        x -= along * ux
        y -= along * uy
        squared = x * x
        squared += y * y
        chosen = int(squared.argmin())
        smallest = float(squared[chosen])
        same = np.flatnonzero(squared <= smallest + _SAME)
        if len(same) > 1:
            chosen = min(same.tolist(), key=lambda i: abs(self._reached(first + i, float(along[i])) - around))
        i, reach = first + chosen, float(along[chosen])
        return Nearest(
            self._reached(i, reach), self._signed(i, reach, float(x[chosen]), float(y[chosen]), float(squared[chosen]))
        )

    def nearest_of_each(self, points: Array, around: Array, within: float = WITHIN) -> tuple[Array, Array]:
        """Return distances (k,) and offsets (k,), m, as `nearest`, for *points* (k, 2 or more) and *around* (k,)."""
        distance, offset = np.full(len(points), np.nan), np.full(len(points), np.nan)
        first = np.clip(np.searchsorted(self.distance, around - within, side="right") - 1, 0, len(self.layer) - 1)
        stop = np.maximum(np.clip(np.searchsorted(self.distance, around + within), 0, len(self.layer)), first + 1)
        known = np.flatnonzero(np.isfinite(points[:, :2]).all(axis=1) & np.isfinite(around))
        pairs = np.cumsum((stop - first)[known])
        cuts = np.searchsorted(pairs, np.arange(_MAX_PAIRS, pairs[-1] if len(pairs) else 0, _MAX_PAIRS))
        for rows in np.split(known, np.unique(cuts)):
            if len(rows):
                distance[rows], offset[rows] = self._nearest(points[rows], around[rows], first[rows], stop[rows])
        return distance, offset

    def _nearest(
        self, points: Array, around: Array, first: NDArray[np.int64], stop: NDArray[np.int64]
    ) -> tuple[Array, Array]:
        """Compare each point with its pieces from *first* to before *stop*, as one long list of pairs."""
        count = stop - first
        begin = np.cumsum(count) - count
        piece = np.arange(int(count.sum())) + np.repeat(first - begin, count)
        ux, uy = self._along_x[piece], self._along_y[piece]
        x = np.repeat(points[:, 0], count) - self._x[piece]
        y = np.repeat(points[:, 1], count) - self._y[piece]
        along = np.clip(x * ux + y * uy, 0.0, self._level[piece])
        x, y = x - along * ux, y - along * uy
        squared = x * x + y * y
        smallest = np.repeat(np.minimum.reduceat(squared, begin), count)
        whole = self._level[piece]
        share = np.divide(along, whole, out=np.zeros_like(along), where=whole > 0.0)
        reached = self.distance[piece] + share * (self.distance[piece + 1] - self.distance[piece])
        away = np.where(squared <= smallest + _SAME, np.abs(reached - np.repeat(around, count)), np.inf)
        chosen = np.flatnonzero(away == np.repeat(np.minimum.reduceat(away, begin), count))
        owner = np.repeat(np.arange(len(points)), count)[chosen]
        chosen = chosen[np.unique(owner, return_index=True)[1]]
        rows = zip(
            piece[chosen].tolist(), along[chosen].tolist(), x[chosen].tolist(), y[chosen].tolist(),
            squared[chosen].tolist(), strict=True,
        )  # fmt: skip
        return reached[chosen], np.array([self._signed(*row) for row in rows])

    def _window(self, around: float, within: float) -> tuple[int, int]:
        """Return the first piece within *within* of *around*, and one beyond the last."""
        first = self.piece(around - within)
        return first, max(first + 1, min(bisect_left(self.distance.data, around + within), len(self.layer)))

    def _reached(self, i: int, along: float) -> float:
        """Return the distance along the path of the point *along* m, in plan view, into piece *i*."""
        whole = float(self._level[i])
        begin = float(self.distance[i])
        return begin + along * (float(self.distance[i + 1]) - begin) / whole if whole else begin

    def _signed(self, i: int, along: float, x: float, y: float, squared: float) -> float:
        """Return the offset (x, y) from a point of piece *i* with its sign: at a corner, left of the mean direction."""
        ux, uy = float(self._along_x[i]), float(self._along_y[i])
        if along <= 0.0:
            if i == 0:
                return ux * y - uy * x
            ux, uy = ux + float(self._along_x[i - 1]), uy + float(self._along_y[i - 1])
        elif along >= self._level[i]:
            if i + 1 == len(self.layer):
                return ux * y - uy * x
            ux, uy = ux + float(self._along_x[i + 1]), uy + float(self._along_y[i + 1])
        return math.copysign(math.sqrt(squared), ux * y - uy * x)


def _filled(along: Array, upright: Mask) -> Array:
    """Return unit vectors (n, 2); an *upright* piece gets the previous piece's, else the next one's, else x."""
    if upright.all():
        return np.tile([1.0, 0.0], (len(along), 1))
    number = np.where(upright, -1, np.arange(len(along)))
    before = np.maximum.accumulate(number)
    return np.asarray(along[np.where(before < 0, int(np.argmin(upright)), before)])
