"""Where a robot stresses its brackets most, along a job or over its workspace; and what the assumed sizes matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.bracket.loads import Loads, loads_at
from cablewright.analyses.bracket.stress import bracket_of, plate_peaks
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.errors import AnswerError, InputError
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.progress import Progress, silent
from cablewright.robot import Bracket
from cablewright.studies.job_poses import along

__all__ = ["SIZES", "Highest", "Varied", "highest", "highest_over_job", "highest_over_workspace", "sensitivity"]

Array = NDArray[np.float64]

SIZES = (
    ("baseplate", "thickness"),
    ("uprights", "thickness"),
    ("lever", "thickness"),
    ("uprights", "height"),
    ("baseplate", "bolts"),
    ("", "standoff"),
    ("", "rise"),
)
"""The assumed sizes that `sensitivity` varies, by part."""

BLOCK = 8192  # poses between two reports of progress
_LOOKED_AT = 48  # poses that tell where parts are stressed most
_KEPT = 16  # poses of which the fine mesh decides
_MAX_POSES = 2_000_000


@dataclass(frozen=True, eq=False)
class Highest:
    """Where the stress of each design is highest: indices into `poses` (N, n), and the stresses there, Pa.

    A row or entry for each of `DESIGNS`. `held`: how many poses both designs can hold.
    """

    poses: Array
    retraction: Array | None
    held: int
    at: tuple[int, int]
    stress: tuple[float, float]

    @property
    def worst(self) -> tuple[list[float], float | None]:
        """The pose of the universal joint's highest stress, and the retraction length there."""
        row = self.at[0]
        return self.poses[row].tolist(), None if self.retraction is None else float(self.retraction[row])


@dataclass(frozen=True)
class Varied:
    """The largest stresses of both designs with one size changed, m and Pa."""

    name: str
    factor: float
    universal_joint: float
    conventional: float

    @property
    def ratio(self) -> float:
        """The conventional design's over the universal joint's."""
        return self.conventional / self.universal_joint


def highest(
    model: Model, poses: ArrayLike, *, bracket: Bracket | None = None, retraction: ArrayLike | None = None,
    times: int = 2, progress: Progress | None = None,
) -> Highest:  # fmt: skip
    """Find the *poses* (N, n) at which the brackets of either design are stressed most, of those that both can hold.

    A part's stress is the sum of a few unit load cases. All poses are looked at on the coarsest mesh, at the places
    that are worst at some of them; the most stressed of them at all places, on the mesh of *times*. Raises
    `AnswerError` where no pose can be held.
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
        found = np.stack([plate_peaks(own, held, times, some).max(axis=(0, 2)) for held, some in each])
        return np.where(np.isfinite(found).all(axis=0), found, -np.inf)

    some: tuple[Loads, Loads] | None = loads(np.unique(np.linspace(0, len(places) - 1, _LOOKED_AT).astype(np.int64)))
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
        raise AnswerError(f"robot {model.robot.name}: none of {len(places)} poses can be held by both designs")
    best = [np.argsort(-own_peaks, kind="stable")[: min(_KEPT, held)] for own_peaks in peaks]
    rows = np.unique(np.concatenate(best))
    fine = stresses(rows, times)
    first_at, second_at = (int(rows[k]) for k in fine.argmax(axis=1))
    return Highest(places, lengths, held, (first_at, second_at), (float(fine[0].max()), float(fine[1].max())))


def highest_over_job(
    model: Model, job: Job, *, bracket: Bracket | None = None, times: int = 2, progress: Progress | None = None
) -> Highest:
    """`highest` of the samples of a job's path. Raises `InputError` where the robot cannot follow it."""
    report = progress or silent
    samples = job.samples(job.toolpath(report))
    poses, retraction = along(model.robot, job, samples)
    return highest(model, poses, bracket=bracket, retraction=retraction, times=times, progress=progress)


def highest_over_workspace(
    model: Model, step: float, *, bracket: Bracket | None = None, times: int = 2, progress: Progress | None = None
) -> Highest:
    """`highest` of the nodes of a grid of *step* (m) that are in the static workspace, the platform unrotated.

    Raises `InputError` for a bad step or a robot with fewer lines than freedoms, `AnswerError` where nothing is in
    reach.
    """
    if model.m < model.n:
        raise InputError(f"robot {model.robot.name}: {model.m} lines cannot hold {model.n} freedoms over a grid")
    nodes = count_nodes(model, "static", step=step, progress=progress)
    if not nodes.counted:
        raise AnswerError(f"robot {model.robot.name}: no place of a grid of {step:g} m is within all limits")
    return highest(model, model.unrotated_at(nodes.places), bracket=bracket, times=times, progress=progress)


def sensitivity(
    model: Model, pose: ArrayLike, *, bracket: Bracket | None = None, change: float = 0.25,
    sizes: Sequence[tuple[str, str]] = SIZES, progress: Progress | None = None,
) -> tuple[Varied, ...]:  # fmt: skip
    """Stresses at a *pose* (n,) with each of *sizes* in turn smaller and larger by *change*; first as they are.

    Loads do not depend on these sizes. All are of the coarsest mesh, which is good for ratios. A size that cannot be
    changed so far, because parts would overlap, is left out.
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
        jointed, blocked = (float(plate_peaks(varied, loads, 1).max()) for loads in both)
        found.append(Varied(name, factor, jointed, blocked))
    report("varying sizes", len(cases), len(cases))
    return tuple(found)


def _resized(bracket: Bracket, part: str, key: str, factor: float) -> Bracket | None:
    """The bracket with one size times *factor*; None where it does not fit together."""
    table = bracket.model_dump()
    holder = table[part] if part else table
    value = holder[key]
    holder[key] = tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value
    try:
        return Bracket.model_validate(table)
    except ValueError:
        return None
