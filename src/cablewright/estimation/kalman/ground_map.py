"""The ground as the vertical lidar saw it: a height reference where what was laid hides the floor."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask

FLOOR: Final = 5e-3
"""Height, m, up to which ground that nothing was laid on is floor."""

_CELL: Final = 0.025  # m
_SIDE: Final = 1024  # cells; places that are 25.6 m apart share one, which knows whose it is
_NOBODY: Final = np.iinfo(np.int32).min
_REACH: Final = 0.15  # m beside the nozzle, of what it lays
_STRIDE: Final = 0.03  # m along its path, between two places from which ground is reached
_STANDS: Final = 0.02  # m within which the nozzle stands
_MAX_LEAP: Final = 5.0  # m from one place to the next, along which nothing is known to be laid
_MAX_GROWTH: Final = 0.02  # m by which ground may have grown by what is known of all, to be known
_MAX_RISE: Final = 0.03  # m, of ground that was seen again, and not of who stands on it or of a wall
_MIN_PATH: Final = 0.1  # m of path, of ground that tells how fast it grows ...
_MIN_POINTS: Final = 16  # ... and so many points of it
_GAIN: Final = 0.05  # of each time it was seen, in how fast the ground grows


class KnownGround(NamedTuple):
    """What is expected at some places."""

    heights: Array  # (k,) m over the floor
    grown: Array  # (k,) m of it, since it was seen
    known: Mask  # (k,)


class GroundMap:
    """Heights of the ground over the floor, by cells of 2.5 cm, and how much of the nozzle's path was near each.

    ``growth``: by how much ground rises on average for each metre of path near it, as seen.
    """

    def __init__(self) -> None:
        """Begin with no ground in sight."""
        self.growth = 0.0
        self._place: Array | None = None  # (2,) m, world, of the nozzle at the last `passing`
        self._heights, self._owners = np.zeros(0, dtype=np.float32), np.zeros(0, dtype=np.int32)
        self._paths, self._paths_seen = np.zeros(0, dtype=np.float32), np.zeros(0, dtype=np.float32)  # m

    def passing(self, x: float, y: float) -> None:
        """The nozzle is over (x, y), m, world, on a straight way from where it was: it may have laid."""
        place, before = np.array([x, y]), self._place
        away = math.inf if before is None else float(np.hypot(*(place - before)))
        if away < _STANDS:
            return
        self._place = place
        if before is None or away > _MAX_LEAP:
            return
        steps = math.ceil(away / _STRIDE)
        reached = before + np.linspace(1.0, 0.0, steps, endpoint=False)[:, None, None] * (place - before)
        cells = self._own((reached + _DISC).reshape(-1, 2))
        np.add.at(self._paths, cells, away / steps)

    def write(self, places: Array, heights: Array) -> None:
        """Keep *heights* (k,), m over the floor, of the ground at *places* (k, 2), m, world.

        Of each cell the last time counts.
        """
        cells = self._own(places)
        self._learn_growth(cells, heights)
        chosen, own, count = np.unique(cells, return_inverse=True, return_counts=True)
        self._heights[chosen] = np.bincount(own, heights) / count
        self._paths_seen[chosen] = self._paths[chosen]

    def at(self, places: Array) -> KnownGround:
        """Return what is expected at *places* (k, 2), m, world."""
        if not len(self._heights):
            return KnownGround(np.zeros(len(places)), np.zeros(len(places)), np.zeros(len(places), dtype=np.bool_))
        cells, owners = _cells(places)
        heights = self._heights[cells].astype(np.float64)
        grown = self.growth * (self._paths[cells] - self._paths_seen[cells]).astype(np.float64)
        known = (self._owners[cells] == owners) & np.isfinite(heights) & (grown <= _MAX_GROWTH)
        return KnownGround(heights + grown, grown, known)

    def passed(self, places: Array) -> Mask:
        """Return over which of the *places* (k, 2), m, world, the nozzle has passed: ground that may have grown."""
        if not len(self._heights):
            return np.zeros(len(places), dtype=np.bool_)
        cells, owners = _cells(places)
        return np.asarray((self._owners[cells] == owners) & (self._paths[cells] > 0.0))

    def _own(self, places: Array) -> NDArray[np.int64]:
        """Cells (k,) of *places* (k, 2), m, which from now on are those of no other places."""
        if not len(self._heights):
            size = _SIDE * _SIDE
            self._heights, self._owners = (
                np.full(size, np.nan, dtype=np.float32),
                np.full(size, _NOBODY, dtype=np.int32),
            )
            self._paths, self._paths_seen = np.zeros(size, dtype=np.float32), np.zeros(size, dtype=np.float32)
        cells, owners = _cells(places)
        lost = cells[self._owners[cells] != owners]
        self._heights[lost] = np.nan
        self._paths[lost] = self._paths_seen[lost] = 0.0
        self._owners[cells] = owners
        return cells

    def _learn_growth(self, cells: NDArray[np.int64], heights: Array) -> None:
        """Learn how fast ground grows from *heights* (k,) that are seen again."""
        rises, paths = heights - self._heights[cells], self._paths[cells] - self._paths_seen[cells]
        old = (paths > _MIN_PATH) & (np.abs(rises) < _MAX_RISE)
        if np.count_nonzero(old) >= _MIN_POINTS:
            seen = float(np.median(rises[old] / paths[old]))
            self.growth = max(0.0, self.growth + _GAIN * (seen - self.growth))


def _cells(places: Array) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Cell (k,) of each of the *places* (k, 2), and which of the squares it belongs to that share one (k,)."""
    row, column = np.floor(places.T / _CELL).astype(np.int64)
    square = (row // _SIDE) * 40_009 + column // _SIDE
    return (row % _SIDE) * _SIDE + column % _SIDE, square.astype(np.int32)


def _disc() -> Array:
    """Places (d, 2), m, one in each cell within reach of the nozzle."""
    steps = np.arange(-_REACH, _REACH + _CELL, _CELL)
    x, y = np.meshgrid(steps, steps)
    near = np.hypot(x, y) <= _REACH
    return np.stack([x[near], y[near]], axis=1)


_DISC: Final = _disc()
