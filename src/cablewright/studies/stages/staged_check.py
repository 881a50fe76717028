"""`check` of a job with stages: each layer with the exit points of its stage, and the seams between stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cablewright.calibration.drift.record import CalibrationRecord
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.units import spell_length
from cablewright.models.job_stages import JobStage, stages_of
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Uncertainty, assumed_uncertainty
from cablewright.studies.checks.check import check
from cablewright.studies.checks.path_statics import extreme
from cablewright.studies.checks.result import Check
from cablewright.studies.stages.seam import Seam, seam_of

Options = dict[str, Any]


def _total(attribute: str) -> Callable[[Any], float]:
    return lambda of: sum(attrgetter(attribute)(each) for each in of.checks)


@dataclass(frozen=True, eq=False)
class CheckedStage:
    """Check of one stage of a job with stages."""

    FIGURES: ClassVar = (
        Figure("stage", "", "Number of the stage.", "stage.number"),
        Figure("begin", "m", "Height of the nozzle from which on it prints.", name="from height"),
        Figure("exit_height", "m", "Height of its highest exit point.", "stage.exit_height"),
        Figure("layers", "1", "Number of its layers.", "check.toolpath.layer_count"),
        Figure("feasible", "", "Whether all that was checked is within its limits.", "check.feasible"),
        Figure("min_tension", "N", "Smallest tension, with the motion of the platform.", "lowest_tension", shown="N"),
        Figure("max_tension", "N", "Largest tension, with the motion of the platform.", "highest_tension", shown="N"),
        Figure("clearance", "m", "Smallest distance of a line from anything.", "check.nearest.margin", shown="mm"),
        Figure("expected_error", "m", "Expected error.", "check.expected.value", digits=3, shown="mm"),
        Figure("verdict", "", "The answer in words.", "check.verdict", detail=True),
    )  # fmt: skip

    stage: JobStage
    check: Check

    @property
    def begin(self) -> float:
        """Height of the nozzle at which the stage begins, m."""
        samples = self.check.samples
        return max(self.stage.begin, float(samples.positions[samples.extruding, 2].min()))

    @property
    def lowest_tension(self) -> float:
        """Smallest tension in the stage, N; NaN without an equilibrium."""
        return extreme(np.fmin, self.check.statics.lines.lowest_tension)

    @property
    def highest_tension(self) -> float:
        """Largest tension in the stage, N; NaN without an equilibrium."""
        return extreme(np.fmax, self.check.statics.lines.highest_tension)


@dataclass(frozen=True, eq=False, repr=False)
class StagedCheck(Result):
    """Result of a check of a job with stages; SI."""

    FIGURES: ClassVar = (
        Figure("feasible", "", "Whether all stages are within their limits, and the seams are as near as allowed."),
        Figure("verdict", "", "The answer in words."),
        Figure("not_checked", "", "Effects that the answer does not cover.", sentences=True),
        Figure("layers", "1", "Number of layers of the part.", _total("toolpath.layer_count")),
        Figure("extruded_length", "m", "Length of path on which material is laid.", _total("samples.extruded_length")),
        Figure("travel_length", "m", "Length of path on which none is laid.", _total("samples.travel_length")),
        Figure("duration", "s", "Duration of the job, without the moves of the exit points.", _total("law.duration")),
        Figure("min_tension", "N", "Smallest tension of all stages.", shown="N",
               value=lambda of: min(each.lowest_tension for each in of.stages)),
        Figure("max_tension", "N", "Largest tension of all stages.", shown="N",
               value=lambda of: max(each.highest_tension for each in of.stages)),
        Figure("stages", "", "Each stage.", parts=CheckedStage.FIGURES),
        Figure("seams", "", "Each seam: where a stage goes on upon the print of another.", parts=Seam.FIGURES),
    )  # fmt: skip
    HEADLINES: ClassVar = ("feasible", "layers", "duration")

    stages: tuple[CheckedStage, ...]
    seams: tuple[Seam, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """The check of each stage."""
        return tuple(each.check for each in self.stages)

    @property
    def feasible(self) -> bool:
        """Whether all that was checked is within its limits."""
        return all(each.feasible for each in self.checks) and all(each.holds for each in self.seams)

    @property
    def verdict(self) -> str:
        """Whether the robot can print the job in its stages, in a sentence."""
        wrong = [f"Stage {each.stage.number}: {each.check.verdict}" for each in self.stages if not each.check.feasible]
        wrong += [
            f"At {each.height:.3g} m stage {each.stage} is up to {spell_length(each.value)} from the print below; "
            f"{spell_length(each.allowed)} is allowed (max_seam)."
            for each in self.seams
            if not each.holds
        ]
        if wrong:
            return " ".join(wrong)
        robot, job = self.checks[0].robot.name, self.checks[0].job.name
        worst = max((each.value for each in self.seams), default=0.0)
        seams = f" At the seams both prints are within {spell_length(worst)} (95th percentile)." if self.seams else ""
        count = f"{len(self.stages)} stage{'s' if self.seams else ''}"
        return f"{robot} can print {job} in {count}. All samples are within the limits of their stage.{seams}"

    @property
    def not_checked(self) -> tuple[str, ...]:
        """Effects that the answer does not cover: of any stage, and of the moves between them."""
        moves = "the moves of the exit points themselves: the seam counts the errors that they leave"
        return tuple(dict.fromkeys([*(note for each in self.checks for note in each.not_checked), moves]))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on each stage, each once."""
        return tuple(dict.fromkeys(note for each in self.checks for note in each.notes))

    @property
    def refusal(self) -> str:
        """Reason why the job cannot be printed in its stages, in a sentence."""
        return "" if self.feasible else self.verdict


def check_stages(
    robot: Robot,
    job: Job | str | Path,
    records: Sequence[CalibrationRecord] = (),
    *,
    uncertainty: Uncertainty | None = None,
    seed: int = 0,
    **options: Any,
) -> StagedCheck:
    """Check a *job* with stages on *robot*: each stage as `check` does, and the seams between them.

    *records*: of the calibrations of the stages, in their order, for the seams; empty: exit points and home lengths of
    each stage are as uncertain as the robot's. *uncertainty*, *seed* and *options* are those of `check`. Raises
    `InputError` as `check`, and for stages and records that do not fit the robot or the part.
    """
    found = stages_of(robot, job if isinstance(job, Job) else load_job(job))
    if records and len(records) != len(found):
        raise InputError(f"records: {len(records)} are given; the job has {len(found)} stages, one record for each")
    for k, record in enumerate(records):
        if record in records[:k]:
            first = records.index(record) + 1
            raise InputError(f"records: stages {first} and {k + 1} have the same record: calibrate each stage again")
    own = uncertainty or robot.uncertainty or assumed_uncertainty(robot)
    checked = [
        CheckedStage(each, check(each.robot, each.job, uncertainty=uncertainty, seed=seed, **options)) for each in found
    ]
    seams = []
    for k in range(len(found) - 1):
        job, known = found[k].job, (records[k], records[k + 1]) if records else (None, None)
        allowed = job.allowed_seam(checked[k].check.beads.typical.width)
        seams.append(seam_of(found[k], found[k + 1], own, known, allowed=allowed, seed=seed))
    return StagedCheck(tuple(checked), tuple(seams))
