"""How far lines keep from each other, from the platform, from the frame and from a part, sagging as they do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.arrays import Array, Mask
from cablewright.errors import InputError, Status
from cablewright.kernels.collision import clearance as kernel
from cablewright.kernels.collision.clearance import Surroundings
from cablewright.kernels.collision.line_polyline import MOST
from cablewright.models.solids import Obstacle, nothing
from cablewright.models.statics import Equilibrium, Model
from cablewright.results import Figure, Pictured, Result
from cablewright.robot import Robot
from cablewright.solvers.arguments import run
from cablewright.solvers.inverse import solve_inverse

KINDS = ("line", "platform", "frame", "part")
"""What a line may come near to, in the order of the columns of `Interference.margins`."""

MAX_NODES = 2_000_000


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


@dataclass(frozen=True, repr=False)
class Contact(Result):
    """Where a line is nearest to something: the smallest signed distance, m."""

    FIGURES: ClassVar = (
        Figure("distance", "m", "Smallest signed distance; negative: how deep.", "margin", shown="mm"),
        Figure("pair", "", "Name of the line, and of what it is nearest to.", name="line, nearest to"),
        Figure("place", "m", "Place of that point of the line's centre, world.", shown="m"),
    )
    HEADLINES: ClassVar = ("distance", "pair", "place")

    row: int  # of the batch
    kind: str  # of `KINDS`
    line: str
    other: str
    margin: float
    place: tuple[float, float, float]  # m, world, of the line's centre

    @property
    def pair(self) -> list[str]:
        """The line, and what it is nearest to."""
        return [self.line, self.other]


class NearestContacts(NamedTuple):
    """The nearest of each of `KINDS`; None where the machine has nothing of a kind."""

    line: Contact | None = None
    platform: Contact | None = None
    frame: Contact | None = None
    part: Contact | None = None


class Distances(Pictured):
    """What `interference` finds, at poses or along a job: the nearest of each kind, and whether that is too near."""

    HEADLINES: ClassVar = ("status", "robot", "smallest_distance", "pair")

    settings: InterferenceSettings
    clearance: float

    if TYPE_CHECKING:  # fields of one of the two, properties of the other

        @property
        def robot(self) -> Robot:
            """The robot asked about."""

        @property
        def contacts(self) -> NearestContacts:
            """The nearest contact of each kind."""

        @property
        def unsolved(self) -> str | None:
            """Why there is no answer, if there is none."""

    @property
    def worst(self) -> Contact | None:
        """Where a line is nearest to anything; None if there is nothing."""
        known = [contact for contact in self.contacts if contact is not None]
        return min(known, key=lambda contact: contact.margin, default=None)

    @property
    def status(self) -> str:
        """One word: touching, near, what keeps a pose from being held, or free."""
        worst = self.worst
        if worst is not None and worst.margin <= 0.0:
            return "touching"
        if worst is not None and worst.margin < self.clearance:
            return "near"
        return self.unsolved or "free"

    @property
    def ok(self) -> bool:
        """Whether all poses are held and no line is too near to anything."""
        return self.status == "free"

    @property
    def refusal(self) -> str:
        """Why the answer is no: which line is too near to what, or which pose cannot be held."""
        worst, status = self.worst, self.status
        if worst is None or status not in ("touching", "near"):
            return "" if self.ok else f"no line is too near, but the pose cannot be held: {status}"
        other = f"line {worst.other}" if worst.kind == "line" else worst.other
        how = "touches" if status == "touching" else "comes too near to"
        return f"line {worst.line} {how} {other}: {worst.margin * 1e3:.1f} mm"

    @property
    def notes(self) -> tuple[str, ...]:
        """What the distances do not count."""
        thin = [line.name for line in self.robot.lines if line.cable.diameter is None]
        return (f"the cable has no diameter, and counts as having none: line {', '.join(thin)}",) if thin else ()

    @property
    def nearest_of(self) -> dict[str, Contact | None]:
        """The nearest of each kind by its key in JSON."""
        return {f"line_{kind}": one for kind, one in zip(KINDS, self.contacts, strict=True)}


def _of_kind(kind: str, what: str) -> Figure:
    meaning = f"Smallest signed distance of a line from {what}; null where there is none."
    return Figure(f"line_{kind}", "m", meaning, f"contacts.{kind}.margin", shown="mm", detail=True)


FIGURES = (
    Figure("status", "", "free, touching, near (under the clearance), or why a pose is not held."),
    Figure("robot", "", "Name of the robot.", "robot.name"),
    Figure("smallest_distance", "m", "Smallest signed distance of a line from anything; negative: how deep. Null where "
           "there is nothing.", "worst.margin", shown="mm"),
    Figure("kind", "", "What that line is nearest to: line, platform, frame or part.", "worst.kind", "nearest to"),
    Figure("pair", "", "Name of that line, and of what it is nearest to.", "worst.pair", detail=True),
    Figure("place", "m", "Place of that point of the line's centre, world.", "worst.place", shown="m", detail=True),
    _of_kind("line", "another line"),
    _of_kind("platform", "the platform"),
    _of_kind("frame", "the frame"),
    _of_kind("part", "the part"),
    Figure("nearest", "", "Where a line is nearest to another line, the platform, the frame and the part; null where "
           "there is none.", "nearest_of", "nearest of each kind", parts=Contact.FIGURES),
    Figure("clearance", "m", "Distance under which a line is too near.", shown="mm"),
    Figure("ends", "m", "Cable at its ends that is not compared with what it is tied to.", "settings.ends",
           detail=True),
    Figure("tolerance", "m", "Requested distance of a line from the chords that stand for it.", "settings.tolerance",
           detail=True),
)  # fmt: skip
"""What JSON has of poses and of jobs."""
BOUND = Figure("bound", "m", "Max distance of a line from the chords that stand for it.", detail=True)


@dataclass(frozen=True, eq=False, repr=False)
class Interference(Distances):
    """Signed distances at N poses, m: negative is how deep, cable radii taken off.

    `margins` (N, 4): the smallest of each of `KINDS`; inf where the machine has nothing of a kind, NaN where a pose has
    no solution. `bounds` (N,): how far any line may be from the polyline that stood for it; a margin is right to
    that, between lines to twice that. `pairs` (N, 4, 2): the line, and the number of what it is nearest to: a line, box
    or beam in the order of the robot, a bead or triangle in the order of the part. `places` (N, 4, 3): m, world.
    """

    FIGURES: ClassVar = (
        *FIGURES,
        Figure("pose", "m, rad", "Pose, or one row for each of several.", "equilibrium.pose", digits=7),
        Figure("tensions", "N", "Tension of each line at its sheave.", "equilibrium.tensions", detail=True),
        BOUND,
        Figure("first_layer", "", "Null: of a job alone.", lambda _found: None, detail=True),
    )

    equilibrium: Equilibrium
    settings: InterferenceSettings
    part: Obstacle
    margins: Array
    bounds: Array
    pairs: NDArray[np.int64]
    places: Array
    clearance: float = 0.0

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.equilibrium.model.robot

    @property
    def bound(self) -> float:
        """How far any line at any pose may be from the polyline that stood for it, m."""
        return float(self.bounds.max(initial=0.0))

    @property
    def contacts(self) -> NearestContacts:
        """The nearest of each of `KINDS` at any of the poses."""
        return NearestContacts(*(self.nearest(kind) for kind in KINDS))

    @property
    def unsolved(self) -> str | None:
        """The status of the first pose that is not held."""
        codes = np.atleast_1d(self.equilibrium.code)
        return Status.of(int(codes[codes != 0][0])).word if codes.any() else None

    def __len__(self) -> int:
        """The number of poses."""
        return len(self.margins)

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
        return Interference(held, self.settings, self.part, *arrays, self.clearance)

    def curves(self, row: int = 0) -> list[Array]:
        """The lines of one row as they hang: points (k, 3) of each, m, world; none where the row has no solution."""
        one = self[row].equilibrium
        _, poses, states = one.solved_arrays()
        m = one.model.m
        points, counts = np.zeros((m, MOST, 3)), np.zeros(m, np.int64)
        around = _surroundings(one.model.robot, self.settings)
        kernel.drawn_lines(one.packed, poses, states, around, points, counts)
        return [own[:count] for own, count in zip(points, counts, strict=True)]

    def contact(self, row: int, kind: int) -> Contact:
        """The nearest of one kind at one pose."""
        line, other = (int(each) for each in self.pairs[row, kind])
        names = [each.name for each in self.equilibrium.model.robot.lines]
        if kind == kernel.LINE:
            told = names[other]
        elif kind == kernel.PART:
            told = f"{self.part.noun} {int(self.part.order[other]) + 1} of the part"
        else:
            told = f"{'platform box' if kind == kernel.BODY else 'beam'} {other + 1}"
        x, y, z = (float(each) for each in self.places[row, kind])
        return Contact(row, KINDS[kind], names[line], told, float(self.margins[row, kind]), (x, y, z))


def distances(
    equilibria: Equilibrium,
    *,
    part: Obstacle | None = None,
    now: ArrayLike | None = None,
    clearance: float = 0.0,
    settings: InterferenceSettings = DEFAULT,
) -> Interference:
    """Signed distances of the free spans at solved poses, sag and stretch included.

    *part* is what has been printed, or stands about; *now*, one number for all or (N,), how much of it there is: of
    beads the sample, of a mesh the height (m) up to which it has grown; all of it when left out. Cables of unknown
    diameter count as having none. *clearance*, m, is the distance under which the result's status is "near".
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
    run(kernel.clearance_rows, kernel.clearance_sweep, rows, *given, equilibria.model.n == 3, *found)
    margins, pairs, places, bounds = found
    return Interference(equilibria, settings, solid, margins, bounds, pairs, places, clearance)


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
    found = distances(held, part=part, settings=settings)
    return np.where(held.ok, found.smallest, np.nan)


@dataclass(frozen=True, eq=False)
class Free:
    """A grid of places of the nozzle, and what is free of them. The platform is unrotated."""

    axes: tuple[Array, Array, Array]  # (nx,) (ny,) (nz,) m
    margins: Array  # (nx, ny, nz) m, NaN where the place cannot be held
    clearance: float  # m
    free: Mask = field(init=False)  # (nx, ny, nz): held, and no line nearer than the clearance

    def __post_init__(self) -> None:
        """Judge the margins."""
        object.__setattr__(self, "free", ~np.isnan(self.margins) & ~too_near(self.margins, self.clearance))

    @property
    def box(self) -> list[tuple[float, float]]:
        """The lowest and the highest place of each axis, m."""
        return [(float(axis[0]), float(axis[-1])) for axis in self.axes]

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


def too_near(margins: Array, clearance: float) -> Mask:
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

    Raises `InputError` for a box without a volume, or more nodes than `MAX_NODES`.
    """
    ends = np.array([low, high], dtype=np.float64)
    if ends.shape != (2, 3) or not (ends[0] < ends[1]).all():
        raise InputError("free region: a box with its lowest corner below its highest is wanted")
    if min(count) < 2 or math.prod(count) > MAX_NODES:
        raise InputError(f"free region: {count} nodes: 2 or more each, at most {MAX_NODES} in all, are wanted")
    x, y, z = (np.linspace(ends[0, k], ends[1, k], count[k]) for k in range(3))
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    held = solve_inverse(model, model.unrotated_at(places), path=True)
    found = distances(held, part=part, settings=settings)
    own = np.where(held.ok, found.margins[:, KINDS.index("part")], np.nan)
    return Free((x, y, z), own.reshape(count), clearance)


def _drawable(equilibria: Equilibrium) -> Mask:
    """Which rows have lines at all: infeasible ones too, at the tensions that break the limits least."""
    return np.asarray(np.isfinite(equilibria.lengths).all(axis=-1) & (equilibria.lengths > 0.0).all(axis=-1))


@lru_cache(maxsize=32)
def _surroundings(robot: Robot, settings: InterferenceSettings) -> Surroundings:
    """The machine as kernels take it."""
    lines, beams, boxes = robot.lines, robot.scene.beams, robot.platform.boxes
    shared = [
        [
            kernel.SHARED_EXIT * (one.exit_point == other.exit_point)
            + kernel.SHARED_POINT * (one.platform_point == other.platform_point)
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
