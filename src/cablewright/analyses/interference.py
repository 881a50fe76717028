"""Distances of the sagging lines from each other, the platform, the frame and a part."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.line_shapes import polylines
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, Status
from cablewright.foundation.results import Figure, Pictured, Result
from cablewright.kernels.collision import clearance as kernel
from cablewright.kernels.collision.clearance import Surroundings
from cablewright.models.obstacles import Obstacle, nothing
from cablewright.models.plane import within
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.row_threads import run

KINDS = ("line", "platform", "frame", "part")
"""What a line's distance is measured to, in the order of the columns of `Interference.margins`."""

MAX_NODES = 2_000_000


@dataclass(frozen=True)
class InterferenceSettings:
    """Settings of the distances: ends of lines that are not tested, and accuracy.

    ``ends`` (m): length of cable at the exit point that is not tested against the frame, and at the platform point not
    against the platform nor, for a point platform, against the part; lines that share an exit or platform point are not
    tested against each other within that length of it. ``tolerance`` (m): largest distance of a line from the chords
    that represent it. ``spares_ends``: nor are the ends at the platform points of a body tested against the part.
    """

    ends: float = 0.1
    tolerance: float = 1e-3
    spares_ends: bool = False

    def __post_init__(self) -> None:
        """Reject invalid lengths."""
        if not (math.isfinite(self.ends) and self.ends >= 0.0):
            raise InputError(f"ends = {self.ends:g} m: a length of 0 or more is expected")
        if not (math.isfinite(self.tolerance) and self.tolerance > 0.0):
            raise InputError(f"tolerance = {self.tolerance:g} m: a length above 0 is expected")


DEFAULT = InterferenceSettings()


@dataclass(frozen=True, repr=False)
class Contact(Result):
    """Nearest contact of a line with another object: the smallest signed distance, m."""

    FIGURES: ClassVar = (
        Figure("distance", "m", "Smallest signed distance; negative: how deep.", "margin", shown="mm"),
        Figure("pair", "", "Names of the line and of the nearest obstacle.", name="line, nearest to"),
        Figure("place", "m", "Place of that point of the line's centre, world.", shown="m"),
    )
    HEADLINES: ClassVar = ("distance", "pair", "place")

    row: int  # of the batch
    kind: str  # of `KINDS`
    line: str
    other: str
    margin: float
    place: tuple[float, float, float]  # m, world, on the line's centre

    @property
    def pair(self) -> list[str]:
        """Names of the line and of the object nearest to it."""
        return [self.line, self.other]


class NearestContacts(NamedTuple):
    """The nearest contact of each of `KINDS`; None where the machine has nothing of a kind."""

    line: Contact | None = None
    platform: Contact | None = None
    frame: Contact | None = None
    part: Contact | None = None


class Distances(Pictured):
    """The result of `interference`, at poses or along a job: nearest contacts, compared with a clearance."""

    HEADLINES: ClassVar = ("status", "robot", "smallest_distance", "pair")

    settings: InterferenceSettings
    clearance: float

    if TYPE_CHECKING:  # fields of one subclass, properties of the other

        @property
        def robot(self) -> Robot:
            """The robot."""

        @property
        def contacts(self) -> NearestContacts:
            """The nearest contact of each kind."""

        @property
        def unsolved(self) -> str | None:
            """The status of a pose that cannot be held; None if there is none."""

    @property
    def worst(self) -> Contact | None:
        """The nearest contact of all; None if there is none."""
        known = [contact for contact in self.contacts if contact is not None]
        return min(known, key=lambda contact: contact.margin, default=None)

    @property
    def status(self) -> str:
        """Status in a word: touching, near (under the clearance), free, or that of a pose that cannot be held."""
        worst = self.worst
        if worst is not None and worst.margin <= 0.0:
            return "touching"
        if worst is not None and worst.margin < self.clearance:
            return "near"
        return self.unsolved or "free"

    @property
    def ok(self) -> bool:
        """Whether all poses are held and no line is nearer than the clearance."""
        return self.status == "free"

    @property
    def refusal(self) -> str:
        """Reason for a no: the line that is too near to an object, or the pose that cannot be held."""
        worst, status = self.worst, self.status
        if worst is None or status not in ("touching", "near"):
            return "" if self.ok else f"no line is too near, but the pose cannot be held: {status}"
        other = f"line {worst.other}" if worst.kind == "line" else worst.other
        how = "touches" if status == "touching" else "comes too near to"
        return f"line {worst.line} {how} {other}: {worst.margin * 1e3:.1f} mm"

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on assumptions about the cables."""
        thin = [line for line in self.robot.lines if line.cable.diameter is None]
        if not thin:
            return ()
        most, names = max(1e3 * line.cable.thickness for line in thin), ", ".join(line.name for line in thin)
        return (f"cable.diameter is not given, and assumed by the cable's mass, up to {most:.3g} mm: line {names}",)

    @property
    def nearest_of(self) -> dict[str, Contact | None]:
        """The nearest contact of each kind, by the kind's key in JSON."""
        return {f"line_{kind}": one for kind, one in zip(KINDS, self.contacts, strict=True)}


def _of_kind(kind: str, what: str) -> Figure:
    meaning = f"Smallest signed distance of a line from {what}; null where there is none."
    return Figure(f"line_{kind}", "m", meaning, f"contacts.{kind}.margin", shown="mm", detail=True)


FIGURES = (
    Figure("status", "", "free, touching, near (under the clearance), or why a pose is not held."),
    Figure("robot", "", "Name of the robot.", "robot.name"),
    Figure("smallest_distance", "m", "Smallest signed distance of a line from anything; negative: how deep. Null where "
           "there is nothing.", "worst.margin", shown="mm"),
    Figure("kind", "", "Kind of the nearest obstacle: line, platform, frame or part.", "worst.kind", "nearest to"),
    Figure("pair", "", "Names of that line and of the nearest obstacle.", "worst.pair", detail=True),
    Figure("place", "m", "Place of that point of the line's centre, world.", "worst.place", shown="m", detail=True),
    _of_kind("line", "another line"),
    _of_kind("platform", "the platform"),
    _of_kind("frame", "the frame"),
    _of_kind("part", "the part"),
    Figure("nearest", "", "Where a line is nearest to another line, the platform, the frame and the part; null where "
           "there is none.", "nearest_of", "nearest of each kind", parts=Contact.FIGURES),
    Figure("clearance", "m", "Distance under which a line is too near.", shown="mm"),
    Figure("ends", "m", "Length at each end of a line, excluded from the object at that end.", "settings.ends",
           detail=True),
    Figure("tolerance", "m", "Requested maximum distance of a line from its chords.", "settings.tolerance",
           detail=True),
)  # fmt: skip
"""What JSON has of poses and of jobs."""
BOUND = Figure("bound", "m", "Maximum distance of a line from the chords that replace it.", detail=True)


@dataclass(frozen=True, eq=False, repr=False)
class Interference(Distances):
    """Signed distances at N poses, m, from the surfaces of the cables; negative is a depth.

    `margins` (N, 4): the smallest for each of `KINDS`; inf where the machine has nothing of a kind, NaN where a pose
    has no solution. `bounds` (N,): largest distance of a line from the polyline that represents it, which bounds the
    error of a margin (twice it between two lines). `pairs` (N, 4, 2): indices of the line and of its nearest object:
    a line, box or beam in the order of the robot, a bead or triangle in the order of the part; the boxes are followed
    by the lines, whose sheave on the platform is meant, and the beams by the beams, nearest to the line's sheave.
    `places` (N, 4, 3): m, world.
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
        """The robot whose distances were computed."""
        return self.equilibrium.model.robot

    @property
    def bound(self) -> float:
        """Largest error of the distances, m: that of `bounds`; 0 without poses."""
        return float(self.bounds.max(initial=0.0))

    @property
    def contacts(self) -> NearestContacts:
        """The nearest of each of `KINDS` at any of the poses."""
        return NearestContacts(*(self.nearest(kind) for kind in KINDS))

    @property
    def unsolved(self) -> str | None:
        """The status of the first pose that cannot be held; None if all can."""
        codes = np.atleast_1d(self.equilibrium.judged_code)
        return Status.of(int(codes[codes != 0][0])).word if codes.any() else None

    def __len__(self) -> int:
        """The number of poses."""
        return len(self.margins)

    @property
    def smallest(self) -> Array:
        """(N,) smallest distance at each pose, m."""
        return np.asarray(self.margins.min(axis=1))

    def nearest(self, kind: str | None = None) -> Contact | None:
        """Return the nearest contact at any of the poses, of all or of one of `KINDS`; None if there is none."""
        if kind is None:
            return self.worst
        column = KINDS.index(kind)
        margins = np.where(np.isnan(self.margins[:, column]), np.inf, self.margins[:, column])
        return self.contact(int(margins.argmin()), column) if np.isfinite(margins.min(initial=np.inf)) else None

    def __getitem__(self, row: int) -> Interference:
        """One row of a batch, as a batch of one."""
        some = slice(row, row + 1)
        arrays = self.margins[some], self.bounds[some], self.pairs[some], self.places[some]
        held = self.equilibrium if self.equilibrium.single else self.equilibrium[some]
        return Interference(held, self.settings, self.part, *arrays, self.clearance)

    def curves(self, row: int = 0) -> list[Array]:
        """Return the lines at one pose as polylines (k, 3), m, world; an empty list without a solution."""
        one = self[row].equilibrium
        _, poses, states = one.solved_arrays()
        return polylines(one.packed, poses[0], states[0], self.settings.tolerance, self.settings.ends)

    def contact(self, row: int, kind: int) -> Contact:
        """Return the nearest contact at pose *row* of the kind with index *kind*."""
        line, other = (int(each) for each in self.pairs[row, kind])
        names = [each.name for each in self.equilibrium.model.robot.lines]
        if kind == kernel.LINE:
            what = names[other]
        elif kind == kernel.PART:
            what = f"{self.part.noun} {int(self.part.order[other]) + 1} of the part"
        elif kind == kernel.BODY:
            boxes = len(self.robot.platform.boxes)
            what = f"platform box {other + 1}" if other < boxes else f"platform sheave of line {names[other - boxes]}"
        else:
            beams = len(self.robot.scene.beams)
            what = f"beam {other + 1}" if other < beams else f"beam {other - beams + 1} at its platform sheave"
        x, y, z = (float(each) for each in self.places[row, kind])
        return Contact(row, KINDS[kind], names[line], what, float(self.margins[row, kind]), (x, y, z))


def distances(
    equilibria: Equilibrium,
    *,
    part: Obstacle | None = None,
    now: ArrayLike | None = None,
    clearance: float = 0.0,
    settings: InterferenceSettings = DEFAULT,
) -> Interference:
    """Compute signed distances of the free spans at solved poses, with their sag and stretch.

    *part* is what has been printed, or an obstacle; *now*, one number for all poses or (N,), is how much of it exists:
    for beads the sample, for a mesh the height (m) up to which it is printed (default: all of it). A cable of unknown
    diameter counts as a thin line. *clearance*, m: the status of the result is "near" below this distance.
    """
    solid = nothing() if part is None else part
    _, poses, states = equilibria.solved_arrays()
    rows = len(poses)
    lengths = np.atleast_2d(equilibria.lengths)
    states[~(np.isfinite(lengths) & (lengths > 0.0)).all(axis=1)] = np.nan  # infeasible poses keep their lines
    when = np.full(rows, solid.whole if now is None else np.nan)
    if now is not None:
        when[:] = now
    found = np.empty((rows, 4)), np.empty((rows, 4, 2), np.int64), np.empty((rows, 4, 3)), np.empty(rows)
    given = equilibria.packed, poses, states, _surroundings(equilibria.model.robot, settings), solid.solid, when
    run(kernel.clearance_rows, rows, *given, equilibria.model.n == 3 or settings.spares_ends, *found)
    margins, pairs, places, bounds = found
    return Interference(equilibria, settings, solid, margins, bounds, pairs, places, clearance)


@dataclass(frozen=True, eq=False)
class Free:
    """A grid of nozzle positions, with a mask of those where lines touch nothing. The platform is not rotated."""

    axes: tuple[Array, Array, Array]  # (nx,) (ny,) (nz,) m
    margins: Array  # (nx, ny, nz) m, NaN where the position cannot be held
    clearance: float  # m
    free: Mask = field(init=False)  # (nx, ny, nz): held, and no line nearer than the clearance

    def __post_init__(self) -> None:
        """Compare the margins with the clearance."""
        object.__setattr__(self, "free", ~np.isnan(self.margins) & ~too_near(self.margins, self.clearance))

    @property
    def box(self) -> list[tuple[float, float]]:
        """The lowest and the highest position along each axis, m."""
        return [(float(axis[0]), float(axis[-1])) for axis in self.axes]

    @property
    def fraction(self) -> float:
        """Share of free positions among those that the lines can hold; NaN if they can hold none."""
        held = int((~np.isnan(self.margins)).sum())
        return int(self.free.sum()) / held if held else float("nan")

    @property
    def floor(self) -> Array:
        """Lowest height (nx, ny), m, above which all positions that lines can hold are free; NaN: there is none."""
        z = self.axes[2]
        barred = ~self.free & ~np.isnan(self.margins)
        above = barred.shape[2] - np.argmax(barred[:, :, ::-1], axis=2)
        first = np.where(barred.any(axis=2), above, 0)
        shown = self.free & (np.arange(len(z)) >= first[:, :, None])
        return np.where(shown.any(axis=2), z[shown.argmax(axis=2)], np.nan)


def too_near(margins: Array, clearance: float) -> Mask:
    """Return whether distances are below the clearance or touch: a thin line through a face has exactly 0."""
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
    """Find the nozzle positions from *low* to *high* (3,), m, where all lines clear the whole *part*.

    *count*: nodes along x, y, z; *clearance*: smallest allowed distance, m. Nodes off the plane of a platform that
    moves in one count as their nearest place in it. Raises `InputError` for a box without a
    volume, or more nodes than `MAX_NODES`.
    """
    ends = np.array([low, high], dtype=np.float64)
    if ends.shape != (2, 3) or not (ends[0] < ends[1]).all():
        raise InputError("free region: a box with its lowest corner below its highest is expected")
    if min(count) < 2 or math.prod(count) > MAX_NODES:
        raise InputError(f"free region: {count} nodes: 2 or more each, at most {MAX_NODES} in all, are expected")
    x, y, z = (np.linspace(ends[0, k], ends[1, k], count[k]) for k in range(3))
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    poses = within(model.robot.platform.plane, model.unrotated_at(places))
    held = solve_inverse(model, hung(model, poses), path=True)
    found = distances(held, part=part, settings=settings)
    own = np.where(held.holds, found.margins[:, KINDS.index("part")], np.nan)
    return Free((x, y, z), own.reshape(count), clearance)


@lru_cache(maxsize=32)
def _surroundings(robot: Robot, settings: InterferenceSettings) -> Surroundings:
    """The machine as arrays for the kernels."""
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
        radii=np.array([0.5 * line.cable.thickness for line in lines]),
        shared=np.array(shared, dtype=np.int64),
        beams=np.array([(beam.start, beam.end) for beam in beams]).reshape(-1, 2, 3),
        beam_radii=np.array([beam.radius for beam in beams]),
        bodies=np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1),
        ends=float(settings.ends),
        tolerance=float(settings.tolerance),
    )
