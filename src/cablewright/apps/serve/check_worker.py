"""Process that checks jobs and writes reports of runs, with limits of time, memory and files.

`python -m cablewright.apps.serve.check_worker check FOLDER JOB`, `report FOLDER RUN`, or `guide FOLDER calibration` and
`accept`. Ends with its standard input.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from cablewright.apps.serve import camera_folder
from cablewright.apps.serve.uploads import MAX_JOBS, MAX_TOTAL, METRICS, Uploads
from cablewright.foundation.errors import CablewrightError, InputError
from cablewright.foundation.file_output import whole_folder, write_whole
from cablewright.live.serve.control_process import STATION
from cablewright.live.serve.control_process import write_station as write_station
from cablewright.live.serve.jobs import (
    GCODE,
    JOB,
    REPORT,
    SCENE,
    JobCheck,
    digest_of,
    load_served,
    subject_of,
    write_check,
)

if TYPE_CHECKING:
    from cablewright.models.job_stages import JobStage
    from cablewright.printing.job import Job
    from cablewright.robot import Robot

STAGE: Final = "stage.toml"
"""File in the folder of a stage's job with the robot whose exit points are to be set before it."""

MEMORY: Final = 8 << 30
"""Bytes of address space that a check may take."""

TIME: Final = 1200
"""Processor time that a check may take, s."""

_FILE: Final = 1 << 30  # bytes of a file that it writes
_NICE: Final = 15
_NAME: Final = 300  # letters of a job's
_TABLE: Final = 64 << 10  # bytes of a stage's settings beyond those of the job


def cap() -> None:
    """Limit the memory and processor time of this process, where the operating system has such limits."""
    try:
        import resource
    except ImportError:  # pragma: no cover
        return
    for kind, most in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, TIME), (resource.RLIMIT_FSIZE, _FILE)):
        _, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    os.nice(_NICE)


def _end_with_input() -> None:
    while os.read(0, 1024):  # not by sys.stdin, whose lock the interpreter wants as it ends
        pass
    os._exit(1)


def station_of(folder: Path) -> Any:
    """Return the robot and the machine's settings of a served folder."""
    from cablewright.machine.settings import MachineSettings
    from cablewright.robot import Robot

    found = json.loads((folder / STATION).read_bytes())
    return Robot.model_validate_json(found["robot"]), MachineSettings.model_validate_json(found["machine"])


def _staged(uploads: Uploads, number: str, robot: Robot, job: Job) -> str:
    """Send those stages of a job that are not there as jobs of their own; return the next steps, in words.

    Each later one has the robot's file with the exit points of its stage, as they are to be set. Raises `InputError`
    where there is no room for all.
    """
    from cablewright.models.job_stages import stages_of

    stages = stages_of(robot, job)
    for each in uploads.jobs({}):
        if each["of"] == number and "settings" not in each["parts"]:  # cut off while it was made
            uploads.remove(each["id"])
    kept = uploads.jobs({})
    there = {each["stage"] for each in kept if each["of"] == number}
    missing = [stage for stage in reversed(stages) if stage.number not in there]
    own = next(each for each in kept if each["id"] == number)
    jobs, size = len(kept) + len(missing), sum(each["bytes"] for each in kept) + len(missing) * (own["bytes"] + _TABLE)
    if missing and (jobs > MAX_JOBS or size > MAX_TOTAL):
        raise InputError(f"its {len(stages)} stages are jobs of their own, for which there is no room: remove some")
    for stage in missing:
        _send_stage(uploads, number, stage, f"stage {stage.number} of {len(stages)}: {job.name}"[:_NAME])
    return (
        f"it has {len(stages)} stages, which are jobs of their own now: check and print them in order; before each "
        "later one set the exit points, press its button, and calibrate by camera"
    )


def _send_stage(uploads: Uploads, number: str, stage: JobStage, name: str) -> None:
    """Send a stage of a job; its settings come last: then it is whole."""
    import tomlkit

    from cablewright.apps.serve.camera_folder import robot_text

    own, made = uploads.job(number), uploads.new_job(name, of=number, stage=stage.number)
    table = tomlkit.parse((own / JOB).read_text())
    del table["stages"]
    table |= {"name": name, "heights": list(stage.job.heights or ())}
    try:
        if stage.number > 1:
            write_whole(uploads.job(made) / STAGE, robot_text(stage.robot).encode())
        if (own / GCODE).is_file():
            uploads.put_whole(made, "gcode", (own / GCODE).read_bytes())
        uploads.put_whole(made, "settings", tomlkit.dumps(table).encode())
    except CablewrightError:
        uploads.remove(made)
        raise


def check_job(folder: Path, number: str) -> JobCheck:
    """Check a job; write its scene, its answer and its report.

    Raises `EnvironmentFault`, and `CablewrightError` where the report fails: the answer stands without it.
    """
    uploads = Uploads(folder)
    own = uploads.job(number)
    robot, owner = station_of(folder)
    subject = subject_of(own, robot)
    try:
        job = load_served(own, uploads.name(number))  # what is no job is rejected before the rest is imported
        if job.stages:
            raise InputError(_staged(uploads, number, robot, job))
        if job.robot not in (None, robot.name):
            raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {robot.name!r}")

        from cablewright.apps.report import check as report
        from cablewright.apps.serve.live_scene import live_scene
        from cablewright.machine.log.head import LogHead
        from cablewright.printing.layers import layer_table
        from cablewright.studies.checks.check import check

        found = check(robot, job)
        error = found.expected.value if found.expected is not None else float("inf")
        answer = JobCheck(
            subject=subject,
            answer="yes" if found.feasible else "no",
            why=found.verdict[:4000],
            expected_error=error if isfinite(error) else None,
            duration=found.law.duration,
            section=found.beads.typical.section,
            robot=digest_of(robot),
        )
        scene = live_scene(LogHead(robot, owner, owner.period), job)
        write_whole(own / SCENE, json.dumps(scene, allow_nan=False).encode())  # a print may begin with the answer
    except CablewrightError as error:
        answer = JobCheck(subject=subject, answer="failed", why=str(error)[:4000])
        write_check(own, answer)
        return answer
    write_check(own, answer)  # before its report, which takes as long again
    with whole_folder(own / REPORT) as part:
        report.write(found, part, layer_table(found.samples, found.law))
    answer = answer.model_copy(update={"has_report": True})
    write_check(own, answer)
    return answer


def report_run(folder: Path, name: str) -> None:
    """Write the report of a run. Raises `CablewrightError`."""
    from cablewright.analyses.travel_moves import driven_job
    from cablewright.apps.report import print as report
    from cablewright.live.prints.limits import path_of
    from cablewright.live.prints.record import finish
    from cablewright.live.prints.run import alone_in

    uploads = Uploads(folder)
    run, number = uploads.run_folder(name), uploads.job_of_run(name)
    robot, owner = station_of(folder)
    job, samples = driven_job(robot, load_served(uploads.job(number), uploads.name(number)))
    path = path_of(robot, job, samples, owner, "encoders")
    with alone_in(run):
        record, _ = finish(run, path.track, path.print_speed, attitude=path.attitude)
        report.write(record, run, job.name)
        write_whole(run / METRICS, json.dumps(record.to_dict(), allow_nan=False, default=str).encode())


def main(arguments: list[str]) -> int:
    """Run one check of a job, or write one report."""
    what, folder, subject = arguments
    cap()
    threading.Thread(target=_end_with_input, daemon=True).start()
    try:
        if what == "check":
            check_job(Path(folder), subject)
        elif what == "report":
            report_run(Path(folder), subject)
        else:
            of_calibration = {"guide": camera_folder.guide_next, "accept": camera_folder.accept}[what]
            of_calibration(Path(folder) / subject, station_of(Path(folder))[0])
    except CablewrightError as error:
        print(error, file=sys.stderr)
        return 1
    except MemoryError:
        print("there is not enough memory for this", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
