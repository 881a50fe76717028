"""A job printed in closed loop on a simulated machine, from its files to its record."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cablewright.arrays import Array
from cablewright.file_output import write_whole
from cablewright.machine.simulated.settings import MachineSettings
from cablewright.printing.job import Job, load_job
from cablewright.progress import Progress
from cablewright.results import Figure, Result
from cablewright.robot import Robot, load
from cablewright.studies import store
from cablewright.studies.prints.metrics import metrics_text
from cablewright.studies.prints.plan import MachineTwin, PrintOptions, twin_of
from cablewright.studies.prints.record import finish
from cablewright.studies.prints.result import PrintRecord
from cablewright.studies.prints.run import PrintRun, run_print


@dataclass(frozen=True, eq=False, repr=False)
class PrintedJob(Result):
    """A print that has ended: its final state, its record and its log. ``metrics``: content of metrics.json."""

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
        """``finished``, or the state in which the print stopped."""
        return self.run.status

    @property
    def step_times(self) -> Array:
        """Duration of each control step by the wall clock, (k,) s."""
        return np.array(self.run.timing.wall)

    def to_dict(self) -> dict[str, Any]:
        """Return the metrics with the names of robot, machine and estimator, as JSON has them."""
        twin = self.twin
        return {"robot": twin.robot.name, "machine": twin.settings.name, "estimator": twin.estimator, **self.metrics}

    def with_report(self, page: Path) -> PrintedJob:
        """Return the same with the path of its report in the metrics, and write metrics.json again."""
        return replace(self, metrics=_written_metrics(self.run, self.record, self.log, page))


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
    """Print a *job* in closed loop on a simulated machine, in a run *folder* from which the print can be resumed.

    *robot* is a robot, a library name or a file; *job* a job or a file; *machine* the settings of a simulated machine,
    a library name or a file (default: the library machine of the robot's name). *resume* resumes the print in the
    folder, which must have the same inputs and options. With *real_time* each step waits for its time. A print that
    the machine stops is not an error: see ``status`` and ``run.reason``.

    Raises `InputError`, `AnswerError` where the platform cannot be held on the path, `EnvironmentFault` where the
    folder cannot be written.
    """
    described = robot if isinstance(robot, Robot) else load(str(robot))
    loaded = job if isinstance(job, Job) else load_job(job)
    chosen = options or PrintOptions()
    twin = twin_of(described, loaded, machine, chosen)
    inputs = {} if isinstance(robot, Robot) else {"robot": store.robot_hash(str(robot))}
    inputs |= {} if isinstance(job, Job) else store.job_hashes(Path(job), loaded)
    settings = asdict(chosen) | {"machine": twin.settings.model_dump(mode="json")}
    del settings["lasers"]
    run = run_print(twin, Path(folder), inputs, settings, resume=resume, real_time=real_time, progress=progress)
    structure = run.machine.rig.ground.field
    record, log = finish(run.folder, twin.path.track, twin.path.print_speed, structure, progress)
    return PrintedJob(twin, run, record, log, _written_metrics(run, record, log))


def _written_metrics(run: PrintRun, record: PrintRecord, log: Path, page: Path | None = None) -> dict[str, Any]:
    """Write metrics.json; return its content."""
    of_run = {"step_time": run.timing.statistics(), "status": run.status, "reason": run.reason}
    text = metrics_text(record, of_run | {"log": log, "report": page})
    write_whole(run.folder / "metrics.json", text.encode())
    values: dict[str, Any] = json.loads(text)
    return values
