"""Volume and surface of the region of a box where a function is at least zero, on a lattice refined along the surface.

A cell is split where its corners differ in sign. A neighbour of a split cell is split too where the surface continues
into it, so that the surface on the finest lattice is closed. Random points in the cells of the first lattice look for
parts and holes that its corners miss; cells where they find some are split too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.workspace.marching import BITS, CORNERS, FACES, crossings, index_of, key_of
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.triangle_mesh import TriangleMesh

Keys = NDArray[np.int64]
Margin = Callable[[Array, str], Array]  # (N,) at places (N, 3), m, and the name of the stage; at least 0 is inside

NODES = (3, 400)  # smallest and largest number along a side
TOLERANCE = 2e-3
TOLERANCES = (1e-5, 0.5)
FIRST = 16  # cells of the first lattice along the longest side of the box
MIN_CELLS = 4  # along any side
MAX_LEVEL = 8  # halvings of the first lattice
MAX_PLACES = 20_000_000
MAX_PLACES_THIN = 2_000_000  # while the error exceeds half of the volume: the region may have no thickness
PROBES = (4096, 400_000)  # smallest and largest number of random points
PROBES_IF_EMPTY = 50_000  # random points where the first lattice is empty
UNSEEN = 3.0  # expected number of hits for which there is none in one of 20 runs
CLOSE = 0.1  # ratio to the smaller value at the ends of an edge below which the crossing is interpolated
SHORTEST = 1.0 / 256.0  # of an edge: length of a bracket that is not bisected further
SHORT = 1.0 / 16.0  # of an edge: the same of a function of which only the sign is known
STEPS = 12  # of bracketing
KINKED = 4  # steps after which a crossing that no value came close to is looked for by bisection alone
MIN_FIRST_ERROR = 4e-3  # of the volume, after the first split: twice the error of compact bodies then
HELD_OFF = 1e-4  # of an edge: smallest distance of a crossing from a node, so that no two crossings coincide


@dataclass(frozen=True, eq=False)
class SearchBox:
    """The box of the world that is searched, m."""

    low: Array  # (3,)
    high: Array  # (3,)

    @property
    def corners(self) -> tuple[Array, Array]:
        """The lowest and the highest corner of the box, m."""
        return self.low, self.high

    @property
    def is_flat(self) -> bool:
        """Whether the box is a rectangle: its ends along one axis are equal."""
        return bool((self.low == self.high).any())

    @property
    def flat_axis(self) -> int:
        """Index of the axis along which the box is shortest; for a flat box, the axis across it."""
        return int((self.high - self.low).argmin())

    @property
    def volume(self) -> float:
        """Volume of the box, m^3."""
        return float(np.prod(self.high - self.low))

    def at(self, shares: Array) -> Array:
        """Return positions (..., 3), m, at *shares* (..., 3) of the box's sides; the rounding is symmetric too."""
        return np.asarray((1.0 - shares) * self.low + shares * self.high)

    def axes(self, counts: tuple[int, ...]) -> tuple[Array, Array, Array]:
        """Return coordinates of *counts* (3,) evenly spaced nodes along x, y, z, sides included, m."""
        x, y, z = (self.at(np.arange(n)[:, None] / (n - 1))[:, axis] for axis, n in enumerate(counts))
        return x, y, z

    def grid(self, counts: tuple[int, ...]) -> Array:
        """Return the positions (X, Y, Z, 3), m, of lattice nodes."""
        return np.stack(np.meshgrid(*self.axes(counts), indexing="ij"), axis=-1)


@dataclass(frozen=True, eq=False)
class Refined:
    """The surface around the inside of a workspace, and the error of its volume."""

    mesh: TriangleMesh
    error: float  # m^3
    unseen: float  # m^3, part of `error`: random points find larger missed parts in 19 of 20 runs
    places: int  # number of evaluations of the function
    cells: tuple[int, int, int]  # of the finest lattice along the sides
    converged: bool  # whether the error is at most the tolerance


@dataclass(frozen=True)
class RefinementSettings:
    """Settings of a refinement: when it is fine enough, and the seed of its random points."""

    tolerance: float = TOLERANCE  # share of the volume
    finest: int | None = None  # cells along the longest side, in place of the tolerance
    seed: int = 0
    continuous: bool = True  # whether the function is; of its mere sign, crossings are bracketed less closely

    @classmethod
    def of(cls, tolerance: float | None, grid: int | None, seed: int) -> RefinementSettings:
        """Return the settings for a *tolerance* or for *grid* nodes along the longest side. Raises `InputError`."""
        if tolerance is not None and grid is not None:
            raise InputError("grid and tolerance: give one of them, not both")
        if tolerance is not None and not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
            low, high = TOLERANCES
            raise InputError(f"tolerance {tolerance:g}: {low:g} to {high:g} of the volume is allowed")
        if seed < 0:
            raise InputError(f"seed {seed}: at least 0 is expected")
        return cls(tolerance or TOLERANCE, None if grid is None else checked_grid(grid) - 1, seed)


def checked_grid(grid: int) -> int:
    """Return the number of nodes along a side. Raises `InputError`."""
    if not NODES[0] <= grid <= NODES[1]:
        raise InputError(f"grid {grid}: {NODES[0]} to {NODES[1]} nodes along a side are allowed")
    return grid


def refine(margin: Margin, box: SearchBox, settings: RefinementSettings) -> Refined:
    """Refine until the error is at most the tolerance times the volume, or to the finest cells.

    The error is that of the surface, see `_surface_error`, plus what random points may have missed. The
    refinement stops without convergence at MAX_LEVEL, where the next lattice would take more than MAX_PLACES (or
    MAX_PLACES_THIN) evaluations, or where the random points alone exceed the tolerance.
    """
    finest, tolerance = settings.finest, settings.tolerance
    lattice = _Lattice(margin, box, _first(box, finest), settings)
    volumes = [lattice.surface().volume]
    lattice.place_probes(None if finest is not None else tolerance * volumes[0])
    while True:
        before = lattice.places
        lattice.split()
        mesh = lattice.surface()
        volumes.append(mesh.volume)
        off, unseen, goal = _surface_error(volumes), lattice.unseen(), tolerance * mesh.volume
        if finest is not None:
            converged = ended = bool(lattice.cells.max() >= finest)
        else:
            converged = off + unseen <= goal or (len(volumes) > 2 and not mesh.vertices.size)
            thin = off + unseen > 0.5 * mesh.volume
            too_many = lattice.places + 4 * (lattice.places - before) > (MAX_PLACES_THIN if thin else MAX_PLACES)
            hopeless = len(volumes) > 2 and 10.0 * off < lattice.min_unseen > goal
            ended = converged or too_many or hopeless or lattice.level >= MAX_LEVEL
        if ended:
            return Refined(mesh, off + unseen, unseen, lattice.places, _three(lattice.cells), converged)


def _surface_error(volumes: list[float]) -> float:
    """Error of the last of *volumes*, m^3: its last change or, if larger, a quarter of the change before.

    The change falls fourfold with each lattice, so that the error is about a third of it. A first change may be small
    by chance: it counts twice, and as at least `MIN_FIRST_ERROR`. An error over half of the volume is set to at least
    the whole volume: the region may be empty.
    """
    volume = volumes[-1]
    *before, last = np.abs(np.diff(volumes)).tolist()
    error = float(max(last, 0.25 * before[-1]) if before else max(2.0 * last, MIN_FIRST_ERROR * volume))
    return max(error, volume) if error > 0.5 * volume else error


def _three(numbers: NDArray[np.int64]) -> tuple[int, int, int]:
    x, y, z = (int(number) for number in numbers)
    return x, y, z


def _first(box: SearchBox, finest: int | None) -> NDArray[np.int64]:
    """(3,) cells of the first lattice along the sides; even, so that the middle of the box is a node."""
    along = FIRST
    if finest is not None:
        halvings = max(2, int(np.ceil(np.log2(finest / FIRST))))
        along = max(MIN_CELLS, 2 * int(np.ceil(0.5 * finest / 2**halvings)))
    sides = box.high - box.low
    counts = np.ceil(along * sides / sides.max() - 1e-9).astype(np.int64)
    return np.asarray(np.maximum(MIN_CELLS, counts + counts % 2))


class _Lattice:
    """The cells near the surface and the function at their nodes.

    The box is surrounded by one layer of cells, whose outer nodes count as outside.
    """

    def __init__(self, margin: Margin, box: SearchBox, first: NDArray[np.int64], settings: RefinementSettings) -> None:
        self.continuous = settings.continuous
        self.margin, self.box, self.first = margin, box, first
        self.all_cells: Keys
        self.inside: Mask  # (K, 8) corners of all cells
        self.mixed: Mask  # (K,)
        self.level, self.places, self.seed = 0, 0, settings.seed
        grid = np.stack(np.meshgrid(*(np.arange(n + 2) for n in first), indexing="ij"), axis=-1)
        self.nodes, self.values = np.empty(0, dtype=np.int64), np.empty(0)
        self._take(np.sort(key_of(grid.reshape(-1, 3))))
        self.probes = np.empty((0, 3))
        self.probe_signs = np.empty(0, dtype=bool)
        self.tracked = np.empty(0, dtype=np.int64)

    @property
    def cells(self) -> NDArray[np.int64]:
        """Number (3,) of cells along the sides."""
        return np.asarray(self.first << self.level)

    @property
    def crossed(self) -> Keys:
        """Keys of the cells crossed by the surface."""
        return np.asarray(self.all_cells[self.mixed])

    def _take(self, cells: Keys) -> None:
        """Evaluate the function in *cells* (sorted keys) and in all neighbours into which the surface continues."""
        self.all_cells, self.inside, self.mixed = cells[:0], np.empty((0, 8), dtype=bool), np.empty(0, dtype=bool)
        while len(cells):
            corners = cells[:, None] + CORNERS
            self._evaluate(np.unique(corners))
            inside = self.values[np.searchsorted(self.nodes, corners)] >= 0.0
            order = np.argsort(np.concatenate([self.all_cells, cells]), kind="stable")
            new = order >= len(self.all_cells)
            self.all_cells = np.concatenate([self.all_cells, cells])[order]
            self.inside = np.concatenate([self.inside, inside])[order]
            self.mixed = np.concatenate([self.mixed, _differ(inside)])[order]
            cells = self._beyond(np.flatnonzero(new & self.mixed))

    def _beyond(self, rows: NDArray[np.int64]) -> Keys:
        """Keys of the unknown neighbours of the cells at *rows* across faces that the surface crosses."""
        steps = [1 << 2 * BITS, 1 << BITS, 1]
        found = []
        for axis, side, corners in FACES:
            face = self.inside[rows][:, corners]
            through = _differ(face)
            found.append(self.all_cells[rows[through]] + (steps[axis] if side else -steps[axis]))
        keys = np.unique(np.concatenate(found))
        return keys[~_among(keys, self.all_cells)]

    def _evaluate(self, keys: Keys) -> None:
        """Evaluate the nodes with sorted *keys* that are not known yet."""
        new = keys[~_among(keys, self.nodes)]
        shares, within = self._shares(new)
        values = np.full(len(new), -np.inf)
        values[within] = self._margin(self.box.at(shares[within]), f"lattice of {self.cells.max()} cells")
        order = np.argsort(np.concatenate([self.nodes, new]), kind="stable")
        self.nodes = np.concatenate([self.nodes, new])[order]
        self.values = np.concatenate([self.values, values])[order]

    def _shares(self, keys: Keys) -> tuple[Array, Mask]:
        """Positions (N, 3) of nodes as shares of the box's sides, and whether they are in the box (N,)."""
        index = index_of(keys) - (1 << self.level)
        within = np.all((index >= 0) & (index <= self.cells), axis=1)
        return index / self.cells, within

    def _margin(self, places: Array, purpose: str) -> Array:
        self.places += len(places)
        values = self.margin(places, purpose) if len(places) else np.empty(0)
        return np.where(np.isnan(values), -np.inf, values)

    def split(self) -> None:
        """Halve the cells that the surface crosses, or where a random point contradicts the corners of its cell."""
        self._track()
        parents = np.union1d(self.crossed, self._probe_cells(self.tracked))
        keep = np.unique(self.crossed[:, None] + CORNERS)
        known = np.searchsorted(self.nodes, keep)
        self.nodes, self.values = 2 * keep, self.values[known]
        self.level += 1
        self._take(np.sort((2 * parents[:, None] + CORNERS).ravel()))

    def place_probes(self, goal: float | None) -> None:
        """Evaluate random points, equally many in each cell: enough for an error of *goal* (m^3), few if None."""
        cells = int(np.prod(self.first))
        wanted = 8.0 * cells
        if goal is not None:
            wanted = 4.0 * UNSEEN * self.box.volume / goal if goal else PROBES_IF_EMPTY
        each = int(np.ceil(np.clip(wanted, *PROBES) / cells))
        index = np.stack(np.meshgrid(*(np.arange(n) for n in self.first), indexing="ij"), axis=-1).reshape(-1, 3)
        jitter = np.random.default_rng(self.seed).random((each, cells, 3))
        self.probes = ((index + jitter) / self.first).reshape(-1, 3)
        self.probe_signs = self._margin(self.box.at(self.probes), "random points") >= 0.0
        self.tracked = np.arange(len(self.probes))

    @property
    def min_unseen(self) -> float:
        """Lower bound of `unseen` on any lattice, m^3."""
        return UNSEEN / len(self.probes) * self.box.volume

    def _probe_cells(self, rows: NDArray[np.int64]) -> Keys:
        return key_of(np.floor(self.probes[rows] * self.cells).astype(np.int64) + (1 << self.level))

    def _track(self) -> None:
        """Keep the random points that are in crossed cells, or contradict all corners of their cell."""
        cells = self._probe_cells(self.tracked)
        at = np.minimum(np.searchsorted(self.all_cells, cells), len(self.all_cells) - 1)
        contradicted = self.inside[at, 0] != self.probe_signs[self.tracked]
        self.tracked = self.tracked[self.mixed[at] | contradicted]

    def unseen(self) -> float:
        """Upper bound, in 19 of 20 runs, of the volume of parts and holes that were missed, m^3."""
        cells = self._probe_cells(self.tracked)
        at = np.searchsorted(self.all_cells, cells)
        against = int((~self.mixed[at] & (self.inside[at, 0] != self.probe_signs[self.tracked])).sum())
        return self.min_unseen * (1.0 + (against + 2.0 * float(np.sqrt(against))) / UNSEEN)

    def surface(self) -> TriangleMesh:
        """Return the closed surface on this lattice."""
        keys, within, without, triangles = crossings(self.crossed, self.inside[self.mixed])
        shares, _ = self._shares(within)
        beyond, in_box = self._shares(without)
        share = self._cross(shares, beyond, in_box, within, without)
        ends = shares + share[:, None] * (beyond - shares)
        names = np.where(in_box, keys, 8 * within)  # at a side of the box the surface passes through its nodes
        _, first, numbers = np.unique(names, return_index=True, return_inverse=True)
        triangles = numbers[triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        used, numbers = np.unique(triangles, return_inverse=True)
        return TriangleMesh(self.box.at(ends[first][used]), numbers.reshape(-1, 3).astype(np.int64))

    def _cross(self, inner: Array, outer: Array, in_box: Mask, within: Keys, without: Keys) -> Array:
        """Crossings of edges by the surface: shares (E,) of the way from inside to outside; 0 at a side of the box."""
        found = np.zeros(len(inner))
        rows = np.flatnonzero(in_box)
        start, way = inner[rows], outer[rows] - inner[rows]
        near, far = (self.values[np.searchsorted(self.nodes, keys[rows])] for keys in (within, without))
        enough, shortest = CLOSE * np.minimum(near, -far), SHORTEST if self.continuous else SHORT
        low, high, known = np.zeros(len(rows)), np.ones(len(rows)), np.zeros(len(rows), dtype=bool)
        active = np.arange(len(rows))
        for step in range(STEPS):
            share = np.clip(_between(near[active], far[active]), 0.1, 0.9)
            share = np.full(len(active), 0.5) if step % 2 or step > KINKED else share
            at = low[active] + share * (high[active] - low[active])
            places = self.box.at(start[active] + at[:, None] * way[active])
            values = self._margin(places, f"surface in {self.cells.max()} cells, step {step + 1}")
            good = values >= 0.0
            low[active[good]], near[active[good]] = at[good], values[good]
            high[active[~good]], far[active[~good]] = at[~good], values[~good]
            known[active] = np.abs(values) <= enough[active]
            active = active[~known[active] & (high[active] - low[active] > shortest)]
            if not len(active):
                break
        share = np.where(known, _between(near, far), 0.5)  # a function that bends or jumps there says no more
        found[rows] = np.clip(low + (high - low) * share, HELD_OFF, 1.0 - HELD_OFF)
        return found


def _between(near: Array, far: Array) -> Array:
    """The zero of the straight line between two values as a share; 0.5 if one is infinite."""
    span = near - far
    usable = np.isfinite(span)
    return np.where(usable, np.where(usable, near, 0.5) / np.where(usable, span, 1.0), 0.5)


def _differ(flags: Mask) -> Mask:
    """(N,) whether the flags (N, c) of a row differ."""
    return np.asarray(flags.any(axis=1) & ~flags.all(axis=1))


def _among(keys: Keys, known: Keys) -> Mask:
    """Whether each of *keys* is among the sorted *known* ones."""
    if not len(known):
        return np.zeros(len(keys), dtype=bool)
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.asarray(known[at] == keys)
