"""Closed smooth paths that cross themselves, as the exhibition of Merlet and Papegay 2023 had: random ones, by seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError

__all__ = ["Loop", "random_loop"]

Array = NDArray[np.float64]

_WAVES: Final = 5
_FINE: Final = 2000  # pieces of the curve while its length is measured
_COARSE: Final = 240  # pieces while its crossings are counted
_TRIES: Final = 4000
_LEAST_FILL: Final = 0.6  # of the box: a smaller loop is a knot
_LEAST_RADIUS: Final = 0.08  # m


@dataclass(frozen=True, eq=False)
class Loop:
    """A closed path in a plane, by its distance from the start; linear between its points. Read-only arrays."""

    points: Array  # (k, 2) m, the last one the first again
    distance: Array  # (k,) m, from 0 to the length

    @property
    def length(self) -> float:
        """Length of one round, m."""
        return float(self.distance[-1])

    def at(self, distance: Array | float) -> Array:
        """Return where one is after *distance* (...), m, round after round: (..., 2) m."""
        along = np.mod(distance, self.length)
        return np.stack([np.interp(along, self.distance, column) for column in self.points.T], axis=-1)

    @property
    def crossings(self) -> int:
        """How often the path crosses itself."""
        return _crossings(self.at(np.linspace(0.0, self.length, _COARSE + 1)))


def random_loop(
    length: float, low: tuple[float, float], high: tuple[float, float], *, seed: int, crossings: int = 2
) -> Loop:
    """Return a smooth closed path of that *length* (m) in the rectangle from *low* to *high* (m) that crosses itself.

    A few waves of random size, drawn until the curve is as long as asked, fills most of the rectangle, bends nowhere
    sharper than 8 cm and crosses itself at least *crossings* times. Raises `InputError` where none is found.
    """
    size = np.subtract(high, low)
    if not (size > 0.0).all() or not length > 0.0:
        raise InputError(f"a loop of {length:g} m from {low} to {high}: a length over 0 and a box with room are wanted")
    if seed < 0:
        raise InputError(f"seed = {seed}: a whole number from 0 on is wanted")
    random = np.random.default_rng([seed, 6])
    phase = np.linspace(0.0, 2.0 * np.pi, _FINE + 1)
    waves = np.arange(1, _WAVES + 1)
    for _ in range(_TRIES):
        sizes = random.standard_normal((2, 2, _WAVES)) / np.sqrt(waves)
        curve = sizes[0] @ np.cos(np.outer(waves, phase)) + sizes[1] @ np.sin(np.outer(waves, phase))  # (2, k)
        curve = (curve - curve.min(axis=1, keepdims=True)) / np.ptp(curve, axis=1, keepdims=True) * size[:, None]
        scale = length / float(np.hypot(*np.diff(curve)).sum())
        if not _LEAST_FILL <= scale <= 1.0:
            continue
        points = (curve.T - size / 2) * scale + np.add(low, high) / 2
        if _least_radius(points) < _LEAST_RADIUS:
            continue
        steps = np.hypot(*np.diff(points, axis=0).T)
        distance = np.concatenate([[0.0], np.cumsum(steps)])
        loop = Loop(points, distance)
        if loop.crossings >= crossings:
            for column in (points, distance):
                column.flags.writeable = False
            return loop
    raise InputError(f"no loop of {length:g} m from {low} to {high}: of {_TRIES} none is that long and fills the box")


def _least_radius(points: Array) -> float:
    """The smallest radius (m) of curvature of a closed curve, by the circle through three points."""
    before, here, after = points[:-2], points[1:-1], points[2:]
    a, b, c = here - before, after - here, after - before
    sides = np.hypot(*a.T) * np.hypot(*b.T) * np.hypot(*c.T)
    return float((sides / np.maximum(2.0 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 1e-300)).min())


def _crossings(points: Array) -> int:
    """How many pairs of pieces that do not touch cross."""
    start, way = points[:-1], np.diff(points, axis=0)
    across = way[:, None, 0] * way[None, :, 1] - way[:, None, 1] * way[None, :, 0]
    apart = start[None] - start[:, None]  # (i, j): from piece i's start to j's
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (apart[..., 0] * way[None, :, 1] - apart[..., 1] * way[None, :, 0]) / across
    met = (along >= 0.0) & (along < 1.0)
    both = np.triu(met & met.T, 2)
    both[0, -1] = False  # neighbours round the end
    return int(both.sum())
