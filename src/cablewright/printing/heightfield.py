"""Heights of material on a level floor, on a grid of square cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, require_positive
from cablewright.foundation.triangle_mesh import TriangleMesh

MAX_CELLS: Final = 25_000_000


@dataclass(frozen=True, eq=False)
class HeightField:
    """Heights (nx, ny), m, each the mean over a square cell of side ``cell``; new material changes them in place."""

    low: tuple[float, float]  # m, the corner of the first cell
    cell: float  # m
    heights: Array

    @classmethod
    def flat(cls, low: tuple[float, float], high: tuple[float, float], cell: float, height: float = 0.0) -> HeightField:
        """Return a flat floor at *height* from *low* to at least *high*, m. Raises `InputError`."""
        sides = np.subtract(high, low)
        if not (np.isfinite(sides).all() and (sides > 0.0).all()):
            raise InputError(f"the area from {low} to {high} m is empty: each lower limit must be below the upper one")
        require_positive(cell=cell)
        counts = np.ceil(sides / cell - 1e-9)
        if not counts.prod() <= MAX_CELLS:
            raise InputError(f"cell = {cell:g} m: more than {MAX_CELLS} cells; give a larger cell")
        nx, ny = (int(count) for count in counts)
        return cls((float(low[0]), float(low[1])), float(cell), np.full((nx, ny), float(height)))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along x and y."""
        return (self.heights.shape[0], self.heights.shape[1])

    @property
    def volume(self) -> float:
        """Volume above height zero, m^3; unknown (NaN) cells count as 0."""
        return float(np.nansum(self.heights)) * self.cell**2

    def centres(self, axis: int) -> Array:
        """Return the centres of the cells along *axis*, m."""
        return np.asarray(self.low[axis] + self.cell * (np.arange(self.shape[axis]) + 0.5))

    def cells_of(self, places: Array) -> NDArray[np.int64]:
        """Return the grid cells (n, 2) of *places* (n, 2 or more), m, also outside the height field."""
        return np.floor((places[:, :2] - self.low) / self.cell).astype(np.int64)

    def holds(self, places: Array) -> Mask:
        """Return whether each of *places* (n, 2 or more), m, is in a cell of the field, (n,)."""
        cells = self.cells_of(places)
        return np.asarray(((cells >= 0) & (cells < self.shape)).all(axis=1))

    def at(self, places: Array) -> Array:
        """Return heights (n,) at *places* (n, 2 or more), m, bilinear between cell centres; NaN outside the field."""
        share = (places[:, :2] - self.low) / self.cell
        outside = ((share < 0.0) | (share > self.shape)).any(axis=1)
        share = np.clip(share - 0.5, 0.0, np.array(self.shape) - 1.0)
        i, j = np.minimum(share.astype(np.int64), np.maximum(np.array(self.shape) - 2, 0)).T
        u, v = share[:, 0] - i, share[:, 1] - j
        more_i, more_j = np.minimum(i + 1, self.shape[0] - 1), np.minimum(j + 1, self.shape[1] - 1)
        h = self.heights
        low, high = h[i, j] * (1 - v) + h[i, more_j] * v, h[more_i, j] * (1 - v) + h[more_i, more_j] * v
        return np.where(outside, np.nan, low * (1 - u) + high * u)

    def solid(self, floor: float = 0.0) -> TriangleMesh:
        """Return the closed body between the heights and *floor*, m; lower heights count as *floor*.

        Its corners are cell centres, so that half a cell is missing on all sides.
        """
        nx, ny = self.shape
        x, y = np.meshgrid(self.centres(0), self.centres(1), indexing="ij")
        top = np.stack([x, y, np.maximum(self.heights, floor)], axis=-1).reshape(-1, 3)
        bottom = top * [1.0, 1.0, 0.0] + [0.0, 0.0, floor]
        number = np.arange(nx * ny).reshape(nx, ny)
        a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
        upper = np.concatenate([_triples(a, b, c), _triples(a, c, d)])
        rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
        after = np.roll(rim, -1)
        under = nx * ny
        walls = np.concatenate([_triples(rim, rim + under, after + under), _triples(rim, after + under, after)])
        return TriangleMesh(np.concatenate([top, bottom]), np.concatenate([upper, upper[:, ::-1] + under, walls]))


def rebuilt(points: Array, like: HeightField) -> HeightField:
    """Return a field with the cells of *like*: the median height of *points* (n, 3), m, in each; NaN without points."""
    nx, ny = like.shape
    cells = like.cells_of(points)
    inside = like.holds(points) & np.isfinite(points[:, 2])
    which, z = cells[inside, 0] * ny + cells[inside, 1], points[inside, 2]
    order = np.lexsort((z, which))
    which, z = which[order], z[order]
    found, first, count = np.unique(which, return_index=True, return_counts=True)
    heights = np.full(nx * ny, np.nan)
    heights[found] = 0.5 * (z[first + (count - 1) // 2] + z[first + count // 2])
    return HeightField(like.low, like.cell, heights.reshape(nx, ny))


def _triples(*corners: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([corner.ravel() for corner in corners], axis=1)
