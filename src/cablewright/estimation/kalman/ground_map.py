"""Map of the ground by the vertical lidar: the reference of height where printed material hides the floor."""

from __future__ import annotations

import math
import mmap
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.filtering import ground_cells as kernel

_REACH: Final = 0.15  # m beside the nozzle, of laid material ...
_FOOT: Final = 0.5  # ... and of the foot of earlier material
_STRIDE: Final = 0.05  # m along its path, between two places from which ground is reached
_MAX_LEAP: Final = 5.0  # m from one place to the next, along which nothing is known to be laid


class KnownGround(NamedTuple):
    """What is expected at some positions on the ground.

    The floor may be visible where it was the last time, and where ground is seen to grow, the nozzle has not passed and
    little may have been laid near since.
    """

    heights: Array  # (k,) m over the floor
    may_have_grown: Array  # (k,) m, since it was seen
    known: Mask  # (k,)
    may_be_floor: Mask  # (k,)
    was_floor: Mask  # (k,) whether the last scan, just before, showed the floor


class GroundMap:
    """Map of ground heights above the floor, in cells of 2.5 cm, and of the nozzle's path near each.

    ``growth``: m by which ground rises on average for each metre of path near it, as measured.
    """

    def __init__(self) -> None:
        """Begin with no ground in sight."""
        self.growth = 0.0
        self._gone = 0.0  # m, by the nozzle
        self._place: tuple[float, float] | None = None  # m, world, to which the nozzle's path is counted
        self._marks, self._kept = np.zeros((0, kernel.MARKS), np.int32), np.zeros((0, kernel.KEPT), np.float32)

    def passing(self, x: float, y: float) -> None:
        """Record that the nozzle has moved straight to (x, y), m, world: it may have laid material there."""
        before = self._place
        away = math.inf if before is None else math.dist(before, (x, y))
        if away < _STRIDE or not math.isfinite(x + y):
            return
        self._place = x, y
        if before is None or away > _MAX_LEAP:
            return
        self._gone += away
        steps = math.ceil(away / _STRIDE)
        for column, disc in ((kernel.PATH, _AT_FOOT), (kernel.LAID, _BELOW)):
            kernel.go(*self._cells(), before, x, y, steps, away / steps, disc, column)

    def interrupt(self) -> None:
        """Record that the nozzle's path to its next position is unknown."""
        self._place = None

    def write(self, places: Array, heights: Array) -> None:
        """Store the *heights* (k,), m above the floor, of the ground at *places* (k, 2), m, world.

        Of each cell the last time counts.
        """
        self.growth = kernel.write(*self._cells(), places, heights, self.growth, self._gone)

    def at(self, places: Array) -> KnownGround:
        """Return what is expected at *places* (k, 2), m, world."""
        k = len(places)
        found = KnownGround(np.empty(k), np.empty(k), *np.empty((3, k), np.bool_))
        kernel.look_up(*self._cells(), places, self.growth, self._gone, *found)
        return found

    def _cells(self) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Cells and what is kept of them, in memory that the system provides where it is written to."""
        if not len(self._kept):
            self._marks, self._kept = _zeros(kernel.MARKS, np.int32), _zeros(kernel.KEPT, np.float32)
        return self._marks, self._kept


def _zeros(columns: int, kind: type) -> NDArray[Any]:
    """Zeros (n, *columns*) for the n cells. The system provides each page of 4 KiB when it is first written to.

    Those of `numpy.zeros` come in pages of 2 MiB, or are all written where the memory was used before.
    """
    size = kernel.SIDE**2 * columns * np.dtype(kind).itemsize
    return np.frombuffer(mmap.mmap(-1, size, access=mmap.ACCESS_COPY), kind).reshape(-1, columns)


def _disc(radius: float) -> Array:
    """Places (d, 2), m, one in each cell within a *radius*, m."""
    steps = np.arange(-radius, radius + kernel.CELL, kernel.CELL)
    x, y = np.meshgrid(steps, steps)
    near = np.hypot(x, y) <= radius
    return np.stack([x[near], y[near]], axis=1)


_BELOW: Final = _disc(_REACH)
_AT_FOOT: Final = _disc(_FOOT)
