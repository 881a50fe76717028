"""Guided calibration: the poses to measure next, present knowledge, and when to stop.

Poses are chosen one by one: each reduces the largest standard deviation of an exit point's coordinate most. They are
feasible within the tension limits for the robot by present knowledge, and for several robots drawn from its
uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.calibration.calibrate import ROUGH, calibrate
from cablewright.calibration.drift.drift import with_new_home
from cablewright.calibration.guidance.pose_selection import PoseSearch, nearest_order
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.verdict import NEED
from cablewright.calibration.measurement_rows.load_cells import require_tensions
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import random_poses
from cablewright.calibration.poses.sufficient_data import check_lengths, min_poses
from cablewright.calibration.unknowns import coordinates_of, exit_rows
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_SPARE: Final = 5  # poses more than there must be, before anything counts as known
_ROBOTS: Final = 6  # that it may be
_CANDIDATES: Final = 300
_MAX_MORE: Final = 60  # poses within which the required accuracy must be reached
_RIDGE: Final = (1e-8, 1e-12)  # of the mean information, so that it is regular: before there are enough poses, and then
MAX_NEXT: Final = 50
"""The most poses at a time."""

NEXT: Final = 4
"""Default number of poses at a time."""


@dataclass(frozen=True, eq=False)
class Knowledge:
    """Present knowledge: the robot, the information on its unknowns, and robots drawn from the uncertainty."""

    problem: CalibrationProblem
    theta: Array  # (k,)
    rows: Array  # (r, k)
    sigma: float  # m, of the encoders
    rough: float  # m, max error of the file, where nothing is known yet; else 0
    poses: int
    missing: int  # poses until a result is possible
    last: Array | None  # (n,) the last pose
    found: Calibration | None

    @classmethod
    def of(
        cls,
        robot: Robot,
        measured: Measured | None,
        plan: CalibrationPlan,
        rough: float,
        need: float,
        seed: int,
        progress: Progress,
    ) -> Knowledge:
        """Calibrate if there are enough poses; otherwise take exit points of the robot file, to within *rough* (m)."""
        blank = Measured(np.zeros((1, robot.m)), np.zeros((1, robot.n)))
        count = 0 if measured is None else len(measured.counted)
        own = _of_encoders(plan, count)
        problem = StraightProblem.of(robot, measured or blank, own, hold=False)
        needed = min_poses(problem) + _SPARE
        if measured is not None and count >= needed:
            found = calibrate(robot, measured, plan, need=need, rough=rough, seed=seed, progress=progress)
            if found.verdict == "bad":
                return cls(problem, problem.free, np.zeros((0, 0)), 0.0, 0.0, count, 0, None, found)
            rows = found.posterior.rows / max(found.scale, 1e-6)
            return cls(found.problem, found.fit.theta, rows, found.encoder_sigma, 0.0, count, 0, found.poses[-1], found)
        theta = problem.free
        if measured is not None:
            check_lengths(robot, measured)
            require_tensions(robot, measured)
            told = measured.without_open_zeros(plan.unknowns)
            theta = with_new_home(StraightProblem.of(robot, told, own, hold=False), theta)
        exits = problem.named("exit_point")
        rows = np.concatenate([problem.rows.linear, np.eye(len(theta))[exits] / (max(rough, 1e-6) / np.sqrt(3.0))])
        return cls(problem, theta, rows, problem.encoder_sigma, rough, count, needed - count, None, None)

    def robots(self, rng: np.random.Generator) -> Array:
        """Return exit points (R, m, 3), m, of the robot as known now, and of random robots within its uncertainty."""
        exits = self.problem.points(self.theta)
        which, coordinates = coordinates_of(self.problem.robot, self.problem.unknowns)
        away = np.zeros((_ROBOTS, exits.size))
        if self.rough:
            away[:, coordinates] = rng.uniform(-self.rough, self.rough, (_ROBOTS, len(coordinates)))
        else:
            assert self.found is not None
            values, vectors = np.linalg.eigh(self.found.covariance[np.ix_(which, which)])
            drawn = rng.normal(size=(_ROBOTS, len(values))) * np.sqrt(values.clip(min=0.0))
            away[:, coordinates] = drawn @ vectors.T
        return np.concatenate([exits[None], exits + away.reshape(-1, *exits.shape)])


def _of_encoders(plan: CalibrationPlan, count: int) -> CalibrationPlan:
    """Return the plan without data of poses that were not measured yet."""
    kept = {
        name: tuple(each for each in getattr(plan, name) if max(each.poses) <= count) for name in ("planes", "ranges")
    }
    return plan.model_copy(update=kept)


@dataclass(frozen=True)
class NextPose:
    """A pose to measure next, with encoder counts to move to and the expected tensions of the possible robots."""

    pose: tuple[float, ...]  # m and rad
    counts: tuple[float, ...]  # m
    min_tension: float  # N
    max_tension: float  # N
    safe: bool  # feasible in all of these robots


@dataclass(frozen=True, eq=False)
class PoseCandidates:
    """Candidate poses to measure, and the tensions there of each possible robot, NaN if not feasible."""

    places: Array  # (C, n)
    tensions: Array  # (R, C, m) N
    rows: Array  # (C, e, k) of the encoders, their poses eliminated

    @classmethod
    def drawn(cls, model: Model, known: Knowledge, rng: np.random.Generator) -> PoseCandidates:
        """Return random feasible poses; those that are feasible for all possible robots, if they are enough."""
        places = random_poses(model, _CANDIDATES, rng)
        tensions = []
        for exits in known.robots(rng):
            at = np.ascontiguousarray(np.broadcast_to(exits, (len(places), *exits.shape)))
            held = solve_inverse(model, places, exit_points=at)
            tensions.append(np.where(held.ok[:, None], held.tensions, np.nan))
        every = np.array(tensions)
        held_by = np.isfinite(every).all(axis=2).sum(axis=0)
        kept = held_by >= np.sort(held_by)[-min(2 * MAX_NEXT, len(places))]
        places, every = places[kept], every[:, kept]
        problem = known.problem
        blank = Measured(np.zeros((len(places), problem.robot.m)), places)
        kept = problem.plan
        plan = CalibrationPlan(unknowns=kept.unknowns, shared=kept.shared, groups=kept.groups, datum=kept.datum)
        wanted = StraightProblem.of(problem.robot, blank, plan, hold=bool(problem.held.any()))
        _, rows, _ = projected(wanted.derivatives(known.theta, places))
        return cls(places, every, rows * (wanted.encoder_sigma / known.sigma))

    def ordered(self, chosen: list[int], last: Array | None) -> list[int]:
        """Return the poses in an order with short travel: the next is the nearest."""
        begin = self.places.mean(axis=0) if last is None else last
        return [chosen[at] for at in nearest_order(self.places[chosen, :3], begin[:3])]

    def told(self, ordered: list[int], known: Knowledge) -> tuple[NextPose, ...]:
        """Return poses in the form for people; if nothing is measured yet, the first is home, with counts 0."""
        problem, places, given = known.problem, self.places[ordered], np.zeros(1)
        if problem.is_soft:  # with the tensions of the robots that hold the pose
            given = problem.given(known.theta, places, np.nanmean(self.tensions[:, ordered], axis=0))
        counts = problem.counts_at(known.theta, places, given)
        counts -= counts[0] * (known.poses == 0)
        made = []
        for at, own_counts in zip(ordered, counts.tolist(), strict=True):
            own = self.tensions[:, at]
            safe, pose = bool(np.isfinite(own).all()), tuple(self.places[at].tolist())
            made.append(NextPose(pose, tuple(own_counts), float(np.nanmin(own)), float(np.nanmax(own)), safe))
        return tuple(made)


class _NextSearch(PoseSearch):
    """Choice of poses one by one, in the space that data and candidates determine together."""

    def __init__(self, known: Knowledge, candidates: PoseCandidates) -> None:
        exits, self.line_of = exit_rows(known.problem.robot, known.problem.free_unknowns)
        super().__init__(candidates.rows, exits, known.rows)
        self.lines = known.problem.robot.m
        if known.found is not None:
            self.assumed = np.einsum("ak,kl,al->a", exits, known.found.doubt.assumed, exits)
        own = known.rows @ self.basis
        ridge = _RIDGE[known.found is not None] * float(np.mean(np.sum(own**2, axis=0)))
        self.root = _root(own, np.sqrt(ridge) * np.eye(own.shape[1]))

    def sigmas(self, inverse: Array | None = None) -> Array:
        """Return the largest standard deviation of each exit point's coordinates (m,), m."""
        found = np.zeros(self.lines)
        np.maximum.at(found, self.line_of, self.variances(_inverse(self.root) if inverse is None else inverse))
        return np.asarray(np.sqrt(found))

    def chosen(self, size: int, need: float) -> tuple[list[int], Array, int | None]:
        """Return the *size* best poses, sigmas (m,) after them, and how many more reach *need*; None if never."""
        root, made = self.root, list[int]()
        inverse = _inverse(root)
        then = self.sigmas()
        for _ in range(min(size + _MAX_MORE, len(self.rows))):
            if len(made) >= size and float(self.sigmas(inverse).max()) <= need:
                return made[:size], then, len(made) - size
            after = self.after(inverse)
            after[made] = np.inf
            best = int(np.argmin(after))
            made.append(best)
            root = _root(root, self.rows[best])
            inverse = _inverse(root)
            if len(made) == size:
                then = self.sigmas(inverse)
        return made[:size], then, None


def _root(*rows: Array) -> Array:
    """Return a triangle (d, d) with the Gram matrix of all *rows* (.., d): the information that they have together.

    Beside what nothing determines yet, rounding would take the rest from the information itself, and from its inverse.
    """
    return np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))


def _inverse(root: Array) -> Array:
    """Return the covariance (d, d) by the *root* (d, d) of an information."""
    half = np.linalg.inv(root)
    return np.asarray(half @ half.T)


@dataclass(frozen=True)
class KnownExit:
    """Standard deviation of the least known coordinate of an exit point, now and after the next poses."""

    line: str
    now: float  # m
    then: float  # m


FIGURES = (
    Figure("advice", "", "measure (the next poses), stop (all is known that is needed), or mend (see the reasons)."),
    Figure("words", "", "What to do, in a sentence.", name="next"),
    Figure("reasons", "", "What speaks against the answer so far.", sentences=True),
    Figure("poses", "1", "Number of poses that are measured."),
    Figure("sigma", "m", "Largest standard deviation of a coordinate of an exit point; null before there are enough "
           "poses.", name="exit points known to", digits=3, shown="mm"),
    Figure("sigma_next", "m", "That after the next poses.", name="after these poses", digits=3, shown="mm"),
    Figure("need", "m", "Required value.", digits=3, shown="mm"),
    Figure("more", "1", "Number of further poses after which that is reached; null where poses alone do not reach it.",
           name="further poses until then"),
    Figure("next", "", "The poses to measure, in an order with short travel.", "next_poses", "poses to measure",
           parts=(
        Figure("pose", "m, rad", "The pose, world.", digits=4),
        Figure("counts", "m", "The counts of the encoders there, as far as the robot is known.", digits=4),
        Figure("min_tension", "N", "Lowest tension there, in the robots that it may be.", digits=3),
        Figure("max_tension", "N", "Highest tension there.", digits=3),
        Figure("safe", "", "Whether all of these robots hold it within their tension limits."),
    )),
    Figure("exits", "", "How well exit points are known.", name="exit points", parts=(
        Figure("line", "", "The line."),
        Figure("now", "m", "Largest standard deviation of a coordinate.", digits=3, shown="mm"),
        Figure("then", "m", "That after the next poses.", digits=3, shown="mm"),
    )),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Guidance(Result):
    """Advice on a calibration in progress: the poses to measure next, and the present knowledge.

    `found` is the calibration so far, if there is one.
    """

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("advice", "poses", "sigma")

    advice: str
    words: str
    poses: int
    sigma: float | None
    sigma_next: float | None
    need: float
    more: int | None
    next_poses: tuple[NextPose, ...]
    exits: tuple[KnownExit, ...]
    found: Calibration | None = None

    @property
    def to_measure(self) -> Measured:
        """The next poses, with the counts to move to."""
        counts, poses = (np.array([getattr(each, name) for each in self.next_poses]) for name in ("counts", "pose"))
        return Measured(counts, poses, by_drum=() if self.found is None else self.found.problem.measured.by_drum)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons why the present calibration is not yet good."""
        return () if self.found is None else self.found.reasons

    @property
    def refusal(self) -> str:
        """Reason why no further pose helps."""
        return self.words if self.advice == "mend" else ""


def guide(
    robot: Robot | Model,
    data: str | Path | Measured | None = None,
    plan: str | Path | CalibrationPlan | None = None,
    *,
    count: int = NEXT,
    need: float = NEED,
    rough: float = ROUGH,
    tension_limits: tuple[float, float] | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> Guidance:
    """Return the *count* poses to measure next, after those in *data*: a file, or None where nothing is measured yet.

    *need*, *rough*: see `calibrate`. *tension_limits*: min and max, N, that all poses keep, by default those of the
    lines. Lines are straight and rigid. Raises `InputError` as `calibrate`, and if hardly any pose is feasible.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.guide(cw.load("wang2021"), rough=0.05)
    >>> found.advice, found.poses, len(found.next_poses)
    ('measure', 0, 17)
    """
    if not 1 <= count <= MAX_NEXT:
        raise InputError(f"next = {count}: must be from 1 to {MAX_NEXT}")
    model = Model.of(robot, tension_limits=tension_limits, default=CableLaw.RIGID)
    if model.fidelity.cable is not CableLaw.RIGID:
        raise InputError("guide: chooses poses for rigid lines only; leave --cable out")
    plan, robot = plan_of(plan), model.robot
    if "exit_point" not in plan.unknowns:
        raise InputError("guide: poses are chosen for exit points; add exit_point to the plan's unknowns")
    measured = read_measured(data, robot) if isinstance(data, str | Path) else data
    known = Knowledge.of(robot, measured, plan, rough, need, seed, progress)
    if known.found is not None and known.found.verdict == "bad":
        words = f"no further pose helps: {known.found.reasons[0]}"
        return Guidance("mend", words, known.poses, None, None, need, None, (), (), known.found)
    candidates = PoseCandidates.drawn(model, known, np.random.default_rng(seed))
    size = max(count, known.missing)
    search = _NextSearch(known, candidates)
    now = search.sigmas()
    chosen, then, more = search.chosen(size, need)
    enough, stop = known.found is not None, known.found is not None and known.found.verdict == "good"
    advice = "stop" if stop else "measure"
    now = now if known.found is None else np.maximum(now, _exit_sigmas(known.found))
    ordered = candidates.ordered(chosen, known.last)
    lines = [line.name for line in robot.lines]
    exits = tuple(KnownExit(*each) for each in zip(lines, now.tolist(), then.tolist(), strict=True)) if enough else ()
    return Guidance(
        advice,
        _words(advice, known, size, float(then.max()), more, need),
        known.poses,
        float(now.max()) if enough else None,
        float(then.max()),
        need,
        more,
        () if stop else candidates.told(ordered, known),
        exits,
        known.found,
    )


def _exit_sigmas(found: Calibration) -> Array:
    """Return the largest sigma (m,) of a coordinate of each exit point, m."""
    rows, line_of = exit_rows(found.problem.robot, found.unknowns)
    sigmas = np.zeros(found.problem.robot.m)
    np.maximum.at(sigmas, line_of, found.exit_sigmas(rows))
    return sigmas


def _words(advice: str, known: Knowledge, size: int, then: float, more: int | None, need: float) -> str:
    """Return what to do, in a sentence."""
    if advice == "stop":
        return "stop: exit points are known as well as is needed, and nothing speaks against it"
    first = f"measure these {size} poses"
    if known.missing:
        return f"{first}: fewer poses give no result"
    if more is not None and more > 0:
        return f"{first}; after about {more} more exit points are known to {1e3 * need:.3g} mm"
    if more == 0:
        return f"{first}: they test the answer, see the reasons"
    found = known.found
    better = found.suggestions[0].words if found is not None and found.suggestions else "something else"
    return (
        f"{first}, which reach {1e3 * then:.3g} mm; poses alone may not reach {1e3 * need:.3g} mm: measure {better} "
        "too (a plan says it), or need less"
    )
