"""A job printed in closed loop on a simulated machine, from its files to its record."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Result
from cablewright.live.estimators import DeadReckoning
from cablewright.live.prints.plan import PrintOptions, Upon, twin_of
from cablewright.live.prints.record import finish
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.run import PrintRun, alone_in, run_print
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cablewright.running import run_folders

SCHEMA: Final = 3
"""Version of metrics.json."""

_STEP_TIME: Final = (
    Figure("count", "1", "Number of steps of control."),
    Figure("mean", "s", "Mean duration by the wall clock."),
    Figure("p99", "s", "99 % quantile of the duration by the wall clock."),
    Figure("max", "s", "Largest duration by the wall clock."),
    Figure("processor_mean", "s", "Mean processor time."),
    Figure("processor_p99", "s", "99 % quantile of the processor time."),
    Figure("processor_max", "s", "Largest processor time."),
    Figure("over", "1", "Number of steps longer than the period by the wall clock."),
    Figure("over_by_itself", "1", "Number of steps longer than the period by processor time."),
    Figure("late", "1", "Number of steps that ended late; of a real-time print only."),
    Figure("latest", "s", "Largest delay of a step; of a real-time print only."),
)


@dataclass(frozen=True, repr=False)
class LearntLine(Result):
    """Corrections of one line learnt at measured positions, with sigmas; see `estimation.length_corrections`."""

    FIGURES: ClassVar = (
        Figure("name", "", "Name of the line.", name="line"),
        Figure("share", "1", "Share of its length by which it is longer than was counted.", shown="%", digits=3),
        Figure("share_sigma", "1", "Standard deviation of that share.", name="its sigma", shown="%", digits=2),
        Figure("creep", "1/N", "Further creep after an hour, besides that of the robot file.", digits=3),
        Figure("creep_sigma", "1/N", "Standard deviation of that creep.", name="sigma of that", digits=2),
        Figure("mount", "m/N", "Further compliance of the mount of its exit point, besides that of the robot file.",
               digits=3),
        Figure("mount_sigma", "m/N", "Standard deviation of that compliance.", name="and of that", digits=2),
    )  # fmt: skip

    name: str
    share: float
    share_sigma: float
    creep: float  # 1/N
    creep_sigma: float
    mount: float  # m/N
    mount_sigma: float


@dataclass(frozen=True, eq=False, repr=False)
class PrintedJob(Result):
    """Result of a print that has ended: final state, record, and paths of its log and report."""

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "record.head.robot.name"),
        Figure("machine", "", "Name of the machine's settings.", "record.head.settings.name"),
        Figure("estimator", "", "Estimator of the machine's state: filter, paper or encoders."),
        Figure("status", "", "finished, or the state in which the print stopped."),
        Figure("reason", "", "Why the print stopped; empty where it is finished.", "run.reason", detail=True),
        *(each.of_part("record") for each in PrintRecord.FIGURES),
        Figure("step_time", "s", "Duration of the steps of control.", lambda of: of.run.timing.statistics(),
               parts=_STEP_TIME, detail=True),
        Figure("learnt", "", "What measured places taught of each line, where they were to teach.",
               parts=LearntLine.FIGURES, only=lambda of: bool(of.learnt)),
        Figure("log", "", "File of the joined log."),
        Figure("report", "", "File of the report; null where none was written."),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "machine", "status", "max_path_error")

    estimator: str
    run: PrintRun
    record: PrintRecord
    log: Path
    report: Path | None = None

    @property
    def learnt(self) -> tuple[LearntLine, ...]:
        """Corrections of each line learnt at measured positions; empty without learning."""
        printer = self.run.printer
        learnt = printer.estimator.learnt if isinstance(printer.estimator, DeadReckoning) else None
        if learnt is None:
            return ()
        pairs = np.stack([learnt.used, learnt.known.sigmas], axis=-1).reshape(len(learnt.hour), -1).tolist()
        lines = printer.plan.velocity.model.robot.lines
        return tuple(LearntLine(line.name, *each) for line, each in zip(lines, pairs, strict=True))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on properties of the path that the job does not have, and on errors of the log."""
        return (*self.run.printer.plan.notes, *self.record.notes)

    @property
    def refusal(self) -> str:
        """Sentence with the reason if the print was not finished."""
        return "" if self.finished else f"{self.status}: {self.run.reason}"

    @property
    def finished(self) -> bool:
        """Whether the whole job was printed."""
        return self.run.finished

    @property
    def status(self) -> str:
        """``finished``, or the state in which the print stopped."""
        return self.run.status

    @property
    def step_times(self) -> Array:
        """Duration of each control step by the wall clock, (k,) s."""
        return np.array(self.run.timing.wall)

    def with_report(self, page: Path) -> PrintedJob:
        """Return the print with the path of its report, and write metrics.json again."""
        return replace(self, report=page).written()

    def written(self) -> PrintedJob:
        """Write metrics.json to the run folder. Raises `EnvironmentFault`."""
        text = json.dumps({"schema": SCHEMA} | self.to_dict(), indent=1, allow_nan=False)
        write_whole(self.run.folder / "metrics.json", f"{text}\n".encode())
        return self


def print_job(
    robot: Robot | str | Path,
    job: Job | str | Path,
    folder: str | Path,
    *,
    machine: TwinSettings | str | Path | None = None,
    options: PrintOptions | None = None,
    resume: bool = False,
    restart: bool = False,
    real_time: bool = False,
    progress: Progress | None = None,
    upon: Upon | None = None,
) -> PrintedJob:
    """Print a *job* in closed loop on a simulated machine, in a run *folder* from which the print can be resumed.

    *robot* is a robot, a library name or a file; *job* a job or a file; *machine* the settings of a simulated machine,
    a library name or a file (default: the library machine of the robot's name). *resume* resumes the print in the
    folder, which must have the same inputs and options; *restart* prints it again from the beginning. With *real_time*
    each step waits for its time. *upon*: what a stage goes on from. A print that the machine stops is not an error: see
    ``status`` and ``run.reason``.

    Raises `InputError`, `AnswerError` where the platform cannot be held on the path, `EnvironmentFault` where the
    folder cannot be written.
    """
    described = robot if isinstance(robot, Robot) else load(str(robot))
    loaded = job if isinstance(job, Job) else load_job(job)
    chosen = options or PrintOptions()
    twin = replace(twin_of(described, loaded, machine, chosen), upon=upon)
    inputs = {} if isinstance(robot, Robot) else {"robot": run_folders.robot_hash(str(robot))}
    inputs |= {} if isinstance(job, Job) else run_folders.job_hashes(Path(job), loaded)
    inputs |= {} if upon is None else upon.inputs
    settings = asdict(chosen) | {"machine": twin.settings.model_dump(mode="json")}
    del settings["lasers"]
    run = run_print(
        twin, Path(folder), inputs, settings, resume=resume, restart=restart, real_time=real_time, progress=progress
    )
    assert isinstance(run.machine, SimulatedMachine)
    structure = run.machine.rig.ground.field
    with alone_in(run.folder):  # no process resumes the print while its log is joined
        record, log = finish(
            run.folder, twin.path.track, twin.path.print_speed, structure, progress, twin.path.attitude, run.record
        )
        run.record = None
        return PrintedJob(twin.estimator, run, record, log).written()
