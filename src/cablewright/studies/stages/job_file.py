"""Writing of a job file with other stages: the original one with its comments, or a new one for bare G-code."""

from __future__ import annotations

from pathlib import Path

import tomlkit

from cablewright.printing.job import Job


def staged_job_text(file: Path, job: Job, out: Path) -> str:
    """Return the TOML text of the job in *file* with the stages of *job*, to be written to *out*.

    The G-code is named in full where *out* is in another folder.
    """
    if file.suffix.lower() == ".toml":
        table = tomlkit.parse(file.read_text(encoding="utf-8"))
    else:
        table = tomlkit.document()
        table.update({"schema": 1, "name": job.name, "gcode": file.name})
    if job.gcode is not None and out.resolve().parent != file.resolve().parent:
        table["gcode"] = str(job.gcode.resolve())
    stages = tomlkit.aot()
    for each in job.stages:
        stages.append(tomlkit.item(each.model_dump(mode="json", exclude_none=True)))
    table["stages"] = stages
    return tomlkit.dumps(table)
