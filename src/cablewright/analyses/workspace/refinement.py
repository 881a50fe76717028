"""Volume and surface of where a function is at least zero in a box, by a lattice that is refined along the surface.

A cell is split where its corners differ in sign. Where a split cell shows that its neighbour is crossed too, that one
follows, so that the surface on the finest lattice is closed. Random places in a first lattice's cells look for what its
corners do not see, and what they find is followed as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.workspace.marching import BITS, CORNERS, FACES, crossings, index_of, key_of
from cablewright.triangle_mesh import TriangleMesh

__all__ = ["Refined", "SearchBox", "refine"]

Array = NDArray[np.float64]
Keys = NDArray[np.int64]
Margin = Callable[[Array, str], Array]  # of places (N, 3), m, and what they are for: at least 0 inside; (N,)

FIRST = 16  # cells of the first lattice along the longest side of the box
FEWEST = 4  # along any side
FINEST = 8  # lattices
MOST_CELLS = 1_500_000  # on the surface
PROBES = (4096, 400_000)  # fewest and most random places
PROBES_FOR_NOTHING = 50_000  # where the first lattice has found nothing
UNSEEN = 3.0  # expected number of finds at which none is found once in twenty times
CLOSE = 0.1  # of the smaller value at the ends of an edge: near enough to zero for a straight line
SHORT = 1.0 / 16.0  # of an edge: near enough to where the surface crosses it
STEPS = 6
DOUBT = 4e-3  # of a volume after the first change: twice what chunky bodies are off by on a first lattice split once
HELD_OFF = 1e-4  # of an edge: no crossing is nearer to a node, so that no two are in one place


@dataclass(frozen=True, eq=False)
class SearchBox:
    """A box in the world, m."""

    low: Array  # (3,)
    high: Array  # (3,)

    @property
    def volume(self) -> float:
        """m^3."""
        return float(np.prod(self.high - self.low))

    def at(self, shares: Array) -> Array:
        """Places (..., 3) at *shares* (..., 3) of the sides; the same from either side."""
        return np.asarray((1.0 - shares) * self.low + shares * self.high)


@dataclass(frozen=True, eq=False)
class Refined:
    """What is inside: as a surface, and how well it is known."""

    mesh: TriangleMesh
    error: float  # m^3
    unseen: float  # m^3: of `error`, what random places would have missed once in twenty times
    poses: int  # how often the function was asked
    cells: tuple[int, int, int]  # of the finest lattice along the sides
    converged: bool  # whether the error is what was asked for


def refine(
    margin: Margin, box: SearchBox, *, tolerance: float | None = 2e-3, finest: int | None = None, seed: int = 0
) -> Refined:
    """Refine until the error is at most *tolerance* of the volume, or to *finest* cells along the longest side.

    The error is that of `_left`, and besides what the random places may have missed.
    """
    lattice = _Lattice(margin, box, _first(box, finest), seed)
    volumes = [lattice.surface().volume]
    goal = tolerance if finest is None else None
    while True:
        lattice.split(goal or 0.0, volumes[-1])
        mesh = lattice.surface()
        volumes.append(mesh.volume)
        unseen = lattice.unseen()
        error = _left(volumes) + unseen
        converged = goal is not None and error <= goal * volumes[-1]
        nothing = len(volumes) > 2 and not mesh.vertices.size
        ended = lattice.level >= FINEST or len(lattice.crossed) > MOST_CELLS
        if finest is not None:
            converged = ended = lattice.cells.max() >= finest
        if converged or nothing or ended:
            return Refined(mesh, error, unseen, lattice.poses, _three(lattice.cells), converged or nothing)


def _left(volumes: list[float]) -> float:
    """How far off the last volume is: its last change or, if larger, a quarter of the one before.

    Where the surface is smooth or has edges the change falls fourfold with each lattice: about a third of it is left. A
    first change may be small by chance: twice it counts, and at least `DOUBT`.
    """
    *before, last = np.abs(np.diff(volumes)).tolist()
    return float(max(last, 0.25 * before[-1]) if before else max(2.0 * last, DOUBT * volumes[-1]))


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
    """Nodes, one layer of cells around the box among them, whose outer nodes are outside whatever the function says."""

    def __init__(self, margin: Margin, box: SearchBox, first: NDArray[np.int64], seed: int) -> None:
        self.margin, self.box, self.first = margin, box, first
        self.all_cells: Keys
        self.inside: NDArray[np.bool_]  # (K, 8) corners of all cells
        self.mixed: NDArray[np.bool_]  # (K,)
        self.level, self.poses, self.seed = 0, 0, seed
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
        """Look at *cells*, sorted, and at all neighbours into which the surface goes on."""
        corners = cells[:, None] + CORNERS
        self._ask(np.unique(corners))
        self.all_cells, self.inside = cells, self._inside(corners)
        self.mixed = _differ(self.inside)
        fresh = np.flatnonzero(self.mixed)
        while len(fresh):
            beyond = self._beyond(fresh)
            if not len(beyond):
                break
            corners = beyond[:, None] + CORNERS
            self._ask(np.unique(corners))
            inside = self._inside(corners)
            mixed = _differ(inside)
            order = np.argsort(np.concatenate([self.all_cells, beyond]), kind="stable")
            new = order >= len(self.all_cells)
            self.all_cells = np.concatenate([self.all_cells, beyond])[order]
            self.inside = np.concatenate([self.inside, inside])[order]
            self.mixed = np.concatenate([self.mixed, mixed])[order]
            fresh = np.flatnonzero(new & self.mixed)

    def _beyond(self, rows: NDArray[np.int64]) -> Keys:
        """Neighbours of cells that are behind a crossed face and have not been looked at."""
        steps = [1 << 2 * BITS, 1 << BITS, 1]
        found = []
        for axis, side, corners in FACES:
            face = self.inside[rows][:, corners]
            through = _differ(face)
            found.append(self.all_cells[rows[through]] + (steps[axis] if side else -steps[axis]))
        keys = np.unique(np.concatenate(found))
        return keys[~_among(keys, self.all_cells)]

    def _inside(self, corners: Keys) -> NDArray[np.bool_]:
        return np.asarray(self.values[np.searchsorted(self.nodes, corners)] >= 0.0)

    def _ask(self, keys: Keys) -> None:
        """Have the values of the nodes of sorted *keys*."""
        new = keys[~_among(keys, self.nodes)]
        values = self._values(new)
        order = np.argsort(np.concatenate([self.nodes, new]), kind="stable")
        self.nodes = np.concatenate([self.nodes, new])[order]
        self.values = np.concatenate([self.values, values])[order]

    def _values(self, keys: Keys) -> Array:
        shares, within = self._shares(keys)
        values = np.full(len(keys), -np.inf)
        values[within] = self._margin(self.box.at(shares[within]), f"lattice of {self._told}")
        return values

    def _shares(self, keys: Keys) -> tuple[Array, NDArray[np.bool_]]:
        """Where nodes are in the box, (N, 3) shares of its sides, and which are in it."""
        index = index_of(keys) - (1 << self.level)
        within = np.all((index >= 0) & (index <= self.cells), axis=1)
        return index / self.cells, within

    @property
    def _told(self) -> str:
        return f"{self.cells.max()} cells"

    def _margin(self, places: Array, purpose: str) -> Array:
        self.poses += len(places)
        values = self.margin(places, purpose) if len(places) else np.empty(0)
        return np.where(np.isnan(values), -np.inf, values)

    def split(self, tolerance: float, volume: float) -> None:
        """Go on to cells of half the size where the surface is, or where a random place tells of more."""
        if self.level == 0:
            self._probe(tolerance, volume)
        else:
            self._track()
        parents = np.union1d(self.crossed, self._probe_cells(self.tracked))
        keep = np.unique(self.crossed[:, None] + CORNERS)
        known = np.searchsorted(self.nodes, keep)
        self.nodes, self.values = 2 * keep, self.values[known]
        self.level += 1
        self._take(np.sort((2 * parents[:, None] + CORNERS).ravel()))

    def _probe(self, tolerance: float, volume: float) -> None:
        """Ask at random places, as many in each cell of the first lattice."""
        cells = int(np.prod(self.first))
        wanted = 4.0 * UNSEEN * self.box.volume / max(tolerance * volume, 1e-300)
        if tolerance == 0.0:
            wanted = 8.0 * cells
        elif volume == 0.0:
            wanted = PROBES_FOR_NOTHING
        each = int(np.ceil(np.clip(wanted, *PROBES) / cells))
        index = np.stack(np.meshgrid(*(np.arange(n) for n in self.first), indexing="ij"), axis=-1).reshape(-1, 3)
        jitter = np.random.default_rng(self.seed).random((each, cells, 3))
        self.probes = ((index + jitter) / self.first).reshape(-1, 3)
        self.probe_signs = self._margin(self.box.at(self.probes), "random places") >= 0.0
        self.tracked = np.arange(len(self.probes))
        self._track()

    def _probe_cells(self, rows: NDArray[np.int64]) -> Keys:
        return key_of(np.floor(self.probes[rows] * self.cells).astype(np.int64) + (1 << self.level))

    def _track(self) -> None:
        """Keep the random places that are in crossed cells, or contradict all corners of their cell."""
        cells = self._probe_cells(self.tracked)
        at = np.minimum(np.searchsorted(self.all_cells, cells), len(self.all_cells) - 1)
        contradicted = self.inside[at, 0] != self.probe_signs[self.tracked]
        self.tracked = self.tracked[self.mixed[at] | contradicted]

    def unseen(self) -> float:
        """Volume, m^3, that may be on the wrong side of a surface that was not found: more once in twenty times."""
        cells = self._probe_cells(self.tracked)
        at = np.searchsorted(self.all_cells, cells)
        against = int((~self.mixed[at] & (self.inside[at, 0] != self.probe_signs[self.tracked])).sum())
        return (UNSEEN + against + 2.0 * float(np.sqrt(against))) / len(self.probes) * self.box.volume

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

    def _cross(self, inner: Array, outer: Array, in_box: NDArray[np.bool_], within: Keys, without: Keys) -> Array:
        """Shares (E,) of the ways from inside to outside where the surface is; 0 if the outer node is off the box."""
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
            values = self._margin(places, f"surface in {self._told}, step {step + 1}")
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


def _differ(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which rows of flags (N, c) are not all the same."""
    return np.asarray(flags.any(axis=1) & ~flags.all(axis=1))


def _among(keys: Keys, known: Keys) -> NDArray[np.bool_]:
    """Which of *keys* are among sorted *known* ones."""
    if not len(known):
        return np.zeros(len(keys), dtype=bool)
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.asarray(known[at] == keys)
