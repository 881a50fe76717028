"""`stages`: the fewest moves of the exit points with which a robot prints a part, and their heights.

Exit points are raised together to heights of a given grid. Layers that are spread over the part are checked one by
one, each with the exit points at each height, by the same check as a job. A stage keeps one height for successive
layers. Of all ways to divide these layers into stages the search takes one with the fewest stages and, of those, with
the smallest largest expected error. This number is a lower bound: a part with more layers needs no fewer stages. The
check of the whole part in these stages then judges every layer. Where a layer fails it, the layer joins those that
are checked one by one, and the search is repeated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.job_poses import on_plane
from cablewright.models.job_stages import highest_exit, raised
from cablewright.printing.job import Job, load_job
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.schedule import Stage
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Uncertainty
from cablewright.studies.checks.check import check
from cablewright.studies.checks.path_statics import extreme
from cablewright.studies.checks.result import Check
from cablewright.studies.stages.seam import Seam
from cablewright.studies.stages.staged_check import CheckedStage, StagedCheck, check_stages

LAYERS: Final = 12
"""Layers that are checked one by one, spread over the part with its first and last."""

MAX_HEIGHTS: Final = 100
_ROUNDS: Final = 8
_MISSED: Final = "path is not met"


@dataclass(frozen=True)
class LayerCheck:
    """Check of one layer alone, with the exit points at one height of the grid."""

    FIGURES: ClassVar = (
        Figure("layer", "", "Number of the layer."),
        Figure("height", "m", "Height of the nozzle where it begins."),
        Figure("exit_height", "m", "Height of the highest exit point."),
        Figure("feasible", "", "Whether all that was checked is within its limits."),
        Figure("limit", "", "Limit that is broken most; empty: none."),
        Figure("max_tension", "N", "Largest tension; null where nothing is held.", shown="N"),
        Figure("expected_error", "m", "Expected error; null where it was not computed.", digits=3, shown="mm"),
    )  # fmt: skip

    layer: int
    height: float
    exit_height: float
    limit: str
    max_tension: float
    expected_error: float

    @property
    def feasible(self) -> bool:
        """Whether all that was checked is within its limits."""
        return not self.limit


@dataclass(frozen=True, eq=False, repr=False)
class Stages(Pictured):
    """The fewest stages over a grid of heights of the exit points, or a layer that none of them can print."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok; no-height: a layer fails at each height; not-confirmed: the whole part fails."),
        Figure("moves", "1", "Number of moves of the exit points; null without a plan.",
               lambda of: len(of.job.stages) - 1 if of.found else None),
        Figure("proof", "", "What is proved."),
        Figure("verdict", "", "Verdict of the check of the whole part in these stages.", "checked.verdict"),
        Figure("stages", "", "Each stage, as the whole part was checked.", lambda of: of.checked_stages,
               parts=CheckedStage.FIGURES),
        Figure("exit_heights", "m", "Heights of the highest exit point that were searched.", detail=True),
        Figure("sampled_layers", "1", "Number of layers that were checked one by one.",
               lambda of: len(of.layers)),
        Figure("seams", "", "Each seam.", lambda of: of.checked.seams if of.checked else (), parts=Seam.FIGURES),
        Figure("layer_checks", "", "Each layer that was checked, at each height.", parts=LayerCheck.FIGURES,
               detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "moves")

    robot: Robot
    job: Job  # with the stages that were found; without, where there are none
    exit_heights: tuple[float, ...]  # m
    layer_checks: tuple[LayerCheck, ...]
    layer_count: int
    checked: StagedCheck | None  # the whole part in these stages

    @property
    def found(self) -> bool:
        """Whether stages were found that print all layers checked one by one."""
        return self.checked is not None

    @property
    def checked_stages(self) -> tuple[CheckedStage, ...]:
        """The stages of the whole part; empty without a plan."""
        return () if self.checked is None else self.checked.stages

    @property
    def layers(self) -> tuple[int, ...]:
        """Numbers of the layers that were checked one by one."""
        return tuple(sorted({each.layer for each in self.layer_checks}))

    @property
    def status(self) -> str:
        """Status of the search for stages: ``ok``, ``no-height`` or ``not-confirmed``."""
        if self.checked is None:
            return "no-height"
        return "ok" if self.checked.feasible else "not-confirmed"

    @property
    def proof(self) -> str:
        """Sentence that states what is proved about the number of stages."""
        checked = f"{len(self.layers)} of {self.layer_count} layers, each checked alone from rest to rest"
        grid = f"with exit points at {len(self.exit_heights)} heights"
        if self.checked is None:
            return f"no plan: {checked}, {grid}"
        count = len(self.job.stages)
        if count == 1:
            return f"one stage {'prints all layers' if self.checked.feasible else f'prints {checked}'}, {grid}"
        whole = "; these print all layers" if self.checked.feasible else ""
        return f"no fewer than {count} stages print {checked}, {grid}{whole}"

    @property
    def refusal(self) -> str:
        """Reason why no stages print the part, in a sentence."""
        if self.checked is not None:
            return "" if self.checked.feasible else f"not confirmed: {self.checked.verdict}"
        printed = {each.layer for each in self.layer_checks if each.feasible}
        layer = next(each for each in self.layers if each not in printed)
        why = [f"at {each.exit_height:g} m: {each.limit}" for each in self.layer_checks if each.layer == layer]
        return f"layer {layer} cannot be printed with the exit points at any of the heights; {'; '.join(why)}"


def find_stages(
    robot: Robot,
    job: Job | str | Path,
    exit_heights: Sequence[float],
    *,
    layers: int = LAYERS,
    tension_limits: tuple[float, float] | None = None,
    uncertainty: Uncertainty | None = None,
    clearance: float = 0.0,
    seed: int = 0,
    progress: Progress = silent,
) -> Stages:
    """Return the fewest stages in which *robot* prints a *job*, with its highest exit point at given heights, m.

    All exit points are raised together. *layers*: how many are checked one by one; other options are those of `check`.
    Raises `InputError` for heights that the robot cannot have, for a job with heights or stages, and as `check`.
    """
    heights = sorted(dict.fromkeys(float(each) for each in exit_heights))
    if not 1 <= len(heights) <= MAX_HEIGHTS or not np.isfinite(heights).all():
        raise InputError(f"exit heights: 1 to {MAX_HEIGHTS} finite heights are allowed, m")
    if layers < 1:
        raise InputError(f"layers = {layers}: must be at least 1")
    part = on_plane(robot, job if isinstance(job, Job) else load_job(job))
    for key, given in (("heights", part.heights), ("stages", part.stages or None)):
        if given is not None:
            raise InputError(f"job {part.name}: {key}: the search is for a whole part: remove {key} from the job")
    numbers, begins = _layers(part)
    top = highest_exit(robot)
    robots = {height: raised(robot, height - top) for height in heights}
    options: dict[str, Any] = {
        "tension_limits": tension_limits, "uncertainty": uncertainty, "clearance": clearance, "seed": seed,
    }  # fmt: skip
    chosen = set(np.unique(np.linspace(0, len(numbers) - 1, min(layers, len(numbers))).round().astype(int)).tolist())
    known: dict[tuple[int, float], LayerCheck] = {}

    def result(job: Job, whole: StagedCheck | None) -> Stages:
        return Stages(robot, job, tuple(heights), tuple(known[key] for key in sorted(known)), len(numbers), whole)

    for _ in range(_ROUNDS):
        rows = sorted(chosen)
        for done, row in enumerate(rows):
            progress("layers", done, len(rows))
            window = part.model_copy(update={"heights": (begins[row], begins[row + 1])})
            for height in heights:
                if (row, height) not in known:
                    found = _layer_check(robots[height], window, options)
                    known[row, height] = replace(found, layer=int(numbers[row]), height=begins[row])
        progress("layers", len(rows), len(rows))
        plan = _fewest(rows, heights, known)
        if plan is None:
            return result(part, None)
        planned = part.model_copy(
            update={"stages": tuple(Stage(z=begins[row], raised=round(height - top, 9)) for row, height in plan)}
        )
        whole = check_stages(robot, planned, progress=progress, **options)
        fails = {each for each in _failing(whole, numbers) if each not in chosen}
        if whole.feasible or not fails:
            break
        chosen |= fails
    return result(planned, whole)


def _layers(job: Job) -> tuple[NDArray[np.int32], list[float]]:
    """Return the numbers of the layers (L,) from below, and the heights (L + 1) between which they are, m, machine."""
    toolpath = job.toolpath()
    laid = toolpath.extruding
    layer, height = toolpath.layer[laid], toolpath.end[laid, 2] * job.scale + job.origin[2]
    numbers = np.unique(layer)
    lowest = np.array([height[layer == number].min() for number in numbers])
    order = np.argsort(lowest, kind="stable")
    return numbers[order], [*lowest[order].tolist(), MAX_COORDINATE]


def _layer_check(robot: Robot, layer: Job, options: Mapping[str, Any]) -> LayerCheck:
    """Check one layer alone: its limits first, and where they hold the distances of lines and the expected error."""
    found = check(robot, layer, skip=("interference", "expected-error"), **options)
    if found.feasible:
        found = check(robot, layer, **options)
    error = np.nan if found.expected is None else found.expected.value
    most = extreme(np.fmax, found.statics.lines.highest_tension)
    return LayerCheck(0, 0.0, highest_exit(robot), _limit(found), most, float(error))


def _limit(found: Check) -> str:
    """Return the limit that a check finds broken most; empty: none."""
    if found.feasible:
        return ""
    return next((each.limit for each in found.findings if each.violations), _MISSED)


def _fewest(
    rows: Sequence[int], heights: Sequence[float], known: Mapping[tuple[int, float], LayerCheck]
) -> list[tuple[int, float]] | None:
    """Return the row and the height with which each stage begins; None where a layer fails at each height.

    From the last layer down, the best plan for the layers from each on is the best of all first stages with the best
    plan for the layers that these leave: the fewest stages, then the smallest largest expected error, then the lowest.
    """
    best: list[tuple[tuple[int, float, float], list[tuple[int, float]]] | None] = [None] * len(rows)
    best.append(((0, 0.0, 0.0), []))
    for k in reversed(range(len(rows))):
        for height in heights:
            error = 0.0
            for end in range(k, len(rows)):
                layer = known[rows[end], height]
                if not layer.feasible:
                    break
                error = max(error, layer.expected_error)
                rest = best[end + 1]
                if rest is None:
                    continue
                (count, worst, highest), stages = rest
                cost = (count + 1, max(error, worst), max(height, highest))
                known_best = best[k]
                if known_best is None or cost < known_best[0]:
                    best[k] = cost, [(rows[k], height), *stages]
    return None if best[0] is None else best[0][1]


def _failing(whole: StagedCheck, numbers: NDArray[np.int32]) -> set[int]:
    """Return the rows of layers where a stage breaks limits most."""
    found = set[int]()
    for each in whole.checks:
        at = [finding.sample for finding in each.findings if finding.violations] if not each.feasible else []
        found |= {int(np.argmax(numbers == each.samples.layer[sample])) for sample in at}
    return found
