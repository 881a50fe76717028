"""Uploaded jobs, each in its own folder; a job can name no file but its own G-code.

A folder has ``part.gcode`` or ``job.toml`` or both, and, once it was checked, ``check.json`` with the answer.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from shutil import rmtree
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import cannot_write, write_whole
from cablewright.foundation.toml_input import is_file, parse_table, read_bytes, require_schema
from cablewright.foundation.validation import validated
from cablewright.printing.job import Job
from cablewright.robot import Robot

GCODE: Final = "part.gcode"
JOB: Final = "job.toml"
CHECK: Final = "check.json"
ABOUT: Final = "about.json"

SCENE: Final = "scene.json"
"""File in a job's folder with the scene of its path, which its check writes before the answer."""

REPORT: Final = "report"
"""Folder of a check's report within that of its job."""

MAX_BYTES: Final = {GCODE: 64 << 20, JOB: 64 << 10}
"""Largest size of each file that is taken."""

_MAX_CHECK: Final = 1 << 20  # bytes
_NUMBER: Final = re.compile(r"[0-9a-f]{16}")


class JobCheck(BaseModel):
    """Result of the check of an uploaded job. ``subject`` identifies its robot and files."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    subject: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    answer: Literal["yes", "no", "failed"]
    why: Annotated[str, Field(max_length=4000)]
    has_report: bool = False
    expected_error: float | None = None
    """m, that 95 of 100 machines stay below; None where it was not stated."""

    duration: float | None = None
    """s, of the print at the planned speed."""

    section: float | None = None
    """m^2, of the typical strand."""

    robot: Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")] = ""
    """SHA-256 of the robot; empty: not kept, as by earlier versions."""

    def refusal(self, subject: str, confirmed: str, robot: str = "") -> str:
        """Return the reason why the job may not be loaded; empty: it may.

        *confirmed*: the subject that a person has read of. *subject* and *robot*: the present files and robot.
        """
        if self.answer == "failed":
            return f"its check did not come to an answer: {self.why}"
        if self.robot and robot and self.robot != robot:
            return "it was checked for another robot, or this one has changed since: check it again"
        if self.subject != subject:
            return "it was checked before its files or the robot changed: check it again"
        if self.answer == "no" and confirmed != subject:
            return f"its check said no, and no operator confirmed this: {self.why}"
        return ""


def folder_of(jobs: Path, number: str) -> Path:
    """Return the folder of a job. Raises `InputError` for an invalid number, or a link."""
    folder = jobs / number
    if not _NUMBER.fullmatch(number) or folder.is_symlink() or not folder.is_dir():
        raise InputError("there is no such job")
    return folder


def load_served(folder: Path, name: str) -> Job:
    """Return the uploaded job in *folder*; of G-code alone with the defaults.

    Its path is its own file, for any settings. Raises `InputError`: for settings that name another file too.
    """
    table: dict[str, object] = {"name": name}
    origin = name
    if is_file(folder / JOB):
        table = parse_table(read_bytes(folder / JOB, MAX_BYTES[JOB], "job").decode("utf-8", "replace"), JOB)
        require_schema(table, JOB)
        origin = JOB
    named = table.pop("gcode", None)
    if named is not None and not _is_plain(named):
        raise InputError(f"{JOB}: gcode = {str(named)[:80]!r}: names a path; the file that is sent with it is taken")
    own = is_file(folder / GCODE)
    if named is not None and not own:
        raise InputError(f"{JOB}: gcode = {named!r}: no G-code was sent with it")
    return validated(Job, table | ({"gcode": folder / GCODE} if own else {}), origin)


def _is_plain(named: object) -> bool:
    """Whether it is a file's name alone."""
    return isinstance(named, str) and named not in ("", ".", "..") and not set(named) & set("/\\\0")


def digest_of(robot: Robot) -> str:
    """Return the SHA-256 of a robot's description."""
    return hashlib.sha256(robot.model_dump_json().encode()).hexdigest()


def subject_of(folder: Path, robot: Robot) -> str:
    """Return the SHA-256 of the job's files and the robot: identifies the subject of a check. Raises `InputError`."""
    whole = hashlib.sha256(robot.model_dump_json().encode())
    for name, most in MAX_BYTES.items():
        data = read_bytes(folder / name, most, name) if is_file(folder / name) else b""
        whole.update(hashlib.sha256(data).digest())
    return whole.hexdigest()


def read_check(folder: Path) -> JobCheck | None:
    """Return the result of the job's check; None: none yet."""
    try:
        return JobCheck.model_validate_json(read_bytes(folder / CHECK, _MAX_CHECK, "check"))
    except (InputError, ValidationError):
        return None


def forget_check(folder: Path) -> None:
    """Remove result, scene and report of an earlier check, if there are any. Raises `EnvironmentFault`."""
    try:
        for name in (CHECK, SCENE):
            (folder / name).unlink(missing_ok=True)
        if (folder / REPORT).exists():
            rmtree(folder / REPORT)
    except OSError as reason:
        raise cannot_write(folder, reason) from None


def write_check(folder: Path, check: JobCheck) -> None:
    """Write the result of a job's check to its folder. Raises `EnvironmentFault`."""
    write_whole(folder / CHECK, check.model_dump_json().encode())
