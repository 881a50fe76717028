"""A job with stages printed in closed loop on a simulated machine: stage by stage, with a recalibration before each.

The run folder has a run folder for each stage, ``stage-1`` and so on, and before each but the first the folder of its
recalibration, ``stage-2-calibration``. A print that ends anywhere is resumed from these files.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Final, get_args

import numpy as np

from cablewright.calibration.drift.record import CalibrationRecord, load_record, record_path
from cablewright.foundation.choices import WhoRecalibrates
from cablewright.foundation.errors import AnswerError, InputError, UnknownName
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.units import spell_length
from cablewright.live.prints.plan import PrintOptions, Upon
from cablewright.live.prints.print_job import PrintedJob, print_job
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.job_stages import JobStage, stages_of
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.robot.files import file_text
from cablewright.robot.uncertainty import assumed_uncertainty
from cablewright.running import run_folders
from cablewright.studies.stages.recalibration import Recalibration, as_set
from cablewright.studies.stages.seam import Seam, seam_of

FINISHED: Final = "finished"


@dataclass(frozen=True, eq=False)
class PrintedStage:
    """A stage that was printed, or whose print has begun."""

    FIGURES: ClassVar = (
        Figure("stage", "", "Number of the stage.", "stage.number"),
        Figure("exit_height", "m", "Height of its highest exit point, as calibrated.", "stage.exit_height", digits=5),
        Figure("calibration", "", "Verdict of its calibration; null without a record.", "record.verdict"),
        Figure("status", "", "finished, or the state in which the print stopped.", "printed.status"),
        Figure("max_error_in_space", "m", "Largest distance from the path.", "printed.record.best.space.max",
               digits=3, shown="mm"),
        Figure("log", "", "File of its log.", "printed.log", detail=True),
        Figure("report", "", "File of its report.", "printed.report"),
    )  # fmt: skip

    stage: JobStage
    record: CalibrationRecord | None
    printed: PrintedJob


@dataclass(frozen=True, eq=False, repr=False)
class StagedPrint(Result):
    """A print in stages that has ended: finished, stopped in a stage, or waiting for a recalibration."""

    FIGURES: ClassVar = (
        Figure("status", "", "finished; recalibrate: before a stage; or the state in which a stage stopped."),
        Figure("reason", "", "What to do, or why a stage stopped; empty where it is finished."),
        Figure("stages", "", "Each stage that began.", parts=PrintedStage.FIGURES),
        Figure("seams", "", "Each seam, by the calibrations of its stages.", parts=Seam.FIGURES),
        Figure("folder", "", "Run folder.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "reason")

    folder: Path
    stages: tuple[PrintedStage, ...]
    seams: tuple[Seam, ...]
    status: str = FINISHED
    reason: str = ""

    @property
    def refusal(self) -> str:
        """Reason why the staged print did not finish, in a sentence."""
        return "" if self.status == FINISHED else f"{self.status}: {self.reason}"


def print_stages(
    robot: str | Path,
    job: str | Path,
    folder: str | Path,
    *,
    machine: TwinSettings | str | Path | None = None,
    options: PrintOptions | None = None,
    recalibration: WhoRecalibrates = "simulated",
    accept_doubtful: bool = False,
    resume: bool = False,
    real_time: bool = False,
    report: Callable[[PrintedJob], PrintedJob] = lambda printed: printed,
    progress: Progress | None = None,
) -> StagedPrint:
    """Print a *job* with stages on a simulated machine, as `print_job` does each of them, in a run *folder*.

    *robot* and *job* are files, or a robot of the library. Before each stage but the first its exit points are moved,
    and calibrated: *recalibration*. A doubtful calibration, and a seam that is larger than the job allows, end the
    print before the stage, unless *accept_doubtful*. *report* writes the report of each stage. *resume* continues in
    the folder, with the same files. Raises as `print_job`, and `InputError` for stages that do not fit.
    """
    if recalibration not in get_args(WhoRecalibrates):
        raise UnknownName("recalibration", recalibration, get_args(WhoRecalibrates))
    chosen, folder, described = options or PrintOptions(), Path(folder), load(str(robot))
    if folder.exists() and any(folder.iterdir()) and not resume:
        raise InputError(f"--out = {folder}: holds something already; --resume, or another folder")
    if resume and not (folder / "stage-1").is_dir():
        raise InputError(f"--resume: {folder} holds no print")
    whole = load_job(job)
    inputs = {"robot": run_folders.robot_hash(str(robot)), **run_folders.job_hashes(Path(job), whole)}
    beside = record_path(robot)
    record = load_record(beside) if Path(robot).suffix == ".toml" and beside.is_file() else None
    first = inputs if record is None else inputs | {"record": run_folders.file_hash(beside)}
    found = StagedPrint(folder, (), ())
    for stage in stages_of(described, whole):
        inside, upon = folder / f"stage-{stage.number}", Upon(stage.robot, None, first)
        if found.stages:
            before = found.stages[-1]
            last = before.printed.run.machine
            assert isinstance(last, SimulatedMachine)
            upon = Upon(as_set(stage, chosen.seed), last.rig.ground, inputs)
            work = Recalibration(folder / f"stage-{stage.number}-calibration", stage, file_text(str(robot)))
            work.prepare()
            why = ""
            if work.known() is None and recalibration == "simulated":
                why = work.simulate(as_built(upon.described, last.simulation.tolerances, chosen.seed), chosen.seed)
            known = work.known()
            if known is None:
                return replace(found, status="recalibrate", reason=why or work.steps)
            stage, record = replace(stage, robot=known[0]), known[1]
            files = {"calibrated": work.result, "record": record_path(work.result)}
            upon = replace(upon, inputs=inputs | {key: run_folders.file_hash(file) for key, file in files.items()})
            found, doubt = _with_seam(found, before, stage, record)
            if doubt and not accept_doubtful:
                return replace(found, status="recalibrate", reason=f"{doubt}; --accept-doubtful goes on as it is")
        begun = (inside / run_folders.MANIFEST).exists()
        printed = print_job(
            stage.robot,
            stage.job,
            inside,
            machine=machine,
            options=chosen,
            resume=resume and begun,
            real_time=real_time,
            progress=progress,
            upon=upon,
        )
        found = replace(found, stages=(*found.stages, PrintedStage(stage, record, report(printed))))
        if not printed.finished:
            return replace(found, status=printed.status, reason=f"stage {stage.number}: {printed.run.reason}")
    return found


def _with_seam(
    found: StagedPrint, before: PrintedStage, stage: JobStage, record: CalibrationRecord
) -> tuple[StagedPrint, str]:
    """Return the print with the seam to a calibrated *stage*, and what is doubtful of both; empty: nothing."""
    robot, job = before.stage.robot, before.stage.job
    uncertain = robot.uncertainty or assumed_uncertainty(robot)
    allowed = job.allowed_seam(job.typical_bead()[0].width)
    doubts = [] if record.verdict == "good" else [f"the calibration is {record.verdict}"]
    try:
        seam = seam_of(before.stage, stage, uncertain, (before.record, record), allowed=allowed)
    except (InputError, AnswerError) as error:
        doubts.append(f"the seam is unknown: {error}")
    else:
        found = replace(found, seams=(*found.seams, seam))
        if not seam.holds:
            value = spell_length(seam.value) if np.isfinite(seam.value) else "unknown"
            doubts.append(f"the seam is {value}, where {spell_length(allowed)} is allowed (max_seam)")
    return found, f"stage {stage.number}: {' and '.join(doubts)}" if doubts else ""
