"""Map of the ground by the vertical lidar: the reference of height where printed material hides the floor."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask

FLOOR: Final = 5e-3
"""Height, m, up to which ground that nothing was laid on is floor."""

_CELL: Final = 0.025  # m
_SIDE: Final = 1024  # cells; places that are 25.6 m apart share one, which knows whose it is
_NOBODY: Final = np.iinfo(np.int32).min
_REACH: Final = 0.15  # m beside the nozzle, of laid material ...
_FOOT: Final = 0.5  # ... and of the foot of earlier material
_STRIDE: Final = 0.05  # m along its path, between two places from which ground is reached
_MAX_LEAP: Final = 5.0  # m from one place to the next, along which nothing is known to be laid
_FOOT_PATH: Final = 2.0  # m of path since the floor was seen, whose foot may have come as far
_RECENT: Final = 0.5  # m that the nozzle has gone since ground was seen, in which it is as it was
_GROWS: Final = 3e-4  # m for each metre of path, from which something is laid
_MAX_GROWTH: Final = 0.02  # m by which ground may have grown, to be known
_MAX_RISE: Final = 0.03  # m, of ground that was seen again, and not of who stands on it or of a wall
_MIN_PATH: Final = 0.5  # m of path, of ground that shows how fast it grows ...
_MIN_POINTS: Final = 16  # ... and so many points of it
_GAIN: Final = 0.05  # of each time it was seen, in how fast the ground grows on average
_OWN_PATH: Final = 6.0  # m of path near a cell, over which its own growth is averaged

_KEPT: Final = np.dtype([
    ("owner", np.int32),  # of the squares that share a cell
    ("height", np.float32),  # m over the floor as last seen; NaN: never
    ("growth", np.float32),  # m by which it rises for each metre of path; NaN: as all
    ("laid", np.float32),  # m of the nozzle's path so near that it lays there
    ("path", np.float32),  # m of the path so near that the foot of its material comes there ...
    ("path_seen", np.float32),  # ... when it was last seen
    ("seen_at", np.float32),  # m that the nozzle had gone then
])  # fmt: skip
_UNSEEN: Final = np.array((_NOBODY, np.nan, np.nan, 0.0, 0.0, 0.0, 0.0), dtype=_KEPT)


class KnownGround(NamedTuple):
    """Expected heights of the ground at some positions."""

    heights: Array  # (k,) m over the floor
    may_have_grown: Array  # (k,) m, since it was seen
    known: Mask  # (k,)


class GroundMap:
    """Map of ground heights above the floor, in cells of 2.5 cm, and of the nozzle's path near each.

    ``growth``: m by which ground rises on average for each metre of path near it, as measured.
    """

    def __init__(self) -> None:
        """Begin with no ground in sight."""
        self.growth = 0.0
        self._gone = 0.0  # m, by the nozzle
        self._place: tuple[float, float] | None = None  # m, world, to which the nozzle's path is counted
        self._kept = np.zeros(0, dtype=_KEPT)

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
        shares = np.linspace(1.0, 0.0, steps, endpoint=False)[:, None, None]
        reached = np.array(before) + shares * (np.array([x, y]) - before)
        for kind, disc in (("path", _WIDE), ("laid", _LAID)):
            cells = self._own((reached + disc).reshape(-1, 2))
            np.add.at(self._kept[kind], cells, away / steps)

    def interrupt(self) -> None:
        """Record that the nozzle's path to its next position is unknown."""
        self._place = None

    def write(self, places: Array, heights: Array) -> None:
        """Store the *heights* (k,), m above the floor, of the ground at *places* (k, 2), m, world.

        Of each cell the last time counts.
        """
        cells = self._own(places)
        self._learn_growth(self._kept[cells], heights)
        chosen, own, count = np.unique(cells, return_inverse=True, return_counts=True)
        kept, seen = self._kept[chosen], np.bincount(own, heights) / count
        paths, rises = kept["path"] - kept["path_seen"], seen - kept["height"]
        learnt = (rises + _OWN_PATH * self._growths(kept)) / (paths + _OWN_PATH)
        is_growth = (paths > 0.0) & (np.abs(rises) < _MAX_RISE)
        kept["growth"] = np.where(is_growth, learnt, kept["growth"])
        kept["height"], kept["path_seen"], kept["seen_at"] = seen, kept["path"], self._gone
        self._kept[chosen] = kept

    def at(self, places: Array) -> KnownGround:
        """Return the expected ground heights at *places* (k, 2), m, world."""
        kept, ours = self._find(places)
        growths, paths = self._growths(kept), (kept["path"] - kept["path_seen"]).astype(np.float64)
        may_have_grown = np.maximum(growths, self.growth) * paths
        known = ours & np.isfinite(kept["height"]) & (may_have_grown <= _MAX_GROWTH)
        return KnownGround(kept["height"] + growths * paths, may_have_grown, known)

    def may_be_floor(self, places: Array) -> Mask:
        """Return at which of the *places* (k, 2), m, world, the floor may be visible.

        It was the last time, and where ground is seen to grow, the nozzle has not passed there and little may have been
        laid near since.
        """
        kept, ours = self._find(places)
        as_it_was = (kept["laid"] == 0.0) & (kept["path"] - kept["path_seen"] <= _FOOT_PATH)
        free = as_it_was | (self.growth < _GROWS)
        return np.asarray((free & ~(kept["height"] > FLOOR)) | ~ours)  # NaN: never seen

    def was_floor(self, places: Array) -> Mask:
        """Return at which of the *places* (k, 2), m, world, the last scan showed the floor."""
        kept, ours = self._find(places)
        return np.asarray(ours & (kept["height"] < FLOOR) & (self._gone - kept["seen_at"] < _RECENT))

    def _find(self, places: Array) -> tuple[NDArray[np.void], Mask]:
        """Return what is kept (k,) in the cells of *places* (k, 2), m, and whether it is of these."""
        if not len(self._kept):
            return np.full(len(places), _UNSEEN), np.zeros(len(places), dtype=np.bool_)
        cells, owners = _cells(places)
        kept = self._kept[cells]
        return kept, np.asarray(kept["owner"] == owners)

    def _own(self, places: Array) -> NDArray[np.int64]:
        """Cells (k,) of *places* (k, 2), m, which from now on are those of no other places."""
        if not len(self._kept):
            self._kept = np.full(_SIDE * _SIDE, _UNSEEN)
        cells, owners = _cells(places)
        self._kept[cells[self._kept["owner"][cells] != owners]] = _UNSEEN
        self._kept["owner"][cells] = owners
        return cells

    def _growths(self, kept: NDArray[np.void]) -> Array:
        """By how much each of the *kept* (k,) rises for each metre of path: as it did, or as all do on average."""
        return np.where(np.isnan(kept["growth"]), self.growth, kept["growth"].astype(np.float64))

    def _learn_growth(self, kept: NDArray[np.void], heights: Array) -> None:
        """Learn how fast ground grows from *heights* (k,) where something is *kept* (k,)."""
        rises, paths = heights - kept["height"], kept["path"] - kept["path_seen"]
        old = (paths > _MIN_PATH) & (np.abs(rises) < _MAX_RISE)
        if np.count_nonzero(old) >= _MIN_POINTS:
            seen = float(np.median(rises[old] / paths[old]))
            self.growth = max(0.0, self.growth + _GAIN * (seen - self.growth))


def _cells(places: Array) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Cell (k,) of each of the *places* (k, 2), and which of the squares it belongs to that share one (k,)."""
    row, column = np.floor(places.T / _CELL).astype(np.int64)
    square = (row // _SIDE) * 40_009 + column // _SIDE
    return (row % _SIDE) * _SIDE + column % _SIDE, square.astype(np.int32)


def _disc(radius: float) -> Array:
    """Places (d, 2), m, one in each cell within a *radius*, m."""
    steps = np.arange(-radius, radius + _CELL, _CELL)
    x, y = np.meshgrid(steps, steps)
    near = np.hypot(x, y) <= radius
    return np.stack([x[near], y[near]], axis=1)


_LAID: Final = _disc(_REACH)
_WIDE: Final = _disc(_FOOT)
