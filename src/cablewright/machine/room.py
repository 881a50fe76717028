"""What is around the machine: walls, ceiling, and a floor with what lies on it, as heights on a grid."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.machine.settings import Room

__all__ = ["Ground", "walls_of"]

Array = NDArray[np.float64]

_SPREAD: Final = 0.06
"""Radius of the heap that falling powder makes, m; assumed. How heaps then slide is not modelled here."""


def walls_of(room: Room) -> Array:
    """Return the walls as a lidar's kernel takes them: (j, 4), x and y of both ends, m, world."""
    return np.array([(*wall.start, *wall.end) for wall in room.walls], dtype=np.float64).reshape(-1, 4)


class Ground:
    """Heights of what lies on the floor, on a square grid; linear between four nodes, nothing outside.

    Changes in place as powder falls. Powder that falls outside is kept count of, so that no mass is lost.
    """

    def __init__(self, low: tuple[float, float], high: tuple[float, float], cell: float = 0.02) -> None:
        """Begin bare, over the rectangle from *low* to *high*, m, with nodes every *cell*, m."""
        counts = [math.ceil((b - a) / cell - 1e-9) + 1 for a, b in zip(low, high, strict=True)]
        self.heights: Array = np.zeros(counts)
        self.low, self.cell, self.outside = low, cell, 0.0
        reach = math.ceil(_SPREAD / cell)
        self._offsets = np.arange(-reach, reach + 2)

    @property
    def grid(self) -> Array:
        """Where the grid is, as a lidar's kernel takes it: first node's x and y, distance of nodes, highest height."""
        return np.array([*self.low, self.cell, self._top])

    @property
    def volume(self) -> float:
        """What lies on the floor, m^3, with what fell outside."""
        return float(self.heights.sum()) * self.cell**2 + self.outside

    _top = 0.0

    def pour(self, x: float, y: float, volume: float) -> None:
        """Let *volume* (m^3) fall at (x, y), m, world: a round heap, all of it."""
        u, v = (x - self.low[0]) / self.cell, (y - self.low[1]) / self.cell
        i, j = self._offsets + math.floor(u), self._offsets + math.floor(v)
        away = ((i - u)[:, None] ** 2 + (j - v)[None, :] ** 2) * (self.cell / _SPREAD) ** 2
        share = np.maximum(0.0, 1.0 - away) ** 2
        heap = share * (volume / (share.sum() * self.cell**2))
        nx, ny = self.heights.shape
        inside_x, inside_y = (i >= 0) & (i < nx), (j >= 0) & (j < ny)
        if inside_x.all() and inside_y.all():
            target = self.heights[i[0] : i[-1] + 1, j[0] : j[-1] + 1]
            target += heap
        else:
            kept = heap[np.ix_(inside_x, inside_y)]
            self.outside += volume - float(kept.sum()) * self.cell**2
            if kept.size == 0:
                return
            target = self.heights[np.ix_(i[inside_x], j[inside_y])] + kept
            self.heights[np.ix_(i[inside_x], j[inside_y])] = target
        self._top = max(self._top, float(target.max()))
