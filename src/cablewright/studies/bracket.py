"""`bracket`: largest stress in a robot's sheave brackets at a pose, along a job or over its workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.bracket.loads import Loads, loads_at
from cablewright.analyses.bracket.stress import BracketMesh, Comparison, Design, bracket_at, bracket_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured, Result
from cablewright.live.position_sets import workspace_nodes
from cablewright.models.fidelity import CableLaw
from cablewright.models.job_poses import along, sampled
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Job
from cablewright.robot import Bracket, Robot, load_bracket
from cablewright.solvers.hanging_path import hung

SIZES = (
    ("baseplate", "thickness"),
    ("uprights", "thickness"),
    ("lever", "thickness"),
    ("uprights", "height"),
    ("baseplate", "bolts"),
    ("", "standoff"),
    ("", "rise"),
)
"""Assumed sizes that `sensitivity` varies: part and key; without a part, of the bracket itself."""

BLOCK = 8192  # poses between two reports of progress
_SAMPLES = 48  # poses whose most stressed points are evaluated at all poses
_KEPT = 16  # poses of each design that are evaluated on the fine mesh
_MAX_POSES = 2_000_000


@dataclass(frozen=True, eq=False)
class Worst:
    """The pose at which a bracket design has its largest stress, m and rad, and that stress, Pa."""

    pose: Array
    max_von_mises: float


WORST = (
    Figure("pose", "m, rad", "Pose at which the design is stressed most."),
    Figure("max_von_mises", "Pa", "Its largest stress there.", shown="MPa"),
)


@dataclass(frozen=True, eq=False, repr=False)
class Highest(Result):
    """Poses with the highest stress of each bracket design.

    They are indices into `poses` (N, n), with the stresses there, Pa. A row or entry for each of `DESIGNS`. `held`: how
    many poses both designs can hold.
    """

    FIGURES: ClassVar = (
        Figure("poses", "1", "Number of poses that were looked at.", lambda of: len(of.poses)),
        Figure("held", "1", "Number of those that both designs can hold.", name="of them held"),
        Figure("universal_joint", "", "Largest stress of the design as built.", lambda of: of.worst_of(0), parts=WORST,
               detail=True),
        Figure("conventional", "", "Largest stress with the second rotation blocked.", lambda of: of.worst_of(1),
               parts=WORST, detail=True),
    )  # fmt: skip

    poses: Array
    retraction: Array | None
    held: int
    at: tuple[int, int]
    stress: tuple[float, float]

    @property
    def worst(self) -> tuple[list[float], float | None]:
        """Pose with the universal joint's highest stress, and the retraction length there, m."""
        row = self.at[0]
        return self.poses[row].tolist(), None if self.retraction is None else float(self.retraction[row])

    def worst_of(self, design: int) -> Worst:
        """Pose with the highest stress of one of `DESIGNS`."""
        return Worst(self.poses[self.at[design]], self.stress[design])


@dataclass(frozen=True, repr=False)
class Varied(Result):
    """The largest stresses of both bracket designs with one size changed, m and Pa."""

    FIGURES: ClassVar = (
        Figure("size", "", "Size that is changed.", "name"),
        Figure("factor", "1", "Factor on that size.", digits=3),
        Figure("universal_joint", "Pa", "Largest stress of the design as built.", name="universal joint", shown="MPa"),
        Figure("conventional", "Pa", "Largest stress with the second rotation blocked.", shown="MPa"),
        Figure("ratio", "1", "Conventional stress over that of the universal joint.", digits=3),
    )
    HEADLINES: ClassVar = ("size", "factor", "ratio")

    name: str
    factor: float
    universal_joint: float
    conventional: float

    @property
    def ratio(self) -> float:
        """Stress of the conventional design over that of the universal joint."""
        return self.conventional / self.universal_joint


def highest(
    model: Model, poses: ArrayLike, *, bracket: Bracket | None = None, retraction: ArrayLike | None = None,
    times: int = 2, progress: Progress | None = None,
) -> Highest:  # fmt: skip
    """Find the poses at which the brackets of either design are stressed most, of those that both designs can hold.

    *poses* (N, n), m and rad; *retraction*: (N,) m or one for all. A part's stress is the sum of a few unit load
    cases. All poses are evaluated on the coarsest mesh, at the points that are stressed most at some of them; the most
    stressed poses at all points of the mesh of *times*. Raises `AnswerError` if no pose can be held.
    """
    own = bracket_of(model.robot) if bracket is None else bracket
    report, places = progress or silent, np.atleast_2d(np.asarray(poses, dtype=np.float64))
    lengths = None if retraction is None else np.broadcast_to(np.asarray(retraction, dtype=np.float64), len(places))
    if len(places) > _MAX_POSES:
        raise InputError(f"{len(places)} poses; at most {_MAX_POSES} are allowed: take a larger step")

    def loads(rows: NDArray[np.int64]) -> tuple[Loads, Loads]:
        return loads_at(model, places[rows], retraction=None if lengths is None else lengths[rows])

    def stresses(rows: NDArray[np.int64], times: int, near: tuple[Loads, Loads] | None = None) -> Array:
        each = zip(loads(rows), near or (None, None), strict=True)
        found = np.stack([BracketMesh(own, times).peaks(held, some).max(axis=(0, 2)) for held, some in each])
        return np.where(np.isfinite(found).all(axis=0), found, -np.inf)

    some: tuple[Loads, Loads] | None = loads(np.unique(np.linspace(0, len(places) - 1, _SAMPLES).astype(np.int64)))
    if not all(each.held.ok.any() for each in some or ()):
        some = None
    peaks = np.empty((2, len(places)))
    for first in range(0, len(places), BLOCK):
        report("loads of brackets", first, len(places))
        rows = np.arange(first, min(first + BLOCK, len(places)))
        peaks[:, rows] = stresses(rows, 1, some)
    report("loads of brackets", len(places), len(places))
    held = int(np.isfinite(peaks[0]).sum())
    if not held:
        raise AnswerError(
            f"robot {model.robot.name}: none of the {len(places)} poses can be held by both designs of the bracket"
        )
    best = [np.argsort(-own_peaks, kind="stable")[: min(_KEPT, held)] for own_peaks in peaks]
    rows = np.unique(np.concatenate(best))
    fine = stresses(rows, times)
    first_at, second_at = (int(rows[k]) for k in fine.argmax(axis=1))
    return Highest(places, lengths, held, (first_at, second_at), (float(fine[0].max()), float(fine[1].max())))


@dataclass(frozen=True, eq=False, repr=False)
class BracketStress(Pictured):
    """Stress in the brackets of both designs at a pose, the search for that pose, and the effect of assumed sizes."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or yields: the universal joint's bracket is stressed beyond its yield strength."),
        Figure("robot", "", "Name of the robot.", "designs.model.robot.name"),
        Figure("pose", "m, rad", "Pose of the platform.", "designs.pose", digits=7),
        Figure("yield_strength", "Pa", "Yield strength of the material.", "designs.bracket.material.yield_strength",
               shown="MPa"),
        Figure("universal_joint", "", "The most stressed bracket as built.", "designs.universal_joint", along="design",
               parts=Design.FIGURES),
        Figure("conventional", "", "The most stressed bracket with the second rotation blocked.",
               "designs.conventional", along="design", parts=Design.FIGURES),
        Figure("ratio", "1", "Largest conventional stress over that of the universal joint.", "designs.ratio",
               "conventional over universal joint", 3),
        Figure("platform_motion_cables", "m, rad", "Motion of the platform because the cables stretch and sag, from "
               "lengths of rigid cables; null where that is not known.", "designs.cable_motion", detail=True),
        Figure("platform_displacement_cables", "m", "Norm of the translation in platform_motion_cables.",
               lambda of: np.linalg.norm(of.designs.cable_motion[:3]), "platform moves by cables alone", shown="mm"),
        Figure("searched", "", "Poses that were looked at.", "highest", parts=Highest.FIGURES,
               only=lambda of: of.highest is not None),
        Figure("sensitivity", "", "Largest stresses with each assumed size changed.", "varied", parts=Varied.FIGURES,
               only=lambda of: bool(of.varied)),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "robot", "pose", "ratio")

    designs: Comparison
    highest: Highest | None = None
    varied: tuple[Varied, ...] = ()

    @property
    def status(self) -> str:
        """Status of the brackets: "ok", or "yields" if a stress exceeds the yield strength."""
        return "yields" if self.designs.universal_joint.safety < 1.0 else "ok"

    @property
    def refusal(self) -> str:
        """The bracket that yields, in a sentence; empty if none does."""
        found = self.designs.universal_joint
        if self.status == "ok":
            return ""
        return f"the bracket of line {found.line_name} yields: safety {found.safety:.3g} against its yield strength"


def bracket(
    robot: Robot | Model,
    where: ArrayLike | Job | None = None,
    *,
    step: float | None = None,
    bracket: Bracket | str | Path | None = None,
    times: int = 2,
    sensitivities: bool = False,
    retraction: float | None = None,
    cable: CableLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> BracketStress:
    """Compute the stress in the most stressed sheave bracket, with its universal joint and with one rotation blocked.

    *where* is a pose (n,), m and rad, or a job, whose most stressed sample is taken; without it, the most stressed node
    of a grid of *step*, m, over the static workspace is. *bracket* replaces the robot's own. *times*: mesh refinement;
    2 also estimates the discretisation error. *sensitivities* adds the stresses with each assumed size a quarter
    smaller and larger. *retraction*, m, is for a pose. Raises `AnswerError` if no pose can be held, `InputError` for
    missing or contradictory arguments.

    Source: Paty 2021, section 3.2, whose finite-element analysis this repeats with another mesh.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.bracket(cw.load("house-printer"), [-2.25, -6.75, 13.0], times=1)
    >>> found.status
    'ok'
    """
    if (where is None) == (step is None):
        raise InputError("bracket: give a pose, a job, or the step of a grid over the workspace")
    model = Model.of(robot, cable=cable, tension_limits=tension_limits)
    require(model, Capability.BRACKET)
    own = load_bracket(bracket) if isinstance(bracket, str | Path) else bracket or bracket_of(model.robot)
    found: Highest | None = None
    if step is not None:
        nodes = hung(model, model.unrotated_at(workspace_nodes(model, step, progress).places))
        found = highest(model, nodes, bracket=own, times=times, progress=progress)
    elif isinstance(where, Job):
        if retraction is not None:
            raise InputError("retraction: is set by the schedule of a job; leave it out")
        samples, _ = sampled(model.robot, where, where.toolpath(progress or silent))
        poses, drawn = along(model.robot, where, samples)
        found = highest(model, poses, bracket=own, retraction=drawn, times=times, progress=progress)
    if found is not None:
        where, retraction = found.worst
    assert not isinstance(where, Job)
    assert where is not None
    designs = bracket_at(model, where, bracket=own, times=times, retraction=retraction)
    varied = sensitivity(model, designs.pose, bracket=own, progress=progress) if sensitivities else ()
    return BracketStress(designs, found, varied)


def sensitivity(
    model: Model, pose: ArrayLike, *, bracket: Bracket | None = None, change: float = 0.25,
    sizes: Sequence[tuple[str, str]] = SIZES, progress: Progress | None = None,
) -> tuple[Varied, ...]:  # fmt: skip
    """Compute bracket stresses at a *pose* (n,) with the given sizes, and with each of *sizes* changed by +/- *change*.

    *change*: a share. Loads do not depend on these sizes. The coarsest mesh is used, which is accurate enough for
    ratios. A size whose change would make parts overlap is omitted.
    """
    own = bracket_of(model.robot) if bracket is None else bracket
    report, found = progress or silent, []
    both = loads_at(model, np.asarray(pose, dtype=np.float64)[None])
    for loads in both:
        loads.held[0].checked()
    cases = [("as it is", 1.0, own)]
    for part, key in sizes:
        for factor in (1.0 - change, 1.0 + change):
            varied = _resized(own, part, key, factor)
            if varied is not None:
                cases.append((f"{part} {key}".strip(), factor, varied))
    for done, (name, factor, varied) in enumerate(cases):
        report("varying sizes", done, len(cases))
        jointed, blocked = (float(BracketMesh(varied, 1).peaks(loads).max()) for loads in both)
        found.append(Varied(name, factor, jointed, blocked))
    report("varying sizes", len(cases), len(cases))
    return tuple(found)


def _resized(bracket: Bracket, part: str, key: str, factor: float) -> Bracket | None:
    """The bracket with one size times *factor*; None if its parts then overlap."""
    table = bracket.model_dump()
    holder = table[part] if part else table
    value = holder[key]
    holder[key] = tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value
    try:
        return Bracket.model_validate(table)
    except ValueError:
        return None
