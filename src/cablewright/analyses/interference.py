"""How far lines keep from each other, from the platform, from the frame and from a part, sagging as they do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError
from cablewright.kernels.collision import clearance
from cablewright.kernels.collision.clearance import Surroundings
from cablewright.kernels.collision.line_polyline import MOST
from cablewright.models.solids import Obstacle, nothing
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import run
from cablewright.solvers.inverse import solve_inverse

__all__ = [
    "KINDS",
    "Contact",
    "Free",
    "Interference",
    "InterferenceSettings",
    "free_region",
    "interference",
    "margins",
    "too_near",
]

Array = NDArray[np.float64]

KINDS = ("line", "platform", "frame", "part")
"""What a line may come near to, in the order of the columns of `Interference.margins`."""

MOST_NODES = 2_000_000


@dataclass(frozen=True)
class InterferenceSettings:
    """What is looked at, and how finely.

    ``ends`` (m): so much of a cable at its exit is not held against the frame, at the platform not against the
    platform nor, of a point platform, against the part; lines that share an exit or a platform point are held against
    each other beyond that much of both. ``tolerance`` (m): how far the chords that stand for a line may be from it.
    """

    ends: float = 0.1
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        """Refuse what is no length."""
        if not (math.isfinite(self.ends) and self.ends >= 0.0):
            raise InputError(f"ends = {self.ends:g} m: a length of 0 or more is wanted")
        if not (math.isfinite(self.tolerance) and self.tolerance > 0.0):
            raise InputError(f"tolerance = {self.tolerance:g} m: a length above 0 is wanted")


DEFAULT = InterferenceSettings()


@dataclass(frozen=True)
class Contact:
    """Where a line is nearest to something: the smallest signed distance, m."""

    row: int  # of the batch
    kind: str  # of `KINDS`
    line: str
    other: str
    margin: float
    place: tuple[float, float, float]  # m, world, of the line's centre


@dataclass(frozen=True, eq=False)
class Interference:
    """Signed distances at N poses, m: negative is how deep, cable radii taken off.

    `margins` (N, 4): the smallest of each of `KINDS`; inf where the machine has nothing of a kind, NaN where a pose has
    no solution. `bounds` (N,): how far any line may be from the polyline that stood for it; a margin is right to
    that, between lines to twice that. `pairs` (N, 4, 2): the line, and the number of what it is nearest to: a line, box
    or beam in the order of the robot, a bead or triangle in the order of the part. `places` (N, 4, 3): m, world.
    """

    equilibrium: Equilibrium
    settings: InterferenceSettings
    part: Obstacle
    margins: Array
    bounds: Array
    pairs: NDArray[np.int64]
    places: Array

    @property
    def smallest(self) -> Array:
        """(N,) the smallest distance at each pose, m: free is above 0."""
        return np.asarray(self.margins.min(axis=1))

    def nearest(self, kind: str | None = None) -> Contact | None:
        """Where a line is nearest to anything, or to something of one of `KINDS`; None if there is nothing."""
        column = slice(None) if kind is None else slice(KINDS.index(kind), KINDS.index(kind) + 1)
        looked = np.where(np.isnan(self.margins), np.inf, self.margins)[:, column]
        if looked.size == 0 or not np.isfinite(looked.min()):
            return None
        row, found = np.unravel_index(int(looked.argmin()), looked.shape)
        return self.contact(int(row), int(found) + (column.start or 0))

    def __getitem__(self, row: int) -> Interference:
        """One row of a batch, as a batch of one."""
        some = slice(row, row + 1)
        arrays = self.margins[some], self.bounds[some], self.pairs[some], self.places[some]
        held = self.equilibrium if self.equilibrium.single else self.equilibrium[some]
        return Interference(held, self.settings, self.part, *arrays)

    def curves(self, row: int = 0) -> list[Array]:
        """The lines of one row as they hang: points (k, 3) of each, m, world; none where the row has no solution."""
        one = self[row].equilibrium
        _, poses, states = one.solved_arrays()
        m = one.model.m
        points, counts = np.zeros((m, MOST, 3)), np.zeros(m, np.int64)
        around = _surroundings(one.model.robot, self.settings)
        clearance.drawn_lines(one.packed, poses, states, around, points, counts)
        return [own[:count] for own, count in zip(points, counts, strict=True)]

    def contact(self, row: int, kind: int) -> Contact:
        """The nearest of one kind at one pose."""
        line, other = (int(each) for each in self.pairs[row, kind])
        names = [each.name for each in self.equilibrium.model.robot.lines]
        if kind == clearance.LINE:
            told = names[other]
        elif kind == clearance.PART:
            told = f"{self.part.noun} {int(self.part.order[other]) + 1} of the part"
        else:
            told = f"{'platform box' if kind == clearance.BODY else 'beam'} {other + 1}"
        x, y, z = (float(each) for each in self.places[row, kind])
        return Contact(row, KINDS[kind], names[line], told, float(self.margins[row, kind]), (x, y, z))


def interference(
    equilibria: Equilibrium,
    *,
    part: Obstacle | None = None,
    now: ArrayLike | None = None,
    settings: InterferenceSettings = DEFAULT,
) -> Interference:
    """Signed distances of the free spans at solved poses, sag and stretch included.

    *part* is what has been printed, or stands about; *now*, one number for all or (N,), how much of it there is: of
    beads the sample, of a mesh the height (m) up to which it has grown; all of it when left out. Cables of unknown
    diameter count as having none.
    """
    solid = nothing() if part is None else part
    _, poses, states = equilibria.solved_arrays()
    rows = len(poses)
    states[np.atleast_1d(~_drawable(equilibria))] = np.nan
    when = np.full(rows, solid.whole if now is None else np.nan)
    if now is not None:
        when[:] = now
    found = np.empty((rows, 4)), np.empty((rows, 4, 2), np.int64), np.empty((rows, 4, 3)), np.empty(rows)
    given = equilibria.packed, poses, states, _surroundings(equilibria.model.robot, settings), solid.solid, when
    run(clearance.clearance_rows, clearance.clearance_sweep, rows, *given, equilibria.model.n == 3, *found)
    distances, pairs, places, bounds = found
    return Interference(equilibria, settings, solid, distances, bounds, pairs, places)


def margins(
    model: Model,
    poses: ArrayLike,
    *,
    part: Obstacle | None = None,
    retraction: ArrayLike | None = None,
    settings: InterferenceSettings = DEFAULT,
) -> Array:
    """Smallest signed distance (N,) at *poses* (N, n), m: a criterion of a pose. NaN where the pose cannot be held."""
    held = solve_inverse(model, np.atleast_2d(np.asarray(poses, dtype=np.float64)), retraction=retraction)
    found = interference(held, part=part, settings=settings)
    return np.where(held.ok, found.smallest, np.nan)


@dataclass(frozen=True, eq=False)
class Free:
    """A grid of places of the nozzle, and what is free of them. The platform is unrotated."""

    axes: tuple[Array, Array, Array]  # (nx,) (ny,) (nz,) m
    margins: Array  # (nx, ny, nz) m, NaN where the place cannot be held
    clearance: float  # m
    free: NDArray[np.bool_] = field(init=False)  # (nx, ny, nz): held, and no line nearer than the clearance

    def __post_init__(self) -> None:
        """Judge the margins."""
        object.__setattr__(self, "free", ~np.isnan(self.margins) & ~too_near(self.margins, self.clearance))

    @property
    def fraction(self) -> float:
        """Which share of the places that can be held is free; NaN if there is none."""
        held = int((~np.isnan(self.margins)).sum())
        return int(self.free.sum()) / held if held else float("nan")

    @property
    def floor(self) -> Array:
        """(nx, ny) m, from which height on every place that can be held is free; NaN where none is on top."""
        z = self.axes[2]
        barred = ~self.free & ~np.isnan(self.margins)
        above = barred.shape[2] - np.argmax(barred[:, :, ::-1], axis=2)
        first = np.where(barred.any(axis=2), above, 0)
        shown = self.free & (np.arange(len(z)) >= first[:, :, None])
        return np.where(shown.any(axis=2), z[shown.argmax(axis=2)], np.nan)


def too_near(margins: Array, clearance: float) -> NDArray[np.bool_]:
    """Where a distance is under the clearance, or touches: 0 too, which is all that a thin line through a face has."""
    return np.asarray((margins < clearance) | (margins <= 0.0))


def free_region(
    model: Model,
    part: Obstacle,
    low: ArrayLike,
    high: ArrayLike,
    count: tuple[int, int, int] = (25, 25, 15),
    *,
    clearance: float = 0.0,
    settings: InterferenceSettings = DEFAULT,
) -> Free:
    """Where the nozzle may be from *low* to *high* (3,), m, while no line is nearer to the whole *part* than that.

    Raises `InputError` for a box without a volume, or more nodes than `MOST_NODES`.
    """
    ends = np.array([low, high], dtype=np.float64)
    if ends.shape != (2, 3) or not (ends[0] < ends[1]).all():
        raise InputError("free region: a box with its lowest corner below its highest is wanted")
    if min(count) < 2 or math.prod(count) > MOST_NODES:
        raise InputError(f"free region: {count} nodes: 2 or more each, at most {MOST_NODES} in all, are wanted")
    x, y, z = (np.linspace(ends[0, k], ends[1, k], count[k]) for k in range(3))
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    held = solve_inverse(model, model.unrotated_at(places), path=True)
    found = interference(held, part=part, settings=settings)
    own = np.where(held.ok, found.margins[:, KINDS.index("part")], np.nan)
    return Free((x, y, z), own.reshape(count), clearance)


def _drawable(equilibria: Equilibrium) -> NDArray[np.bool_]:
    """Which rows have lines at all: infeasible ones too, at the tensions that break the limits least."""
    return np.asarray(np.isfinite(equilibria.lengths).all(axis=-1) & (equilibria.lengths > 0.0).all(axis=-1))


@lru_cache(maxsize=32)
def _surroundings(robot: Robot, settings: InterferenceSettings) -> Surroundings:
    """The machine as kernels take it."""
    lines, beams, boxes = robot.lines, robot.scene.beams, robot.platform.boxes
    shared = [
        [
            clearance.SHARED_EXIT * (one.exit_point == other.exit_point)
            + clearance.SHARED_POINT * (one.platform_point == other.platform_point)
            for other in lines
        ]
        for one in lines
    ]
    low = np.array([box.lowest for box in boxes]).reshape(-1, 3)
    high = np.array([box.highest for box in boxes]).reshape(-1, 3)
    return Surroundings(
        radii=np.array([0.5 * (line.cable.diameter or 0.0) for line in lines]),
        shared=np.array(shared, dtype=np.int64),
        beams=np.array([(beam.start, beam.end) for beam in beams]).reshape(-1, 2, 3),
        beam_radii=np.array([beam.radius for beam in beams]),
        bodies=np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1),
        ends=float(settings.ends),
        tolerance=float(settings.tolerance),
    )
