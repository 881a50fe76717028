"""The printed structure, reconstructed from scans of the vertical lidar, and the true structure if it is known.

Merlet and Papegay 2023, III.A: one scan of the vertical lidar every 2 s, each ray placed by the estimated pose of the
platform. The structure grows while it is scanned: the scans of the last two layers are kept, and in each cell only
those of the last seconds count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.signals import Estimate, Scan
from cablewright.foundation.units import spell_length
from cablewright.live.error_statistics import spread
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.models.rotation import matrices
from cablewright.printing.arc_length_path import Track
from cablewright.printing.beads import Bead
from cablewright.printing.heightfield import HeightField, rebuilt

CELL: Final = 0.02
"""Cell size of the reconstruction, m."""

EVERY: Final = 2.0
"""s between two scans that are used: the paper's."""

CELLS_PER_BEAD: Final = 3.0
"""Cells across a bead for its height to show."""

_SEEN: Final = 0.9  # share of the mass under which a note says so
_MARGIN: Final = 0.6  # m around the path that is reconstructed
_CONE: Final = math.radians(70.0)  # half angle about the drum's axis; beyond it rays graze
_NOISE: Final = 0.05  # m below the floor, or from both neighbours, of a point that is an outlier
_HISTORY_LENGTH: Final = 1000  # rows of the drum's poses
_MAX_POINTS: Final = 2_000_000  # of one layer
_MAX_GAP: Final = 0.1  # m between two scans that is interpolated: they are 6 cm apart at 3 cm/s
_RECENT_TIME: Final = 8.0  # s, of the scans that count in a cell
_MIN_HEIGHT: Final = 5e-3  # m, of structure; lower may be noise
_SECTION_WIDTH: Final = 0.5  # m, half width of a section
_MIN_SEPARATION: Final = 1.0  # m along the path between two different passes


class StructureScans:
    """Collects points of the vertical lidar, layer by layer."""

    def __init__(self, lidar: LidarSettings, track: Track) -> None:
        """For one *lidar* on a drum that follows *track*."""
        self._place, self._axes = np.array(lidar.place), np.array(lidar.axes)
        self._sigma = lidar.deviation
        self._track = track
        self._poses = TimeBuffer(6, _HISTORY_LENGTH)
        self._last, self._visit = -math.inf, -1
        self._points: list[Array] = []  # (k, 4) each: place, m, and time, s
        self._before: list[Array] = []
        self._count = 0

    def set_pose(self, estimate: Estimate, distance: float) -> None:
        """Record the estimated pose of the platform, *distance* (m) along the path."""
        if estimate.valid and np.isfinite(estimate.position).all() and np.isfinite(estimate.rotation).all():
            self._poses.add(estimate.time, np.concatenate([estimate.position, estimate.rotation]))
        visit = int(np.searchsorted(self._track.visits.begin, distance, side="right")) - 1
        if visit > self._visit:
            self._before, self._points, self._count, self._visit = self._points, [], 0, visit

    def add(self, scan: Scan) -> None:
        """Add one scan of the vertical lidar."""
        if scan.time - self._last < EVERY - 1e-6 or not len(self._poses) or self._count >= _MAX_POINTS:
            return
        self._last = scan.time
        angles = scan.angles
        good = np.isfinite(scan.ranges) & (np.abs(angles) <= _CONE)
        where = self._poses.at(scan.times[good])
        x, y = self._axes
        rays = np.cos(angles[good])[:, None] * x + np.sin(angles[good])[:, None] * y
        arms = self._place + scan.ranges[good, None] * rays
        points = where[:, :3] + (matrices(where[:, 3:]) @ arms[..., None])[..., 0]
        near = np.abs(np.diff(scan.ranges[good])) <= _NOISE
        kept = (np.append(near, False) | np.append(False, near)) & (points[:, 2] > -_NOISE)
        points[:, 2] += _floor_correction(points[kept, 2], self._sigma)
        self._points.append(np.column_stack([points, scan.times[good]])[kept])
        self._count += int(np.count_nonzero(kept))

    def heights(self, like: HeightField) -> HeightField | None:
        """Return the heights of the structure over the cells of *like*; None if none was scanned."""
        points = self._before + self._points
        if not points:
            return None
        field = rebuilt(_latest_points(np.concatenate(points), like), like)
        max_gap = round(_MAX_GAP / like.cell)
        return HeightField(
            field.low, field.cell, _interpolated(_interpolated(field.heights, max_gap).T, max_gap).T.copy()
        )


def _latest_points(points: Array, like: HeightField) -> Array:
    """Return those (j, 3) of *points* (k, 4) from the last seconds in which each cell of *like* was scanned."""
    points = points[like.holds(points)]
    cells = like.cells_of(points) @ np.array([like.shape[1], 1])
    last = np.full(like.heights.size, -np.inf)
    np.maximum.at(last, cells, points[:, 3])
    return np.asarray(points[points[:, 3] >= last[cells] - _RECENT_TIME, :3])


def _interpolated(heights: Array, max_gap: int) -> Array:
    """*heights* (a, b) with gaps of up to *max_gap* cells along the second axis interpolated linearly."""
    filled = heights.copy()
    for row in filled:
        known = np.flatnonzero(np.isfinite(row))
        for k in np.flatnonzero((np.diff(known) > 1) & (np.diff(known) <= max_gap + 1)):
            first, last = known[k], known[k + 1]
            row[first : last + 1] = np.linspace(row[first], row[last], last - first + 1)
    return filled


def _floor_correction(heights: Array, sigma: float) -> float:
    """Correction, m, of a scan's *heights* (k,), m, so that they are below the floor by no more than noise.

    If a scan runs along a ridge, the estimator may mistake the ridge for the floor; the true floor then is too low.
    """
    if not len(heights):
        return 0.0
    low = float(np.quantile(heights, 0.1)) + 1.28 * sigma  # a tenth of the noise is lower
    return -low if low < -2.0 * sigma else 0.0


@dataclass(frozen=True, eq=False)
class CrossSection:
    """Heights across the path at one position; NaN: unknown. Positive offsets are left of the path."""

    title: str
    distance: float  # m along the path
    place: tuple[float, float]  # m, world
    offsets: Array  # (k,) m
    true: Array  # (k,) m
    estimated: Array  # (k,) m


@dataclass(frozen=True)
class HeightDifference:
    """Reconstructed heights less true ones, over the scanned cells."""

    mean: float  # m
    rms: float  # m
    max: float  # m, largest absolute value
    on_structure: float  # m, rms where the true height is over 5 mm
    share_seen: float  # of the cells with structure


@dataclass(frozen=True, eq=False, repr=False)
class PrintedStructure(Result):
    """The structure at the end of a print, reconstructed from scans and true. One of the two may be missing."""

    FIGURES: ClassVar = (
        Figure("mass", "kg", "True mass of the structure; null where it is not known.", name="mass of the structure"),
        Figure("volume", "m^3", "True volume; null where it is not known.", lambda of: of.mass / of.density,
               detail=True),
        Figure("estimated_mass", "kg", "Mass by the scans, where it is over 5 mm high; null without scans.",
               name="mass by the scans, where over 5 mm high"),
        Figure("mass_seen", "1", "Mass by the scans as a share of the true one; null where one is not known.",
               name="mass seen by the scans", shown="%", digits=3),
        Figure("estimated_volume", "m^3", "Volume by the scans, where it is over 5 mm high; null without scans.",
               lambda of: of.estimated_mass / of.density, detail=True),
        Figure("density", "kg/m^3", "Density of the laid material.", detail=True),
        Figure("max_height", "m", "Largest height; the true one where it is known.", "highest"),
        Figure("mean_difference", "m", "Mean of the height by the scans less the true one; null where one of them is "
               "not known.", "difference.mean", "mean height difference, scans less true"),
        Figure("rms_difference", "m", "Root mean square of that difference.", "difference.rms",
               "rms height difference"),
        Figure("max_difference", "m", "Largest size of that difference.", "difference.max",
               "largest height difference"),
        Figure("rms_difference_on_structure", "m", "Root mean square of it where the structure is over 5 mm high.",
               "difference.on_structure", "rms height difference on the structure"),
        Figure("share_seen", "1", "Share of the structure's cells that the scans saw.", "difference.share_seen",
               "seen by the scans", 3, shown="%"),
    )  # fmt: skip

    estimated: HeightField | None
    true: HeightField | None
    density: float  # kg/m^3
    difference: HeightDifference | None
    sections: tuple[CrossSection, ...]
    bead: Bead | None = None  # that the machine extrudes; None: it pours powder

    @property
    def best(self) -> HeightField | None:
        """The true structure if known, else the reconstructed one."""
        return self.true if self.true is not None else self.estimated

    @property
    def mass(self) -> float:
        """True mass of the structure, kg; NaN: unknown."""
        return math.nan if self.true is None else self.true.volume * self.density

    @property
    def estimated_mass(self) -> float:
        """Mass by the scans, kg, of cells over 5 mm high; NaN without scans."""
        if self.estimated is None:
            return math.nan
        heights = self.estimated.heights
        return float(heights[heights > _MIN_HEIGHT].sum()) * self.estimated.cell**2 * self.density

    @property
    def mass_seen(self) -> float:
        """Mass by the scans as a share of the true one; NaN where one is not known, or nothing is laid."""
        return self.estimated_mass / self.mass if self.mass > 0.0 else math.nan

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on parts that the scans or the cells do not cover."""
        notes = []
        if self.mass_seen < _SEEN:
            notes.append(
                f"the scans saw {self.estimated_mass:.3g} of {self.mass:.3g} kg that were laid: "
                f"{100.0 * self.mass_seen:.0f} %, where the structure is over {_MIN_HEIGHT * 1e3:g} mm high"
            )
        best = self.best
        if best is not None and self.bead is not None and self.bead.width < CELLS_PER_BEAD * best.cell:
            notes.append(
                f"beads are {spell_length(self.bead.width)} wide, cells of the height field "
                f"{spell_length(best.cell)}: heights are means over cells, lower than the beads"
            )
        return tuple(notes)

    @property
    def highest(self) -> float:
        """Greatest height of the structure, m; NaN: unknown."""
        return math.nan if self.best is None else float(np.nanmax(self.best.heights, initial=-np.inf))


def structure_of(
    scans: StructureScans | None,
    true: HeightField | None,
    track: Track,
    distance: float,
    density: float,
    bead: Bead | None,
) -> PrintedStructure | None:
    """Return the printed structure after *distance* (m) of *track*, of *density* (kg/m^3); None if nothing is known."""
    estimated = None if scans is None else scans.heights(_cells(track, true))
    if estimated is None and true is None:
        return None
    difference = None if estimated is None or true is None else _difference(estimated, true)
    return PrintedStructure(estimated, true, density, difference, _sections(track, distance, estimated, true), bead)


def _cells(track: Track, true: HeightField | None) -> HeightField:
    """Empty cells around the path: those of the *true* field if given, so that they can be compared."""
    low = track.positions[:, :2].min(axis=0) - _MARGIN
    high = track.positions[:, :2].max(axis=0) + _MARGIN
    if true is None:
        return HeightField.flat((low[0], low[1]), (high[0], high[1]), CELL)
    first = np.maximum(true.cells_of(low[None])[0], 0)
    last = np.minimum(true.cells_of(high[None])[0] + 1, true.shape)
    corner = (true.low[0] + true.cell * first[0], true.low[1] + true.cell * first[1])
    return HeightField(corner, true.cell, np.zeros(np.maximum(last - first, 1)))


def _difference(estimated: HeightField, true: HeightField) -> HeightDifference:
    x, y = np.meshgrid(estimated.centres(0), estimated.centres(1), indexing="ij")
    there = true.at(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(estimated.shape)
    off, structure = estimated.heights - there, there > _MIN_HEIGHT
    known = np.isfinite(off)
    if not known.any():
        return HeightDifference(*(math.nan,) * 4, share_seen=0.0)
    all_cells, on_structure = spread(off), spread(off[structure])
    seen = on_structure.count / max(1, int(np.count_nonzero(structure)))
    return HeightDifference(float(off[known].mean()), all_cells.rms, all_cells.max, on_structure.rms, seen)


def _sections(
    track: Track, distance: float, estimated: HeightField | None, true: HeightField | None
) -> tuple[CrossSection, ...]:
    """Sections where the path is farthest from its other passes in a layer, and where the structure is highest."""
    best = true if true is not None else estimated
    assert best is not None  # `structure_of` requires one of the two
    begin, end = _layer(track, distance)
    along = np.linspace(begin, end, max(2, min(600, int((end - begin) / 0.05))))
    places = track.places(along)[:, :2]
    gap = np.abs(along[:, None] - along)
    if np.hypot(*(places[-1] - places[0])) < _MIN_SEPARATION:  # the layer's path is closed
        gap = np.minimum(gap, end - begin - gap)
    away = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    remote = np.where(gap > _MIN_SEPARATION, away, np.inf).min(axis=1)
    laid = track.laying[track.pieces(along)]
    remote = np.where(laid & np.isfinite(remote), remote, -1.0)
    heights = np.where(laid, np.nan_to_num(best.at(places), nan=-1e9), -np.inf)
    chosen = {"where the path passes once": int(remote.argmax()), "where it is highest": int(heights.argmax())}
    return tuple(_section(track, title, float(along[i]), estimated, true) for title, i in chosen.items())


def _layer(track: Track, distance: float) -> tuple[float, float]:
    """Start and end, m, of the last layer of which at least a metre is printed."""
    layers = np.append(track.visits.begin, track.length)
    begun = np.flatnonzero(layers[:-1] <= max(0.0, distance - _MIN_SEPARATION))
    last = int(begun[-1]) if len(begun) else 0
    return float(layers[last]), float(layers[last + 1])


def _section(
    track: Track, title: str, distance: float, estimated: HeightField | None, true: HeightField | None
) -> CrossSection:
    place = track.at(distance)
    ux, uy = place.tangent[:2] / max(float(np.hypot(*place.tangent[:2])), 1e-12)
    offsets = np.linspace(-_SECTION_WIDTH, _SECTION_WIDTH, 201)
    points = place.position[:2] + offsets[:, None] * np.array([-uy, ux])
    unknown = np.full(len(offsets), np.nan)
    true_heights = unknown if true is None else true.at(points)
    estimated_heights = unknown if estimated is None else _nearest_cells(estimated, points)
    x, y = place.position[:2].tolist()
    return CrossSection(title, distance, (x, y), offsets, true_heights, estimated_heights)


def _nearest_cells(field: HeightField, points: Array) -> Array:
    """Heights of the cells of *points* (k, 2); interpolation would lose heights next to unknown cells."""
    inside = field.holds(points)
    found = np.full(len(points), np.nan)
    i, j = field.cells_of(points[inside]).T
    found[inside] = field.heights[i, j]
    return found
