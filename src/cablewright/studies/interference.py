"""Interference along a job: where a line first touches the part that grows, and what stays free of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.interference import (
    DEFAULT,
    KINDS,
    Contact,
    Free,
    Interference,
    InterferenceSettings,
    free_region,
    interference,
    too_near,
)
from cablewright.models.solids import Obstacle, of_beads, of_mesh
from cablewright.models.statics import Model
from cablewright.printing.deposit import deposit
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.progress import Progress, silent
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.job_poses import along
from cablewright.triangle_mesh import TriangleMesh

__all__ = ["JobInterference", "interference_over_job"]

Array = NDArray[np.float64]

BLOCK = 128 * 64  # samples between two reports of progress
PART = KINDS.index("part")
ROOM = 0.25  # of the part's largest side: how far about it the free region is looked for


@dataclass(frozen=True, eq=False)
class JobInterference:
    """What `interference_over_job` found: k samples, m. A row of `contacts` is a sample."""

    robot: Robot
    job: Job
    samples: Samples
    settings: InterferenceSettings
    clearance: float
    part: Obstacle
    margins: Array  # (k, 4) as `Interference.margins`
    bound: float  # m, how far any line may be from what stood for it
    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    contacts: dict[str, Contact | None]  # the nearest of each of `KINDS`
    closest: Interference | None  # the sample at which anything is nearest, alone; None if nothing is anywhere
    region: Free  # where the nozzle may be beside and above the whole part

    @property
    def worst(self) -> Contact | None:
        """Where a line is nearest to anything; None if there is nothing."""
        found = [contact for contact in self.contacts.values() if contact is not None]
        return min(found, key=lambda contact: contact.margin) if found else None

    @property
    def first_sample(self) -> int | None:
        """The first sample at which a line touches the part or is nearer than the clearance; None if there is none."""
        near = np.flatnonzero(too_near(self.margins[:, PART], self.clearance))
        return int(near[0]) if len(near) else None

    @property
    def first_layer(self) -> int | None:
        """The layer of `first_sample`."""
        at = self.first_sample
        return None if at is None else int(self.samples.layer[at])

    @property
    def unheld(self) -> int:
        """At how many samples the pose cannot be held."""
        return int(np.count_nonzero(self.codes))

    def layers(self) -> tuple[NDArray[np.int32], Array]:
        """The layers (L,), rising, and the smallest distance from the part while each was printed (L,), m."""
        numbers, of = np.unique(self.samples.layer, return_inverse=True)
        least = np.full(len(numbers), np.inf)
        np.fmin.at(least, of, self.margins[:, PART])
        return numbers, least


def interference_over_job(
    model: Model,
    job: Job,
    *,
    mesh: TriangleMesh | None = None,
    clearance: float = 0.0,
    settings: InterferenceSettings = DEFAULT,
    progress: Progress | None = None,
) -> JobInterference:
    """Hold the lines against everything at each sample of *job*, the part as far as it is printed by then.

    The part is the strands that the job lays, or *mesh*, which then is there up to the height of what has been laid.
    Raises `InputError` where the robot cannot follow the job's schedule or the G-code cannot be used.
    """
    report = progress or silent
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
        found.take(interference(held, part=part, now=now[block], settings=settings), first)
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
    contacts: dict[str, Contact | None] = field(default_factory=lambda: dict.fromkeys(KINDS))
    closest: Interference | None = None
    least: float = np.inf

    def take(self, found: Interference, first: int) -> None:
        """Add a block whose first row is sample *first*."""
        self.margins.append(found.margins)
        self.codes.append(found.equilibrium.code)
        self.bound = max(self.bound, float(np.max(found.bounds, initial=0.0, where=np.isfinite(found.bounds))))
        for kind in KINDS:
            here, known = found.nearest(kind), self.contacts[kind]
            if here is not None and (known is None or here.margin < known.margin):
                self.contacts[kind] = _moved(here, first)
        worst = found.nearest()
        if worst is not None and worst.margin < self.least:
            self.least, self.closest = worst.margin, found[worst.row]


def _moved(contact: Contact, by: int) -> Contact:
    return replace(contact, row=contact.row + by)


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
