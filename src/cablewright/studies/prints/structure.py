"""The structure that a print leaves, rebuilt from vertical scans, beside the true one where that is known.

Merlet and Papegay 2023, III.A: a full turn of the vertical lidar each 2 s, put in place by where the drum was believed
to be at each ray. Structure grows while it is scanned: the scans of the last two layers are kept, and of what was seen
of a place only the last seconds count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.machine.simulated.settings import LidarSettings
from cablewright.printing.heightfield import HeightField, rebuilt
from cablewright.printing.track import Track
from cablewright.signals import Estimate, Scan

__all__ = ["CELL", "CrossSection", "HeightDifference", "PrintedStructure", "StructureScans", "structure_of"]

Array = NDArray[np.float64]

CELL: Final = 0.02
"""Side of a cell of what is rebuilt, m."""

EVERY: Final = 2.0
"""s between two scans that count: the paper's."""

_MARGIN: Final = 0.6  # m about the path that is rebuilt
_CONE: Final = math.radians(70.0)  # to both sides of the drum's axis: beyond it rays graze
_NOISE: Final = 0.05  # m below the floor, or off both neighbours, no ray goes that met something
_KEPT: Final = 1000  # rows of where the drum was
_MAX_POINTS: Final = 2_000_000  # of one layer
_GAP: Final = 0.1  # m between two scans that is bridged: they are 6 cm apart at 3 cm/s
_LATEST: Final = 8.0  # s: what is seen together, some scans
_NOTHING: Final = 5e-3  # m: what is lower may be noise
_CUT: Final = 0.5  # m to both sides of the path
_APART: Final = 1.0  # m along the path beyond which another pass is another


class StructureScans:
    """Gathers points of the vertical lidar, layer by layer."""

    def __init__(self, lidar: LidarSettings, track: Track) -> None:
        """For one *lidar* on a drum that follows *track*."""
        self._place, self._axes = np.array(lidar.place), np.array(lidar.axes)
        self._sigma = lidar.deviation
        self._track = track
        self._trail = TimeBuffer(6, _KEPT)
        self._last, self._visit = -math.inf, -1
        self._points: list[Array] = []  # (k, 4) each: place, m, and time, s
        self._before: list[Array] = []
        self._count = 0

    def set_pose(self, estimate: Estimate, distance: float) -> None:
        """Note where the drum is believed to be, *distance* (m) along the path."""
        if estimate.valid and np.isfinite(estimate.position).all() and np.isfinite(estimate.rotation).all():
            self._trail.add(estimate.time, np.concatenate([estimate.position, estimate.rotation]))
        visit = int(np.searchsorted(self._track.visits.begin, distance, side="right")) - 1
        if visit > self._visit:
            self._before, self._points, self._count, self._visit = self._points, [], 0, visit

    def add(self, scan: Scan) -> None:
        """Take one turn."""
        if scan.time - self._last < EVERY - 1e-6 or not len(self._trail) or self._count >= _MAX_POINTS:
            return
        self._last = scan.time
        angles = scan.angles
        good = np.isfinite(scan.ranges) & (np.abs(angles) <= _CONE)
        where = self._trail.at(scan.times[good])
        x, y = self._axes
        rays = np.cos(angles[good])[:, None] * x + np.sin(angles[good])[:, None] * y
        points = where[:, :3] + _turned(self._place + scan.ranges[good, None] * rays, where[:, 3:])
        kept = _hanging_together(scan.ranges[good]) & (points[:, 2] > -_NOISE)
        points[:, 2] += _lift(points[kept, 2], self._sigma)
        self._points.append(np.column_stack([points, scan.times[good]])[kept])
        self._count += int(np.count_nonzero(kept))

    def heights(self, like: HeightField) -> HeightField | None:
        """The structure over the cells of *like*; None where none was seen."""
        points = self._before + self._points
        if not points:
            return None
        field = rebuilt(_latest(np.concatenate(points), like), like)
        max_gap = round(_GAP / like.cell)
        return HeightField(field.low, field.cell, _bridged(_bridged(field.heights, max_gap).T, max_gap).T.copy())


def _latest(points: Array, like: HeightField) -> Array:
    """Of *points* (k, 4) those of the last seconds in which each cell of *like* was seen, (j, 3)."""
    points = points[like.holds(points)]
    cells = like.cells_of(points) @ np.array([like.shape[1], 1])
    last = np.full(like.heights.size, -np.inf)
    np.maximum.at(last, cells, points[:, 3])
    return np.asarray(points[points[:, 3] >= last[cells] - _LATEST, :3])


def _bridged(heights: Array, max_gap: int) -> Array:
    """*heights* (a, b) with gaps of up to *max_gap* cells along the second axis interpolated linearly."""
    made = heights.copy()
    for row in made:
        known = np.flatnonzero(np.isfinite(row))
        for k in np.flatnonzero((np.diff(known) > 1) & (np.diff(known) <= max_gap + 1)):
            first, last = known[k], known[k + 1]
            row[first : last + 1] = np.linspace(row[first], row[last], last - first + 1)
    return made


def _lift(heights: Array, sigma: float) -> float:
    """How much a scan's *heights* (k,), m, are to be raised so that nothing lies lower than noise has the floor.

    Where the scan runs along a ridge, the estimation takes that for floor, and the floor beyond is too low.
    """
    if not len(heights):
        return 0.0
    low = float(np.quantile(heights, 0.1)) + 1.28 * sigma  # where a tenth of the noise is lower
    return -low if low < -2.0 * sigma else 0.0


def _hanging_together(ranges: Array) -> NDArray[np.bool_]:
    """(k,) whether a ray goes about as far as one beside it."""
    near = np.abs(np.diff(ranges)) <= _NOISE
    return np.asarray(np.append(near, False) | np.append(False, near))


def _turned(points: Array, rotations: Array) -> Array:
    """Points (k, 3) turned by rotation vectors (k, 3), rad: Rodrigues' formula."""
    angle = np.linalg.norm(rotations, axis=1, keepdims=True)
    sine = np.sinc(angle / np.pi)
    cosine = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    once = np.cross(rotations, points)
    return np.asarray(points + sine * once + cosine * np.cross(rotations, once))


@dataclass(frozen=True, eq=False)
class CrossSection:
    """Heights across the path at one place of it; NaN where not known. Positive offsets are left of the path."""

    title: str
    distance: float  # m along the path
    place: tuple[float, float]  # m, world
    offsets: Array  # (k,) m
    true: Array  # (k,) m
    estimated: Array  # (k,) m


@dataclass(frozen=True)
class HeightDifference:
    """How like the rebuilt structure is to the true one, over cells that were seen: rebuilt less true."""

    mean: float  # m
    rms: float  # m
    max: float  # m, the largest in size
    on_structure: float  # m, rms where the true one is over 5 mm high
    share_seen: float  # share of the cells with structure that were seen


@dataclass(frozen=True, eq=False)
class PrintedStructure:
    """What lies at the end: as rebuilt from scans, and truly. Either may be missing."""

    estimated: HeightField | None
    true: HeightField | None
    density: float  # kg/m^3
    difference: HeightDifference | None
    sections: tuple[CrossSection, ...]

    @property
    def best(self) -> HeightField | None:
        """The true one where it is known."""
        return self.true if self.true is not None else self.estimated

    @property
    def mass(self) -> float:
        """What truly lies, kg; NaN where not known."""
        return math.nan if self.true is None else self.true.volume * self.density

    @property
    def estimated_mass(self) -> float:
        """What lies by the scans, kg, of cells over 5 mm high: lower may be noise; NaN where none was seen."""
        if self.estimated is None:
            return math.nan
        heights = self.estimated.heights
        return float(heights[heights > _NOTHING].sum()) * self.estimated.cell**2 * self.density

    @property
    def highest(self) -> float:
        """m; NaN where nothing is known."""
        return math.nan if self.best is None else float(np.nanmax(self.best.heights, initial=-np.inf))


def structure_of(
    scans: StructureScans | None, true: HeightField | None, track: Track, distance: float, density: float
) -> PrintedStructure | None:
    """What is known of the structure after *distance* (m) of *track*; None where nothing is."""
    seen = None if scans is None else scans.heights(_cells(track, true))
    if seen is None and true is None:
        return None
    likeness = None if seen is None or true is None else _likeness(seen, true)
    return PrintedStructure(seen, true, density, likeness, _cuts(track, distance, seen, true))


def _cells(track: Track, true: HeightField | None) -> HeightField:
    """The cells about the path: those of the *true* field where there is one, so that they can be compared."""
    low = track.positions[:, :2].min(axis=0) - _MARGIN
    high = track.positions[:, :2].max(axis=0) + _MARGIN
    if true is None:
        return HeightField.flat((low[0], low[1]), (high[0], high[1]), CELL)
    first = np.maximum(true.cells_of(low[None])[0], 0)
    last = np.minimum(true.cells_of(high[None])[0] + 1, true.shape)
    corner = (true.low[0] + true.cell * first[0], true.low[1] + true.cell * first[1])
    return HeightField(corner, true.cell, np.zeros(np.maximum(last - first, 1)))


def _likeness(seen: HeightField, true: HeightField) -> HeightDifference:
    x, y = np.meshgrid(seen.centres(0), seen.centres(1), indexing="ij")
    there = true.at(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(seen.shape)
    off = seen.heights - there
    known = np.isfinite(off)
    heap = there > _NOTHING
    if not known.any():
        return HeightDifference(*(math.nan,) * 4, share_seen=0.0)
    on = off[known & heap]
    return HeightDifference(
        float(off[known].mean()),
        _rms(off[known]),
        float(np.abs(off[known]).max()),
        _rms(on) if len(on) else math.nan,
        float(np.count_nonzero(known & heap)) / max(1, int(np.count_nonzero(heap))),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _cuts(
    track: Track, distance: float, seen: HeightField | None, true: HeightField | None
) -> tuple[CrossSection, ...]:
    """Across the path where it is farthest from its other passes in a layer, and where the structure is highest."""
    best = true if true is not None else seen
    assert best is not None  # asked for where there is one
    begin, end = _layer(track, distance)
    along = np.linspace(begin, end, max(2, min(600, int((end - begin) / 0.05))))
    places = track.places(along)[:, :2]
    gap = np.abs(along[:, None] - along)
    gap = np.minimum(gap, np.where(_closed(places), end - begin - gap, np.inf))
    away = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    remote = np.where(gap > _APART, away, np.inf).min(axis=1)
    finite = np.where(np.isfinite(remote), remote, -1.0)
    laid = track.laying[track.pieces(along)]
    finite = np.where(laid, finite, -1.0)
    heights = np.where(laid, np.nan_to_num(best.at(places), nan=-1e9), -np.inf)
    chosen = {"where the path passes once": int(finite.argmax()), "where it is highest": int(heights.argmax())}
    return tuple(_cut(track, title, float(along[i]), seen, true) for title, i in chosen.items())


def _layer(track: Track, distance: float) -> tuple[float, float]:
    """Begin and end, m, of the last layer that was begun with at least a metre, or of all."""
    layers = np.append(track.visits.begin, track.length)
    begun = np.flatnonzero(layers[:-1] <= max(0.0, distance - _APART))
    last = int(begun[-1]) if len(begun) else 0
    return float(layers[last]), float(layers[last + 1])


def _closed(places: Array) -> bool:
    return bool(np.hypot(*(places[-1] - places[0])) < _APART)


def _cut(track: Track, title: str, distance: float, seen: HeightField | None, true: HeightField | None) -> CrossSection:
    place = track.at(distance)
    ux, uy = place.tangent[:2] / max(float(np.hypot(*place.tangent[:2])), 1e-12)
    offsets = np.linspace(-_CUT, _CUT, 201)
    points = place.position[:2] + offsets[:, None] * np.array([-uy, ux])
    nothing = np.full(len(offsets), np.nan)
    true_heights = nothing if true is None else true.at(points)
    seen_heights = nothing if seen is None else _nearest_cells(seen, points)
    x, y = place.position[:2].tolist()
    return CrossSection(title, distance, (x, y), offsets, true_heights, seen_heights)


def _nearest_cells(field: HeightField, points: Array) -> Array:
    """Heights of the cells in which *points* (k, 2) are; linear between cells would lose those beside unknown ones."""
    inside = field.holds(points)
    found = np.full(len(points), np.nan)
    i, j = field.cells_of(points[inside]).T
    found[inside] = field.heights[i, j]
    return found
