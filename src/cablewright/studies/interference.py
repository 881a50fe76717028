"""Interference along a job: where a line first touches the part that grows, and what stays free of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.interference import (
    BOUND,
    DEFAULT,
    FIGURES,
    KINDS,
    Contact,
    Distances,
    Free,
    Interference,
    InterferenceSettings,
    NearestContacts,
    distances,
    free_region,
    too_near,
)
from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.solids import Obstacle, of_beads, of_mesh
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.deposit import deposit
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.progress import Progress, silent
from cablewright.results import Figure
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.job_poses import along
from cablewright.triangle_mesh import TriangleMesh

BLOCK = 128 * 64  # samples between two reports of progress
PART = KINDS.index("part")
ROOM = 0.25  # of the part's largest side: how far about it the free region is looked for


@dataclass(frozen=True, eq=False, repr=False)
class JobInterference(Distances):
    """What `interference` found along a job: k samples, m. A row of `contacts` is a sample."""

    FIGURES: ClassVar = (
        *FIGURES,
        Figure("job", "", "Name of the job.", "job.name"),
        Figure("samples", "1", "Number of samples of the path.", lambda found: len(found.samples)),
        Figure("unheld", "1", "Number of samples at which the pose cannot be held.", name="samples not held"),
        Figure("layer", "", "Layer of the smallest distance.", lambda found: found.at("layer"), "nearest in layer"),
        Figure("gcode_line", "", "Line of the G-code at the smallest distance.", lambda found: found.at("line"),
               "nearest at G-code line"),
        Figure("first_layer", "", "First layer in which a line is too near to the part; null where there is none.",
               name="first layer touched"),
        Figure("first_gcode_line", "", "Line of the G-code at which that happens.", name="first G-code line touched"),
        Figure("free_fraction", "1", "Share of the places beside and above the whole part, of those that can be held, "
               "where no line is too near to it.", "region.fraction", "free beside and above the part", shown="%"),
        BOUND,
        Figure("layers", "", "Numbers of the layers.", lambda found: found.layers()[0], detail=True),
        Figure("layer_distances", "m", "Smallest distance of a line from the part in each layer.",
               lambda found: found.layers()[1], detail=True),
        Figure("free_box", "m", "Box of the places of free_fraction: min and max of each axis.", "region.box",
               detail=True),
    )  # fmt: skip

    robot: Robot
    job: Job
    samples: Samples
    settings: InterferenceSettings
    clearance: float
    part: Obstacle
    margins: Array  # (k, 4) as `Interference.margins`
    bound: float  # m, how far any line may be from what stood for it
    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    contacts: NearestContacts
    closest: Interference | None  # the sample at which anything is nearest, alone; None if nothing is anywhere
    region: Free  # where the nozzle may be beside and above the whole part

    @property
    def unsolved(self) -> str | None:
        """One word where a sample's pose cannot be held."""
        return "infeasible" if self.unheld else None

    @property
    def first_sample(self) -> int | None:
        """The first sample at which a line touches the part or is nearer than the clearance; None if there is none."""
        near = np.flatnonzero(too_near(self.margins[:, PART], self.clearance))
        return int(near[0]) if len(near) else None

    @property
    def first_gcode_line(self) -> int | None:
        """The line of the G-code of `first_sample`."""
        at = self.first_sample
        return None if at is None else int(self.samples.line[at])

    @property
    def first_layer(self) -> int | None:
        """The layer of `first_sample`."""
        at = self.first_sample
        return None if at is None else int(self.samples.layer[at])

    @property
    def unheld(self) -> int:
        """At how many samples the pose cannot be held."""
        return int(np.count_nonzero(self.codes))

    @property
    def refusal(self) -> str:
        """Why the answer is no, with the place in the job."""
        if self.status in ("touching", "near"):
            return f"{super().refusal} in layer {self.at('layer')}, G-code line {self.at('line')}"
        return super().refusal.replace("held", f"held at {self.unheld} of {len(self.samples)} samples")

    def at(self, column: str) -> int | None:
        """A column of the samples at the smallest distance: its layer, its line of the G-code."""
        return None if self.worst is None else int(getattr(self.samples, column)[self.worst.row])

    def layers(self) -> tuple[NDArray[np.int32], Array]:
        """The layers (L,), rising, and the smallest distance from the part while each was printed (L,), m."""
        numbers, of = np.unique(self.samples.layer, return_inverse=True)
        smallest = np.full(len(numbers), np.inf)
        np.fmin.at(smallest, of, self.margins[:, PART])
        return numbers, smallest


def interference(
    robot: Robot | Model | Equilibrium,
    where: ArrayLike | Job | None = None,
    *,
    part: TriangleMesh | None = None,
    clearance: float = 0.0,
    settings: InterferenceSettings = DEFAULT,
    retraction: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Interference | JobInterference:
    """Signed distances of the lines, sagging, from each other, the platform, the frame and a part.

    *where* is a pose (n,) or poses (N, n), m and rad, or a job, along which the part grows; an `Equilibrium` has its
    own poses. *part* is what stands about, or, along a job, what is printed, there up to the height of what has been
    laid; without it the strands that the job lays count. A line nearer than *clearance*, m, is too near; 0 is touching.
    *retraction*, m, belongs to poses; a job's schedule sets it. Raises `InputError` where the robot cannot follow the
    job's schedule or the G-code cannot be used.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.interference(cw.load("jung2020"), [0.2, 0.1, 0.9])
    >>> found.status
    'free'
    """
    if not (np.isfinite(clearance) and clearance >= 0.0):
        raise InputError(f"clearance = {clearance:g}: a length of 0 or more is wanted, m")
    if isinstance(where, Job):
        if retraction is not None or isinstance(robot, Equilibrium):
            raise InputError("retraction: a job's schedule sets it, and its poses: a robot or a model is wanted")
        model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
        return _over_job(model, where, part, clearance, settings, progress or silent)
    if isinstance(robot, Equilibrium):
        held = robot
    elif where is None:
        raise InputError("where: a pose, poses or a job is wanted")
    else:
        model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
        held = solve_inverse(model, where, retraction=retraction)
    return distances(held, part=None if part is None else of_mesh(part), clearance=clearance, settings=settings)


def _over_job(
    model: Model,
    job: Job,
    mesh: TriangleMesh | None,
    clearance: float,
    settings: InterferenceSettings,
    report: Progress,
) -> JobInterference:
    """Hold the lines against everything at each sample of *job*, the part as far as it is printed by then."""
    toolpath = job.toolpath(report)
    samples = job.samples(toolpath)
    poses, retraction = along(model.robot, job, samples)
    if mesh is None:
        part, now = of_beads(deposit(samples, job.bead)), np.arange(len(samples), dtype=np.float64)
    else:
        part, now = of_mesh(mesh), _grown(samples)
    found = _Worst()
    for first in range(0, len(poses), BLOCK):
        report("holding lines against all", first, len(poses))
        block = slice(first, first + BLOCK)
        held = solve_inverse(
            model, poses[block], path=True, retraction=None if retraction is None else retraction[block]
        )
        found.take(distances(held, part=part, now=now[block], settings=settings), first)
    report("holding lines against all", len(poses), len(poses))
    report("free region", 0, 1)
    region = free_region(model, part, *_around(part, model.robot), clearance=clearance, settings=settings)
    return JobInterference(
        robot=model.robot,
        job=job,
        samples=samples,
        settings=settings,
        clearance=clearance,
        part=part,
        margins=np.concatenate(found.margins),
        bound=found.bound,
        codes=np.concatenate(found.codes),
        contacts=found.contacts,
        closest=found.closest,
        region=region,
    )


@dataclass
class _Worst:
    """What is kept of the blocks of a job."""

    margins: list[Array] = field(default_factory=list)
    codes: list[NDArray[np.int64]] = field(default_factory=list)
    bound: float = 0.0
    contacts: NearestContacts = field(default_factory=NearestContacts)
    closest: Interference | None = None
    smallest: float = np.inf

    def take(self, found: Interference, first: int) -> None:
        """Add a block whose first row is sample *first*."""
        self.margins.append(found.margins)
        self.codes.append(found.equilibrium.code)
        self.bound = max(self.bound, float(np.max(found.bounds, initial=0.0, where=np.isfinite(found.bounds))))
        self.contacts = NearestContacts(*map(partial(_nearer, first=first), self.contacts, found.contacts))
        worst = found.nearest()
        if worst is not None and worst.margin < self.smallest:
            self.smallest, self.closest = worst.margin, found[worst.row]


def _nearer(known: Contact | None, here: Contact | None, first: int) -> Contact | None:
    """The nearer of what is known and of what a block has whose first row is sample *first*."""
    if here is None or (known is not None and known.margin <= here.margin):
        return known
    return replace(here, row=here.row + first)


def _grown(samples: Samples) -> Array:
    """Height (k,) up to which material lies at each sample, m."""
    laid = np.where(samples.extruding, samples.positions[:, 2], -np.inf)
    return np.asarray(np.maximum.accumulate(laid))


def _around(part: Obstacle, robot: Robot) -> tuple[Array, Array]:
    """The box in which the free region is looked for: the part's and some room, as far as the frame goes."""
    scene = robot.scene
    middle, half = part.solid.boxes[0, :3], part.solid.boxes[0, 3:]
    room = ROOM * 2.0 * float(half.max())
    low = np.maximum(middle - half - room, scene.frame_min)
    high = np.minimum(middle + half + room, scene.frame_max)
    outside = ~(low < high)  # a part beside the frame: all of that side
    return np.where(outside, scene.frame_min, low), np.where(outside, scene.frame_max, high)
