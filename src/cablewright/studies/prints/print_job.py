"""A job printed closed-loop on a simulated machine, from its files to its record."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cablewright.machine.simulated.settings import MachineSettings
from cablewright.printing.job import Job, load_job
from cablewright.progress import Progress
from cablewright.results import Figure, Result
from cablewright.robot import Robot, load
from cablewright.studies import store
from cablewright.studies.prints.finish import finish, write_metrics
from cablewright.studies.prints.plan import MachineTwin, PrintOptions, twin_of
from cablewright.studies.prints.result import PrintRecord
from cablewright.studies.prints.run import PrintRun, run_print


@dataclass(frozen=True, eq=False, repr=False)
class PrintedJob(Result):
    """A print that ended: how, its record, and where its files are. ``metrics`` is what metrics.json holds."""

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "twin.robot.name"),
        Figure("machine", "", "Name of the machine's settings.", "twin.settings.name"),
        Figure("estimator", "", "Estimator of the machine's state.", "twin.estimator"),
        Figure("status", "", "finished, or the state in which the print stands."),
        Figure("max_error", "m", "Largest true distance beside the path.", "record.true.error.size"),
    )
    HEADLINES: ClassVar = ("robot", "machine", "status", "max_error")

    twin: MachineTwin
    run: PrintRun
    record: PrintRecord
    log: Path
    metrics: dict[str, Any]

    @property
    def finished(self) -> bool:
        """Whether the whole job was printed."""
        return self.run.finished

    @property
    def status(self) -> str:
        """finished, or the state in which the print stands."""
        return "finished" if self.run.finished else self.run.state.value

    @property
    def step_times(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """What each control step took by the clock, s."""
        return np.array(self.run.timing.wall)

    def to_dict(self) -> dict[str, Any]:
        """Return the metrics with the names of robot, machine and estimator, as JSON has them."""
        return {"robot": self.twin.robot.name, "machine": self.twin.settings.name} | {
            "estimator": self.twin.estimator,
            **self.metrics,
        }

    def with_report(self, page: Path) -> PrintedJob:
        """Return the same with the path of its report in the metrics, which are written anew."""
        metrics = _metrics(self.run, self.record, self.log, self.status, page)
        return dataclasses.replace(self, metrics=metrics)


def print_job(
    robot: Robot | str | Path,
    job: Job | str | Path,
    folder: str | Path,
    *,
    machine: MachineSettings | str | Path | None = None,
    options: PrintOptions | None = None,
    resume: bool = False,
    real_time: bool = False,
    progress: Progress | None = None,
) -> PrintedJob:
    """Print a *job* closed-loop on a simulated machine, in a run *folder* from which it goes on after whatever ends it.

    *robot* is a robot, a library name or a file; *job* one or a file; *machine* the settings of a simulated machine, a
    library name or a file (default: that of the robot's name). *resume* goes on with the print in the folder, which has
    to be the same. With *real_time* each step waits for its time. A print that stops by itself is an answer: see
    ``status`` and ``run.reason``. Raises `InputError`, `AnswerError` where the path cannot be held, `EnvironmentFault`.
    """
    described = robot if isinstance(robot, Robot) else load(str(robot))
    wanted = job if isinstance(job, Job) else load_job(job)
    chosen = options or PrintOptions()
    twin = twin_of(described, wanted, machine, chosen)
    inputs = {} if isinstance(robot, Robot) else {"robot": store.robot_hash(str(robot))}
    inputs |= {} if isinstance(job, Job) else store.job_hashes(Path(job), wanted)
    told = {key: value for key, value in dataclasses.asdict(chosen).items() if key != "lasers"}
    told |= {"machine": twin.settings.model_dump(mode="json")}
    run = run_print(twin, Path(folder), inputs, told, resume=resume, real_time=real_time, progress=progress)
    track, ground = twin.path.track, run.machine.rig.ground.field
    record, log = finish(run.folder, track, twin.path.print_speed, ground, progress)
    status = "finished" if run.finished else run.state.value
    return PrintedJob(twin, run, record, log, _metrics(run, record, log, status, None))


def _metrics(run: PrintRun, record: PrintRecord, log: Path, status: str, page: Path | None) -> dict[str, Any]:
    """Write metrics.json; return what it holds."""
    more: dict[str, object] = {"status": status, "reason": run.reason, "log": str(log)}
    return write_metrics(run.folder, record, run.timing, more | {"report": None if page is None else str(page)})
