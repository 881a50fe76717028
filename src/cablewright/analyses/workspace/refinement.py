"""Volume and surface of where a function is at least zero in a box, by a lattice that is refined along the surface.

A cell is split where its corners differ in sign. Where a split cell shows that its neighbour is crossed too, that one
is split as well, so that the surface on the finest lattice is closed. Random places in the cells of the first lattice
look for parts and holes that its corners miss; the cells where they find some are split too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.workspace.marching import BITS, CORNERS, FACES, crossings, index_of, key_of
from cablewright.arrays import Array, Mask
from cablewright.triangle_mesh import TriangleMesh

Keys = NDArray[np.int64]
Margin = Callable[[Array, str], Array]  # (N,) of places (N, 3), m, and the name of this stage: at least 0 inside

FIRST = 16  # cells of the first lattice along the longest side of the box
FEWEST = 4  # along any side
FINEST = 8  # halvings of the first lattice
MAX_PLACES = 20_000_000
MAX_PLACES_THIN = 2_000_000  # while the error is over half of the volume: it may have no thickness
PROBES = (4096, 400_000)  # fewest and most random places
PROBES_FOR_NOTHING = 50_000  # where the first lattice has found nothing
UNSEEN = 3.0  # expected number of finds at which nothing is found in one of 20 runs
CLOSE = 0.1  # of the smaller value at the ends of an edge: so near to zero the rest is interpolated
SHORT = 1.0 / 16.0  # of an edge: to which the surface is bracketed
STEPS = 6
DOUBT = 4e-3  # of a volume after the first change: twice the error of compact bodies on a first lattice split once
HELD_OFF = 1e-4  # of an edge: no crossing is nearer to a node, so that no two coincide


@dataclass(frozen=True, eq=False)
class SearchBox:
    """A box in the world, m."""

    low: Array  # (3,)
    high: Array  # (3,)

    @property
    def corners(self) -> tuple[Array, Array]:
        """The lowest and the highest corner, m."""
        return self.low, self.high

    @property
    def volume(self) -> float:
        """m^3."""
        return float(np.prod(self.high - self.low))

    def at(self, shares: Array) -> Array:
        """Places (..., 3) at *shares* (..., 3) of the sides; symmetric in rounding too."""
        return np.asarray((1.0 - shares) * self.low + shares * self.high)

    def axes(self, counts: tuple[int, ...]) -> tuple[Array, Array, Array]:
        """Coordinates of *counts* (3,) evenly spaced nodes along x, y, z, from side to side, m."""
        x, y, z = (self.at(np.arange(n)[:, None] / (n - 1))[:, axis] for axis, n in enumerate(counts))
        return x, y, z

    def grid(self, counts: tuple[int, ...]) -> Array:
        """Places (X, Y, Z, 3), m, of all these nodes."""
        return np.stack(np.meshgrid(*self.axes(counts), indexing="ij"), axis=-1)


@dataclass(frozen=True, eq=False)
class Refined:
    """The surface of what is inside, and how well its volume is known."""

    mesh: TriangleMesh
    error: float  # m^3
    unseen: float  # m^3: of `error`, more than random places would have missed in 19 of 20 runs
    places: int  # at how many the function was evaluated
    cells: tuple[int, int, int]  # of the finest lattice along the sides
    converged: bool  # whether the error is at most the tolerance


def refine(
    margin: Margin, box: SearchBox, *, tolerance: float = 2e-3, finest: int | None = None, seed: int = 0
) -> Refined:
    """Refine until the error is at most *tolerance* of the volume, or to *finest* cells along the longest side.

    The error is that of the surface, see `_surface_error`, and what random places (*seed*) may have missed. Refinement
    ends early, not converged, where a next lattice would take too many places, or would not help: MAX_PLACES,
    MAX_PLACES_THIN, and an error that random places cannot make smaller.
    """
    lattice = _Lattice(margin, box, _first(box, finest), seed)
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
            ended = converged or too_many or hopeless or lattice.level >= FINEST
        if ended:
            return Refined(mesh, off + unseen, unseen, lattice.places, _three(lattice.cells), converged)


def _surface_error(volumes: list[float]) -> float:
    """Error of the last of *volumes*, m^3: its last change or, if larger, a quarter of the one before.

    Where the surface is smooth or has edges the change falls fourfold with each lattice: the error is about a third of
    it. A first change may be small by chance: it counts twice, and as at least `DOUBT`. An error over half of the
    volume is no less than all of it: there may be none.
    """
    volume = volumes[-1]
    *before, last = np.abs(np.diff(volumes)).tolist()
    error = float(max(last, 0.25 * before[-1]) if before else max(2.0 * last, DOUBT * volume))
    return max(error, volume) if error > 0.5 * volume else error


def _three(numbers: NDArray[np.int64]) -> tuple[int, int, int]:
    x, y, z = (int(number) for number in numbers)
    return x, y, z


def _first(box: SearchBox, finest: int | None) -> NDArray[np.int64]:
    """Cells of the first lattice along the sides: even, so that a symmetric box has its middle on it."""
    along = FIRST
    if finest is not None:
        halvings = max(2, int(np.ceil(np.log2(finest / FIRST))))
        along = max(FEWEST, 2 * int(np.ceil(0.5 * finest / 2**halvings)))
    sides = box.high - box.low
    counts = np.ceil(along * sides / sides.max() - 1e-9).astype(np.int64)
    return np.asarray(np.maximum(FEWEST, counts + counts % 2))


class _Lattice:
    """Cells near the surface and the function at their nodes.

    One layer of cells is around the box; their outer nodes count as outside, whatever the function is there.
    """

    def __init__(self, margin: Margin, box: SearchBox, first: NDArray[np.int64], seed: int) -> None:
        self.margin, self.box, self.first = margin, box, first
        self.all_cells: Keys
        self.inside: Mask  # (K, 8) corners of all cells
        self.mixed: Mask  # (K,)
        self.level, self.places, self.seed = 0, 0, seed
        grid = np.stack(np.meshgrid(*(np.arange(n + 2) for n in first), indexing="ij"), axis=-1)
        self.nodes, self.values = np.empty(0, dtype=np.int64), np.empty(0)
        self._take(np.sort(key_of(grid.reshape(-1, 3))))
        self.probes = np.empty((0, 3))
        self.probe_signs = np.empty(0, dtype=bool)
        self.tracked = np.empty(0, dtype=np.int64)

    @property
    def cells(self) -> NDArray[np.int64]:
        """(3,) cells along the sides."""
        return np.asarray(self.first << self.level)

    @property
    def crossed(self) -> Keys:
        """Keys of the cells that the surface crosses."""
        return np.asarray(self.all_cells[self.mixed])

    def _take(self, cells: Keys) -> None:
        """Evaluate the function in *cells*, sorted, and in all neighbours into which the surface continues."""
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
        """Neighbours of cells behind a face that the surface crosses, of those that are not known yet."""
        steps = [1 << 2 * BITS, 1 << BITS, 1]
        found = []
        for axis, side, corners in FACES:
            face = self.inside[rows][:, corners]
            through = _differ(face)
            found.append(self.all_cells[rows[through]] + (steps[axis] if side else -steps[axis]))
        keys = np.unique(np.concatenate(found))
        return keys[~_among(keys, self.all_cells)]

    def _evaluate(self, keys: Keys) -> None:
        """Find the values of the nodes with the sorted *keys* that are not known yet."""
        new = keys[~_among(keys, self.nodes)]
        shares, within = self._shares(new)
        values = np.full(len(new), -np.inf)
        values[within] = self._margin(self.box.at(shares[within]), f"lattice of {self.cells.max()} cells")
        order = np.argsort(np.concatenate([self.nodes, new]), kind="stable")
        self.nodes = np.concatenate([self.nodes, new])[order]
        self.values = np.concatenate([self.values, values])[order]

    def _shares(self, keys: Keys) -> tuple[Array, Mask]:
        """Where nodes are in the box, (N, 3) shares of its sides, and which are in it."""
        index = index_of(keys) - (1 << self.level)
        within = np.all((index >= 0) & (index <= self.cells), axis=1)
        return index / self.cells, within

    def _margin(self, places: Array, purpose: str) -> Array:
        self.places += len(places)
        values = self.margin(places, purpose) if len(places) else np.empty(0)
        return np.where(np.isnan(values), -np.inf, values)

    def split(self) -> None:
        """Halve the cells where the surface is, or where a random place contradicts the corners of its cell."""
        self._track()
        parents = np.union1d(self.crossed, self._probe_cells(self.tracked))
        keep = np.unique(self.crossed[:, None] + CORNERS)
        known = np.searchsorted(self.nodes, keep)
        self.nodes, self.values = 2 * keep, self.values[known]
        self.level += 1
        self._take(np.sort((2 * parents[:, None] + CORNERS).ravel()))

    def place_probes(self, goal: float | None) -> None:
        """Evaluate random places, as many in each cell: enough for an error of *goal* (m^3), a few if None."""
        cells = int(np.prod(self.first))
        wanted = 8.0 * cells
        if goal is not None:
            wanted = 4.0 * UNSEEN * self.box.volume / goal if goal else PROBES_FOR_NOTHING
        each = int(np.ceil(np.clip(wanted, *PROBES) / cells))
        index = np.stack(np.meshgrid(*(np.arange(n) for n in self.first), indexing="ij"), axis=-1).reshape(-1, 3)
        jitter = np.random.default_rng(self.seed).random((each, cells, 3))
        self.probes = ((index + jitter) / self.first).reshape(-1, 3)
        self.probe_signs = self._margin(self.box.at(self.probes), "random places") >= 0.0
        self.tracked = np.arange(len(self.probes))

    @property
    def min_unseen(self) -> float:
        """What `unseen` cannot fall below, however fine the lattice, m^3."""
        return UNSEEN / len(self.probes) * self.box.volume

    def _probe_cells(self, rows: NDArray[np.int64]) -> Keys:
        return key_of(np.floor(self.probes[rows] * self.cells).astype(np.int64) + (1 << self.level))

    def _track(self) -> None:
        """Keep the random places that are in crossed cells, or contradict all corners of their cell."""
        cells = self._probe_cells(self.tracked)
        at = np.minimum(np.searchsorted(self.all_cells, cells), len(self.all_cells) - 1)
        contradicted = self.inside[at, 0] != self.probe_signs[self.tracked]
        self.tracked = self.tracked[self.mixed[at] | contradicted]

    def unseen(self) -> float:
        """Volume, m^3, of parts and holes that were not found: it is larger in one of 20 runs at most."""
        cells = self._probe_cells(self.tracked)
        at = np.searchsorted(self.all_cells, cells)
        against = int((~self.mixed[at] & (self.inside[at, 0] != self.probe_signs[self.tracked])).sum())
        return self.min_unseen * (1.0 + (against + 2.0 * float(np.sqrt(against))) / UNSEEN)

    def surface(self) -> TriangleMesh:
        """The closed surface on this lattice."""
        keys, within, without, triangles = crossings(self.crossed, self.inside[self.mixed])
        shares, _ = self._shares(within)
        beyond, in_box = self._shares(without)
        share = self._cross(shares, beyond, in_box, within, without)
        ends = shares + share[:, None] * (beyond - shares)
        names = np.where(in_box, keys, 8 * within)  # at the box's side the surface goes through the nodes on it
        _, first, numbers = np.unique(names, return_index=True, return_inverse=True)
        triangles = numbers[triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        used, numbers = np.unique(triangles, return_inverse=True)
        return TriangleMesh(self.box.at(ends[first][used]), numbers.reshape(-1, 3).astype(np.int64))

    def _cross(self, inner: Array, outer: Array, in_box: Mask, within: Keys, without: Keys) -> Array:
        """Where the surface crosses edges: shares (E,) of the way from inside to outside; 0 at a side of the box."""
        found = np.zeros(len(inner))
        rows = np.flatnonzero(in_box)
        start, way = inner[rows], outer[rows] - inner[rows]
        near, far = (self.values[np.searchsorted(self.nodes, keys[rows])] for keys in (within, without))
        enough = CLOSE * np.minimum(near, -far)
        low, high = np.zeros(len(rows)), np.ones(len(rows))
        active = np.arange(len(rows))
        for step in range(STEPS):
            share = _between(near[active], far[active])
            share = np.clip(share, 0.1, 0.9) if step % 2 == 0 else np.full(len(active), 0.5)
            at = low[active] + share * (high[active] - low[active])
            places = self.box.at(start[active] + at[:, None] * way[active])
            values = self._margin(places, f"surface in {self.cells.max()} cells, step {step + 1}")
            good = values >= 0.0
            low[active[good]], near[active[good]] = at[good], values[good]
            high[active[~good]], far[active[~good]] = at[~good], values[~good]
            active = active[(np.abs(values) > enough[active]) & (high[active] - low[active] > SHORT)]
            if not len(active):
                break
        found[rows] = np.clip(low + (high - low) * _between(near, far), HELD_OFF, 1.0 - HELD_OFF)
        return found


def _between(near: Array, far: Array) -> Array:
    """Where the straight line between two values is 0, as a share; half way if one is endless."""
    span = near - far
    usable = np.isfinite(span)
    return np.where(usable, np.where(usable, near, 0.5) / np.where(usable, span, 1.0), 0.5)


def _differ(flags: Mask) -> Mask:
    """Which rows of flags (N, c) are not all the same."""
    return np.asarray(flags.any(axis=1) & ~flags.all(axis=1))


def _among(keys: Keys, known: Keys) -> Mask:
    """Which of *keys* are among sorted *known* ones."""
    if not len(known):
        return np.zeros(len(keys), dtype=bool)
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.asarray(known[at] == keys)
