"""`interference`: distances of lines from obstacles at poses, and along a job whose part grows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.interference import (
    BOUND,
    DEFAULT,
    FIGURES,
    Distances,
    Free,
    Interference,
    InterferenceSettings,
    NearestContacts,
    distances,
    free_region,
    too_near,
)
from cablewright.analyses.job_distances import PART, JobDistances
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import Room, in_room, let_go
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.job_poses import along, on_plane, sampled
from cablewright.models.obstacles import Obstacle, of_mesh
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.beads import Bead, Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.robot import Robot
from cablewright.running.memory import require_for_samples
from cablewright.solvers.inverse import BLOCK, solve_inverse

IN_ROOM: Final = 300.0
"""Memory, bytes, for each sample of a job whose arrays are in files."""

ROOM = 0.25  # margin about the part in which the free region is sought, as a share of the part's largest side


@dataclass(frozen=True, eq=False, repr=False)
class JobInterference(Distances):
    """Interference along a job: k samples, m. A row of `contacts` is a sample."""

    FIGURES: ClassVar = (
        *FIGURES,
        Figure("job", "", "Name of the job.", "job.name"),
        Figure("samples", "1", "Number of samples of the path.", lambda found: len(found.samples)),
        Figure("bead_width", "m", "Median width of the strands.", "beads.typical.width", digits=3,
               only=lambda found: found.beads is not None, shown="mm"),
        Figure("bead_height", "m", "Its height.", "beads.typical.height", digits=3,
               only=lambda found: found.beads is not None, shown="mm"),
        Figure("bead_by", "", "Where widths and heights of beads are from.", "beads.source", "bead",
               only=lambda found: found.beads is not None),
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
    bound: float  # m, largest distance of any line from the chords that approximate it
    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    contacts: NearestContacts
    closest: Interference | None  # the sample with the smallest distance; None if there are no distances
    region: Free  # positions of the nozzle beside and above the whole part at which no line touches it
    beads: Beads | None  # of the strands; None where a mesh is the part

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions on the cables, and odd values of the beads."""
        return (*super().notes, *(() if self.beads is None else self.beads.notes))

    @property
    def unsolved(self) -> str | None:
        """``infeasible`` if a sample's pose cannot be held, else None."""
        return "infeasible" if self.unheld else None

    @property
    def first_sample(self) -> int | None:
        """The first sample at which a line touches the part or is nearer than the clearance; None if there is none."""
        near = np.flatnonzero(too_near(self.margins[:, PART], self.clearance))
        return int(near[0]) if len(near) else None

    @property
    def first_gcode_line(self) -> int | None:
        """Line of the G-code of `first_sample`."""
        return self._of_sample("line", self.first_sample)

    @property
    def first_layer(self) -> int | None:
        """Layer of `first_sample`."""
        return self._of_sample("layer", self.first_sample)

    @property
    def unheld(self) -> int:
        """Number of samples of the path without an equilibrium."""
        return int(np.count_nonzero(self.codes))

    @property
    def refusal(self) -> str:
        """Reason for a no, with the place in the job."""
        worst = self.worst
        if worst is not None and self.status in ("touching", "near"):
            return f"{super().refusal} {self.samples.where(worst.row)}, G-code line {self.at('line')}"
        return super().refusal.replace("held", f"held at {self.unheld} of {len(self.samples)} samples")

    def at(self, column: str) -> int | None:
        """Return the ``layer`` or G-code ``line`` of the sample with the smallest distance."""
        return self._of_sample(column, None if self.worst is None else self.worst.row)

    def _of_sample(self, column: str, row: int | None) -> int | None:
        return None if row is None else int(getattr(self.samples, column)[row])

    def layers(self) -> tuple[NDArray[np.int32], Array]:
        """Return the layer numbers (L,), rising, and the smallest distance of a line from the part in each (L,), m."""
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
    bead: Bead | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
    room: Path | None = None,
) -> Interference | JobInterference:
    """Compute signed distances of the sagging lines from each other, the platform, the frame and a part.

    *where* is a pose (n,) or poses (N, n), m and rad, or a job, along which the part grows; an `Equilibrium` has its
    own poses. *part*: an obstacle, or, along a job, the printed part, which counts up to the height printed so far; by
    default the strands that the job lays. A line nearer than *clearance*, m, is too near; 0: only if it touches.
    *retraction*, m, is for poses; a job's schedule sets it. *bead*: width and height of all strands of a job, m; by
    default of the job file, or else of the G-code, see `Job.beads`. *room*: a folder on a disk with space for the
    results along a job, which then stay out of memory; the arrays of the result are those of files without a name.
    Raises `InputError` if the robot cannot follow the job's schedule or the G-code cannot be used, and for a *bead*
    without a job or beside a mesh.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.interference(cw.load("jung2020"), [0.2, 0.1, 0.9])
    >>> found.status
    'free'
    """
    if not (np.isfinite(clearance) and clearance >= 0.0):
        raise InputError(f"clearance = {clearance:g}: must be at least 0 m")
    if bead is not None and (part is not None or not isinstance(where, Job)):
        raise InputError("bead is the size of the strands that a job lays: give a job, and no mesh of the part")
    if isinstance(where, Job):
        if retraction is not None or isinstance(robot, Equilibrium):
            raise InputError("a job's schedule sets retraction and poses: give a robot or a model, and no retraction")
        model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
        return _over_job(model, where, part, bead, clearance, settings, progress or silent, Room(room))
    if isinstance(robot, Equilibrium):
        held = robot
    elif where is None:
        raise InputError("where: give a pose, poses or a job")
    else:
        model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
        held = solve_inverse(model, where, retraction=retraction)
    return distances(held, part=None if part is None else of_mesh(part), clearance=clearance, settings=settings)


def bytes_each(robot: Robot, room: Path | None = None) -> float:
    """Return the bytes of memory for each sample of a job, whose arrays have a *room*: benchmarks/path_memory.py."""
    return 200.0 + 45.0 * robot.m if room is None else IN_ROOM


def _over_job(
    model: Model,
    job: Job,
    mesh: TriangleMesh | None,
    bead: Bead | None,
    clearance: float,
    settings: InterferenceSettings,
    report: Progress,
    room: Room,
) -> JobInterference:
    """Distances at each sample of *job* from everything, with the part as far as it is printed by then."""
    job = on_plane(model.robot, job)
    toolpath = in_room(job.toolpath(report), room)
    beads = in_room(job.beads(toolpath, bead), room)
    samples, _ = sampled(model.robot, job, toolpath, room)
    require_for_samples(len(samples), bytes_each(model.robot, room.folder), "the distances")
    poses, retraction = along(model.robot, job, samples, room)
    found = JobDistances.of(model.robot, beads, samples, mesh, settings, room)
    for first in range(0, len(poses), BLOCK):
        report("distances of lines", first, len(poses))
        block = slice(first, first + BLOCK)
        drawn = None if retraction is None else retraction[block]
        found.take(solve_inverse(model, poses[block], path=True, retraction=drawn), first)
        let_go(poses)
    report("distances of lines", len(poses), len(poses))
    report("free region", 0, 1)
    part = found.part
    region = free_region(model, part, *_around(part, model.robot), clearance=clearance, settings=settings)
    return JobInterference(
        robot=model.robot,
        job=job,
        samples=samples,
        settings=settings,
        clearance=clearance,
        part=part,
        margins=found.margins,
        bound=found.bound,
        codes=found.codes,
        contacts=found.contacts,
        closest=found.closest,
        region=region,
        beads=beads if mesh is None else None,
    )


def _around(part: Obstacle, robot: Robot) -> tuple[Array, Array]:
    """Lowest and highest corner (3,), m, of the box to search for the free region: part and margin within the frame."""
    scene = robot.scene
    middle, half = part.solid.boxes[0, :3], part.solid.boxes[0, 3:]
    room = ROOM * 2.0 * float(half.max())
    low = np.maximum(middle - half - room, scene.frame_min)
    high = np.minimum(middle + half + room, scene.frame_max)
    outside = ~(low < high)  # a part beside the frame: the whole width of the frame
    return np.where(outside, scene.frame_min, low), np.where(outside, scene.frame_max, high)
