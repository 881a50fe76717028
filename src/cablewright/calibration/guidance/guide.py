"""A calibration step by step: which poses to measure next, what is known by now, and when to stop.

Poses are chosen one by one, each the one after which the least known coordinate of an exit point is known best. They
are feasible within the tension limits for the robot as it is known by now, and for several that it may be instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.calibrate import ROUGH
from cablewright.calibration.guidance.candidates import MAX_NEXT, NextPose, PoseCandidates, Search
from cablewright.calibration.guidance.known import Known
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.verdict import NEED
from cablewright.calibration.measured import Measured
from cablewright.calibration.measurements import read_measured
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.sensors.positions import exit_rows
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.progress import Progress, silent
from cablewright.results import Figure, Result
from cablewright.robot import Robot

NEXT: Final = 4
"""Default number of poses at a time."""


@dataclass(frozen=True)
class KnownExit:
    """How well the least known coordinate of an exit point is known now, and after the next poses."""

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
    Figure("need", "m", "What is needed.", digits=3, shown="mm"),
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
    """What to measure next, and what is known by now; `found` is the calibration so far, if there is one."""

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
        return Measured(counts, poses)

    @property
    def reasons(self) -> tuple[str, ...]:
        """What speaks against the answer so far."""
        return () if self.found is None else self.found.reasons

    @property
    def refusal(self) -> str:
        """Why no further pose helps, in a sentence."""
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
    """Tell which *count* poses to measure next, after those in *data*: a file, or None where nothing is measured yet.

    *need*, *rough*: as for `calibrate`. *tension_limits*: min and max, N, that all poses keep, by default those of the
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
        raise InputError("guide: exit_point must be among the unknowns: poses are chosen for exit points")
    measured = read_measured(data, robot) if isinstance(data, str | Path) else data
    known = Known.of(robot, measured, plan, rough, need, seed, progress)
    if known.found is not None and known.found.verdict == "bad":
        words = f"no further pose helps: {known.found.reasons[0]}"
        return Guidance("mend", words, known.poses, None, None, need, None, (), (), known.found)
    rng = np.random.default_rng(seed)
    candidates = PoseCandidates.drawn(model, known, rng)
    size = max(count, known.missing)
    search = Search(known, candidates)
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


def _words(advice: str, known: Known, size: int, then: float, more: int | None, need: float) -> str:
    """Return what to do, in a sentence."""
    if advice == "stop":
        return "stop: exit points are known as well as is needed, and nothing speaks against it"
    first = f"measure these {size} poses"
    if known.missing:
        return f"{first}: with fewer nothing can be told yet"
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
