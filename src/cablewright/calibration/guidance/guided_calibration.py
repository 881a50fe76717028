"""Guided calibration: the poses to measure next, present knowledge, and when to stop.

Poses are chosen one by one: each reduces the largest standard deviation of an exit point's coordinate most. They are
feasible within the tension limits for the robot by present knowledge, and for several robots drawn from its
uncertainty.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.calibration.calibrate import ROUGH
from cablewright.calibration.guidance.next_search import NextSearch, variance_with
from cablewright.calibration.guidance.pictures_to_take import CameraView, usable, views_of
from cablewright.calibration.guidance.pose_selection import nearest_order
from cablewright.calibration.guidance.present_knowledge import Knowledge
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.verdict import NEED
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.poses.simulation import random_poses
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.calibration.unknowns import exit_rows
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_CANDIDATES: Final = 300
_TRIED: Final = 30  # of these, by which a place of the camera is chosen
MAX_NEXT: Final = 50
"""The most poses at a time."""

NEXT: Final = 4
"""Default number of poses at a time."""


@dataclass(frozen=True)
class NextPose:
    """A pose to measure next, with encoder counts to move to and the expected tensions of the possible robots."""

    pose: tuple[float, ...]  # m and rad
    counts: tuple[float, ...]  # m
    min_tension: float  # N
    max_tension: float  # N
    safe: bool  # feasible in all of these robots
    why: str  # what it brings


@dataclass(frozen=True, eq=False)
class PoseCandidates:
    """Candidate poses to measure, and the tensions there of each possible robot, NaN if not feasible."""

    places: Array  # (C, n)
    tensions: Array  # (R, C, m) N

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
        return cls(places[kept], every[:, kept])

    def ordered(self, chosen: list[int], last: Array | None) -> list[int]:
        """Return the poses in an order with short travel: the next is the nearest."""
        begin = self.places.mean(axis=0) if last is None else last
        return [chosen[at] for at in nearest_order(self.places[chosen, :3], begin[:3])]

    def like(self, measured: Measured, known: Knowledge) -> list[int]:
        """Return, for each row that is *measured*, the candidate with the nearest counts."""
        counts = known.problem.counts_at(known.theta, self.places)
        return [int(np.argmin(np.linalg.norm(counts - row, axis=1))) for row in measured.counted]

    def told(self, ordered: list[int], known: Knowledge, whys: Iterable[str]) -> tuple[NextPose, ...]:
        """Return poses in the form for people; if nothing is measured yet, the first is home, with counts 0."""
        problem, places, given = known.problem, self.places[ordered], np.zeros(1)
        places = np.pad(places, ((0, 0), (0, problem.robot.n - places.shape[1])))  # of a body on a point
        if problem.is_soft:  # with the tensions of the robots that hold the pose
            given = problem.given(known.theta, places, np.nanmean(self.tensions[:, ordered], axis=0))
        counts = problem.counts_at(known.theta, places, given)
        counts -= counts[0] * (known.poses == 0)
        made = []
        for at, own_counts, why in zip(ordered, counts.tolist(), whys, strict=True):
            own = self.tensions[:, at]
            safe, pose = bool(np.isfinite(own).all()), tuple(self.places[at].tolist())
            made.append(NextPose(pose, tuple(own_counts), float(np.nanmin(own)), float(np.nanmax(own)), safe, why))
        return tuple(made)


@dataclass(frozen=True)
class KnownExit:
    """Standard deviation of the least known coordinate of an exit point, now and after the next poses."""

    line: str
    now: float  # m
    then: float  # m


FIGURES = (
    Figure("advice", "", "measure (the next poses), stop (all is known that is needed), or mend (see the reasons)."),
    Figure("words", "", "What to do, in a sentence.", name="next"),
    Figure("camera", "", "Where the camera stands, or where to put it.", only=lambda of: of.view is not None),
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
        Figure("why", "", "What it brings: picture to take, tags in it, and the least known exit point before and "
               "after it."),
    )),
    Figure("exits", "", "How well exit points are known.", name="exit points", parts=(
        Figure("line", "", "The line."),
        Figure("now", "m", "Largest standard deviation of a coordinate.", digits=3, shown="mm"),
        Figure("then", "m", "That after the next poses.", digits=3, shown="mm"),
    )),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Guidance(Pictured):
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
    robot: Robot  # as known
    found: Calibration | None = None
    view: CameraView | None = None  # of the camera, if there is one
    faults: tuple[str, ...] = ()  # of pictures

    @property
    def to_measure(self) -> Measured:
        """The next poses, with the counts to move to."""
        counts, poses = (np.array([getattr(each, name) for each in self.next_poses]) for name in ("counts", "pose"))
        return Measured(counts, poses, by_drum=() if self.found is None else self.found.problem.measured.by_drum)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons why the present calibration is not yet good."""
        return (*self.faults, *(() if self.found is None else self.found.reasons))

    @property
    def camera(self) -> str:
        """Where the camera stands, in a sentence."""
        return "" if self.view is None else self.view.words

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
    sightings: Sightings | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> Guidance:
    """Return the *count* poses to measure next, after those in *data*: a file, or None where nothing is measured yet.

    *need*, *rough*: see `calibrate`. *tension_limits*: min and max, N, that all poses keep, by default those of the
    lines. *sightings*: layout of tags and camera, where a camera takes a picture at each pose and the data have none
    yet. Lines are straight and rigid. Raises `InputError` as `calibrate`, and if hardly any pose is feasible.

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
    faults, seen, taken = tuple[str, ...](), sightings, 0 if measured is None else len(measured.counted)
    if measured is not None and measured.sightings is not None:
        seen, (measured, plan, faults) = measured.sightings, usable(measured, plan)
    seen = None if seen is None else seen.at_exits(robot)
    known = Knowledge.of(robot, measured, plan, rough, need, seed, progress, seen is not None)
    if known.found is not None and known.found.verdict == "bad":
        words = f"no further pose helps: {known.found.reasons[0]}"
        return Guidance("mend", words, known.poses, None, None, need, None, (), (), robot, known.found, None, faults)
    candidates = PoseCandidates.drawn(model, known, np.random.default_rng(seed))
    places, size = candidates.places, max(count, known.missing)
    view = None
    if seen is not None:
        views = views_of(seen, measured, robot, known.found, places[:, :3].mean(axis=0))
        some = places[:_TRIED]
        view = min(views, key=lambda one: variance_with(known, some, one)) if len(views) > 1 else views[0]
    like = [] if measured is None or known.found is not None else candidates.like(measured, known)
    search = NextSearch(known, places, view, like)
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
        () if stop else candidates.told(ordered, known, search.whys(ordered, taken)),
        exits,
        robot if known.found is None else known.found.robot,
        known.found,
        view,
        faults,
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
