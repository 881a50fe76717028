"""The ground as the vertical lidar saw it: a height reference where what was laid hides the floor."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask

FLOOR: Final = 5e-3
"""Height, m, up to which ground is floor that does not grow."""

_CELL: Final = 0.025  # m
_SIDE: Final = 1024  # cells; places that are 25.6 m apart share one, which knows whose it is
_NOBODY: Final = np.iinfo(np.int32).min
_MAX_GROWTH: Final = 5e-3  # m by which ground may have grown on average, to be known
_MAX_RISE: Final = 0.03  # m, of ground that was seen again, and not of who stands on it or of a wall
_MIN_AGE: Final = 100.0  # s of ground that tells how fast it grows ...
_MIN_POINTS: Final = 16  # ... and so many points of it
_GAIN: Final = 0.05  # of each time it was seen, in how fast the ground grows


class GroundMap:
    """Heights of the ground over the floor, by cells of 2.5 cm.

    ``growth``: m/s, by which ground that is no floor rises on average, as seen.
    """

    def __init__(self) -> None:
        """Begin with no ground in sight."""
        self.growth = 0.0
        self._heights, self._times = np.zeros(0, dtype=np.float32), np.zeros(0)
        self._owners = np.zeros(0, dtype=np.int32)

    def write(self, places: Array, heights: Array, now: float) -> None:
        """Keep *heights* (k,), m over the floor, of the ground at *places* (k, 2), m, world, at time *now*, s.

        Of each cell the last time counts.
        """
        if not len(self._heights):
            self._heights, self._times = np.zeros(_SIDE * _SIDE, dtype=np.float32), np.zeros(_SIDE * _SIDE)
            self._owners = np.full(_SIDE * _SIDE, _NOBODY, dtype=np.int32)
        cells, owners = _cells(places)
        self._learn_growth(cells, owners, heights, now)
        chosen, own, count = np.unique(cells, return_inverse=True, return_counts=True)
        self._heights[chosen] = np.bincount(own, heights) / count
        self._owners[cells], self._times[cells] = owners, now

    def at(self, places: Array, now: float) -> tuple[Array, Mask]:
        """Return heights (k,), m over the floor, at *places* (k, 2), m, world, at time *now*, s; which are known."""
        if not len(self._heights):
            return np.zeros(len(places)), np.zeros(len(places), dtype=np.bool_)
        cells, owners = _cells(places)
        heights, ages = self._heights[cells].astype(np.float64), now - self._times[cells]
        grown = self.growth * ages
        known = (self._owners[cells] == owners) & (ages >= 0.0) & (grown <= _MAX_GROWTH)  # a clock may be set back
        return heights + grown * (heights > FLOOR), known

    def _learn_growth(self, cells: NDArray[np.int64], owners: NDArray[np.int32], heights: Array, now: float) -> None:
        """Learn how fast ground grows from *heights* (k,) that are seen again."""
        before, ages = self._heights[cells], now - self._times[cells]
        rises = heights - before
        old = (self._owners[cells] == owners) & (ages > _MIN_AGE) & (before > FLOOR) & (np.abs(rises) < _MAX_RISE)
        if np.count_nonzero(old) >= _MIN_POINTS:
            seen = float(np.median(rises[old] / ages[old]))
            self.growth = max(0.0, self.growth + _GAIN * (seen - self.growth))


def _cells(places: Array) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Cell (k,) of each of the *places* (k, 2), and which of the squares it belongs to that share one (k,)."""
    row, column = np.floor(places.T / _CELL).astype(np.int64)
    square = (row // _SIDE) * 40_009 + column // _SIDE
    return (row % _SIDE) * _SIDE + column % _SIDE, square.astype(np.int32)
