"""`accuracy`: errors of the nozzle at a pose, at poses, over a shape or along a job's path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Final, NamedTuple, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.accuracy.nozzle_error import Accuracy, AccuracyOptions, AccuracyQuestion
from cablewright.analyses.accuracy.spread import Method
from cablewright.analyses.sheave_ratio import SheaveRule, sheave_rules
from cablewright.analyses.workspace.boundary_limits import BoundaryLimits, boundary_limits
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.memory_mapped import Room, in_room, let_go
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Result
from cablewright.live.position_sets import Places, workspace_nodes
from cablewright.models.job_poses import along, on_plane, sampled
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range, Uncertainty
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.parallel_spreads import SharedMethod
from cablewright.running.executors.stored_results import kept_in
from cablewright.running.memory import require_for_samples
from cablewright.solvers.arguments import as_poses
from cablewright.solvers.hanging_path import hung, nozzle_on_path
from cablewright.studies.accuracy_at_pose import AccuracyAtPose, at_pose

Ranges = Sequence[Range] | Uncertainty | None

IN_ROOM: Final = 130.0
"""Memory for each sample of a job whose arrays are in files, bytes."""


class ManyOptions(AccuracyOptions, total=False):
    """Options (keyword arguments) of `accuracy` for many poses."""

    file: Path | None
    executor: Executor | None
    room: Path | None


def _of_workspace(study: AccuracyStudy) -> bool:
    return study.workspace is not None


class Extreme(NamedTuple):
    """An extreme of an error over the positions, and the position (3,) of the nozzle there; m."""

    figure: str
    value: float
    place: Array


EXTREME = (
    Figure("figure", "", "Name of the figure."),
    Figure("value", "m", "Its largest or smallest value.", shown="mm"),
    Figure("place", "m", "Expected position of the nozzle there.", shown="m"),
)
END = (
    Figure("limit", "", "Limit that is broken beyond the boundary."),
    Figure("ends", "1", "Number of points of the boundary that it ends."),
    Figure("lowest", "m", "Lowest of these points.", shown="m"),
    Figure("highest", "m", "Highest of these points.", shown="m"),
)
SHEAVE_RULE = (
    Figure("line", "", "Name of the line."),
    Figure("value", "1", "Radius of the sheave over that of the cable."),
    Figure("required", "1", "Ratio that it should exceed."),
    Figure("holds", "", "Whether it does."),
)


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyStudy(Result):
    """Errors of the nozzle over a shape.

    A row of `accuracy` is a position; of a workspace, a grid node inside it.
    """

    FIGURES: ClassVar = (
        Figure("status", "", "ok: there is an answer.", lambda _: "ok"),
        Figure("shape", "", "Shape that the places make up: helix, path, plane or workspace.", "places.shape"),
        *(each.of_part("accuracy") for each in Accuracy.FIGURES),
        Figure("extremes", "", "Places where errors are largest and smallest.", name="extreme places",
               parts=EXTREME),
        Figure("sheave_rules", "", "Whether each sheave is large enough for its cable.", "rules", parts=SHEAVE_RULE,
               detail=True),
        Figure("volume", "m^3", "Volume of the workspace.", "workspace.nodes.trapezoid_volume", "workspace volume",
               only=_of_workspace),
        Figure("ends", "", "Limits that end the workspace.", "workspace.by_limit", "limits of the workspace",
               parts=END, only=_of_workspace),
    )  # fmt: skip
    HEADLINES: ClassVar = ("shape", "robot", "compensation", "places", "nominal_error", "max_error")

    places: Places
    accuracy: Accuracy
    workspace: BoundaryLimits | None  # where the shape is the workspace
    rules: tuple[SheaveRule, ...]

    @property
    def columns(self) -> dict[str, Array]:
        """Columns of the table of errors by position."""
        return self.accuracy.columns

    def __len__(self) -> int:
        """How many places there are."""
        return len(self.accuracy)

    @property
    def extremes(self) -> tuple[Extreme, ...]:
        """Positions where errors are largest, and where the largest error is smallest; only of errors with values."""
        found, spread = self.accuracy, self.accuracy.spread
        worst = found.worst_offset
        nominal = found.nominal_error
        rows = (
            ("max error, largest", lambda: spread.max_error, np.nanargmax),
            ("max error, smallest", lambda: spread.max_error, np.nanargmin),
            ("its horizontal part, largest", lambda: np.linalg.norm(worst[:, :2], axis=1), np.nanargmax),
            ("its vertical part, largest", lambda: np.abs(worst[:, 2]), np.nanargmax),
            ("nominal error, largest", lambda: nominal, np.nanargmax),
            ("difference, largest", lambda: spread.max_error - nominal, np.nanargmax),
            ("max deviation, largest", lambda: spread.max_deviation, np.nanargmax),
            ("vertical error, lowest", lambda: spread.low[:, 2], np.nanargmin),
            ("vertical error, highest", lambda: spread.high[:, 2], np.nanargmax),
            ("error of 95 % of samples, largest", lambda: spread.likely_error, np.nanargmax),
        )
        known = []
        for name, of_places, choose in rows:
            values = of_places()
            if np.isfinite(values).any():
                at = int(choose(values))
                known.append(Extreme(name, float(values[at]), self.places.positions[at]))
            let_go((spread, self.places))
        return tuple(known)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes that caution about the figures of the result."""
        broken = [rule for rule in self.rules if not rule.holds]
        if not broken:
            return self.accuracy.notes
        sheaves = ", ".join(f"{rule.line} ({rule.value:.3g})" for rule in broken)
        note = f"the radius of these sheaves is not over {broken[0].required:g} times that of the cable, which wears it"
        return (*self.accuracy.notes, f"{note}: {sheaves}")


@overload
def accuracy(
    robot: Robot | Model, where: Places | Job | str | Path, ranges: Ranges = None, **options: Unpack[ManyOptions]
) -> AccuracyStudy: ...
@overload
def accuracy(
    robot: Robot | Model, where: Sequence[float], ranges: Ranges = None, **options: Unpack[AccuracyOptions]
) -> AccuracyAtPose: ...
@overload
def accuracy(
    robot: Robot | Model, where: Sequence[Sequence[float]], ranges: Ranges = None, **options: Unpack[ManyOptions]
) -> Accuracy: ...
@overload
def accuracy(
    robot: Robot | Model, where: Array, ranges: Ranges = None, **options: Unpack[ManyOptions]
) -> Accuracy | AccuracyAtPose: ...
def accuracy(
    robot: Robot | Model,
    where: ArrayLike | Places | Job | str | Path,
    ranges: Ranges = None,
    *,
    compensation: str = "none",
    method: Method | str = "vertices",
    tension_limits: tuple[float, float] | None = None,
    home: ArrayLike | None = None,
    retraction: ArrayLike | None = None,
    seed: int = 0,
    file: Path | None = None,
    executor: Executor | None = None,
    room: Path | None = None,
    progress: Progress | None = None,
) -> AccuracyAtPose | Accuracy | AccuracyStudy:
    """Compute errors of the nozzle of *robot* at the positions or poses *where*, for parameters uncertain by *ranges*.

    *where* is one pose (n,), m and rad (returns `AccuracyAtPose`, the most detailed result); poses (N, n) (`Accuracy`);
    `Places`, with the platform unrotated, or a `Job` or its file, with the rotations of its schedule (`AccuracyStudy`).

    *ranges*: ranges of the parameters, or an `Uncertainty` that has them; by default those of the robot file's
    uncertainty, or else each line's modulus between 0.7 and 1.3 of its nominal value. *compensation*: the model that
    the commanded lengths are from: ``none``, ``elastic``, ``eyelets`` or ``full``. *method*: how the spread of errors
    is found, ``vertices``, ``first-order``, ``monte-carlo``, or a `Method` such as ``MonteCarlo(samples, seed)``.
    *tension_limits* (N) replace those of every line. *home*: a pose at which the machine was zeroed; there the
    commanded lengths are exact. *retraction* (N,), m, is for poses. *seed*: seed of the random points inside the ranges
    that are compared with their corners at one pose. *executor*: who computes the spread of many poses, by default this
    program; *file* keeps the results, also after an interruption. *room*: a folder on a disk with space for the results
    along a job, which then stay out of memory; an *executor* has no use for it. The machine follows the full model
    (catenary, real sheaves): a model under another law is rejected.

    Raises `InputError` for arguments that cannot be used, `AnswerError` if no place can be reached. Source: Paty 2021,
    section 2.3.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.accuracy(cw.load("paty2021"), [[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]], method="first-order")
    >>> found.nominal_error.round(4)
    array([0.019 , 0.0238])
    """
    if isinstance(ranges, Uncertainty):
        ranges = ranges.of(robot.robot if isinstance(robot, Model) else robot)
    question = AccuracyQuestion.of(robot, ranges, compensation, method, tension_limits, home, progress)
    if seed < 0:
        raise InputError(f"seed = {seed}: must be at least 0")
    if isinstance(where, str | Path):
        where = load_job(where)
    if isinstance(where, Places | Job):
        with _shared(question, file, executor) as asked:
            return _over_shape(asked, where, retraction, None if asked is not question else room)
    poses, single = as_poses(question.model, where, "pose", free=True)
    if not single:
        with _shared(question, file, executor) as asked:
            return asked.answer(asked.hold(poses, retraction))
    if retraction is not None:
        raise InputError(
            "retraction: of poses (N, n) only; for one pose give the robot retracted, robot.retracted(length)"
        )
    if file is not None or executor is not None:
        raise InputError("executor, file: leave them out for a single pose; they are for many")
    return at_pose(question, poses, seed)


@contextmanager
def _shared(question: AccuracyQuestion, file: Path | None, executor: Executor | None) -> Iterator[AccuracyQuestion]:
    """Hold the question whose spread an *executor* computes, and *file* keeps; the same where neither is given."""
    if file is None and executor is None:
        yield question
        return
    with kept_in(file) as kept:
        yield replace(question, method=SharedMethod(question.method, executor or Serial(), kept, question.progress))


def bytes_each(robot: Robot, ranges: int, room: Path | None = None) -> float:
    """Return the bytes of memory for each sample of a job with this many uncertain numbers.

    See benchmarks/path_memory.py. *room*: folder for its arrays.
    """
    return 300.0 + 120.0 * robot.m + 160.0 * ranges if room is None else IN_ROOM


def _over_shape(
    question: AccuracyQuestion, where: Places | Job, retraction: ArrayLike | None, room: Path | None
) -> AccuracyStudy:
    """The study of a shape."""
    model, robot = question.model, question.model.robot
    if retraction is not None:
        raise InputError(
            "retraction: is only for poses (N, n); for a shape pass robot.retracted(LENGTH), for a job use its schedule"
        )
    require(robot, Capability.PATH)
    if isinstance(where, Job):
        kept = Room(room)
        where = on_plane(robot, where)
        samples, _ = sampled(robot, where, in_room(where.toolpath(question.progress), kept), kept)
        require_for_samples(len(samples), bytes_each(robot, len(question.ranges), room), "the accuracy")
        places = Places("path", samples.positions, samples.distance)
        poses, drawn = along(robot, where, samples, kept)
        poses = nozzle_on_path(model, poses, samples.positions, drawn)
        if room is None:
            return _studied(places, question.answer(question.hold(poses, drawn)))
        return _studied(places, question.answer_in(kept, poses, drawn))
    if where.step is None:
        return _studied(where, question.answer(question.hold(_unrotated(model, where.positions))))
    nodes = workspace_nodes(model, where.step, question.progress)
    places = Places("workspace", nodes.places, axes=nodes.axes)
    found = question.answer(question.hold(_unrotated(model, places.positions)))
    return _studied(places, found, boundary_limits(nodes))


def _unrotated(model: Model, positions: Array) -> Array:
    """Return poses (k, n) with the nozzle at *positions* (k, 3), m: unrotated, or at rest as equilibrium decides."""
    return hung(model, model.unrotated_at(positions))


def _studied(places: Places, found: Accuracy, limits: BoundaryLimits | None = None) -> AccuracyStudy:
    if not np.isfinite(found.spread.max_error).any():
        raise AnswerError(
            f"robot {found.robot.name}: at none of the positions does any set of parameter values have an "
            f"equilibrium; give smaller ranges or other positions"
        )
    return AccuracyStudy(places, found, limits, sheave_rules(found.robot))
