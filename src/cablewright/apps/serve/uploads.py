"""Folders of uploaded jobs and of their runs; the server chooses their names, so that no user's name is a path."""

from __future__ import annotations

import asyncio
import json
import re
import secrets
import shutil
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from stat import S_ISREG
from typing import Any, Final

from cablewright.apps.serve.operators import person
from cablewright.foundation.errors import InputError, printable
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.toml_input import read_bytes
from cablewright.live.prints.run import CHECKPOINT
from cablewright.live.serve.control_process import JOBS, RUN, RUNS
from cablewright.live.serve.jobs import ABOUT, GCODE, JOB, MAX_BYTES, REPORT, folder_of, read_check
from cablewright.running.run_folders import read_manifest

MAX_JOBS: Final = 60
"""Jobs that are kept at a time."""

MAX_TOTAL: Final = 1 << 30
"""Bytes of all jobs together."""

PARTS: Final = {"gcode": GCODE, "settings": JOB}
"""Files of a job, by the last part of their address."""

PAGE: Final = "report.html"
FAILED: Final = "report-failed"

DRAINED: Final = 1 << 30
"""Bytes of a file that is too large that are read, so that its sender sees the answer."""

NOTES: Final = "notes.txt"
MAX_NOTES: Final = 2000
"""Largest number of letters of a person's note on a run."""

METRICS: Final = "metrics.json"
_RESULTS: Final = ("max_error_in_space", "max_path_error", "max_height_error", "duration")
_WEAR: Final = ("name", "wound", "hours")  # of each line
_MAX_REPORT: Final = 64 << 20  # bytes
_SMALL: Final = 1 << 20  # bytes of a file of ours
_RUN: Final = re.compile(r"\d{8}-\d{6}-[a-z0-9-]{1,60}")
_MOST_RUNS: Final = 200  # that are listed


class TooLarge(InputError):
    """Error: the upload is larger than allowed."""


@dataclass(eq=False)
class Uploads:
    """The jobs and runs in the folder of the operator's page."""

    folder: Path

    def new_job(self, name: object, **about: object) -> str:
        """Make the folder of a new job; return its number. Raises `InputError` where there are too many.

        *about*: details of a job that a slicer has sent: ``file``, its name in the slicer; ``by``, the slicer's key;
        ``wants_print``.
        """
        jobs = self.folder / JOBS
        kept = [each for each in jobs.iterdir() if each.is_dir()]
        if len(kept) >= MAX_JOBS:
            raise InputError(f"there are {len(kept)} jobs already; at most {MAX_JOBS} are kept: remove one")
        number = secrets.token_hex(8)
        (jobs / number).mkdir(mode=0o700)
        written = {"name": person(name) or "job", "utc": time.time()} | about
        write_whole(jobs / number / ABOUT, json.dumps(written).encode())
        return number

    async def put(self, number: str, part: str, data: AsyncIterator[bytes]) -> int:
        """Write a file of a job from an upload; return its size. Raises `InputError`, `TooLarge` by name."""
        folder, name = self.job(number), PARTS[part]
        if (folder / name).exists():
            raise InputError(f"{part}: was sent already; upload a changed file as a new job")
        room = await asyncio.to_thread(self._room, name)
        whole, size = bytearray(), 0
        async for piece in data:  # to its end, so that whoever sends it reads the answer
            size += len(piece)
            if size <= room:
                whole += piece
            else:
                whole.clear()
            if size > DRAINED:
                break
        self._require_room(number, part, size, room)
        await asyncio.to_thread(write_whole, folder / name, bytes(whole))
        return size

    def put_whole(self, number: str, part: str, content: bytes) -> None:
        """Write a file of a new job. Raises `InputError`, `TooLarge`, `EnvironmentFault`."""
        name = PARTS[part]
        self._require_room(number, part, len(content), self._room(name))
        write_whole(self.job(number) / name, content)

    def _room(self, name: str) -> int:
        """Bytes that a file of that name may have now."""
        return min(MAX_BYTES[name], MAX_TOTAL - self._size())

    def _require_room(self, number: str, part: str, size: int, room: int) -> None:
        if size > room:
            most = MAX_BYTES[PARTS[part]]
            limit = f"at most {most >> 10} KiB" if room == most else "no more room for jobs: remove one"
            raise TooLarge(f"{part} of {self.name(number)!r}: too large; {limit}")
        if not size:
            raise InputError(f"{part} of {self.name(number)!r}: is empty")

    def remove(self, number: str) -> None:
        """Remove a job. Raises `InputError` for a job that does not exist."""
        shutil.rmtree(self.job(number))

    def job(self, number: str) -> Path:
        """Return the folder of a job. Raises `InputError`."""
        return folder_of(self.folder / JOBS, number)

    def name(self, number: str) -> str:
        """Return the name of a job that the page shows."""
        return str(_values(self.job(number) / ABOUT).get("name", number))[:40]

    def jobs(self, busy: dict[str, str]) -> list[dict[str, Any]]:
        """Return all jobs, the newest first. *busy*: the present task of each, by number."""
        found = []
        for folder in (self.folder / JOBS).iterdir():
            about = _values(folder / ABOUT)
            if not about or folder.is_symlink():
                continue
            check = read_check(folder)
            found.append({
                "id": folder.name,
                "name": str(about.get("name", ""))[:40],
                "utc": about.get("utc", 0.0),
                "file": str(about.get("file", "")),
                "by": str(about.get("by", "")),
                "wants_print": about.get("wants_print") is True,
                "of": str(about.get("of", "")),  # a job with stages, of which it is one
                "stage": about.get("stage", 0),
                "parts": [part for part, name in PARTS.items() if (folder / name).is_file()],
                "has_picture": about.get("has_picture") is True,
                "bytes": sum(_bytes(folder / name) for name in PARTS.values()),
                "busy": busy.get(folder.name, ""),  # with a check: its report is written still
                "check": None if check is None else check.model_dump(),
            })  # fmt: skip
        return sorted(found, key=lambda each: -each["utc"])

    def runs(self, busy: dict[str, str], most: int = _MOST_RUNS) -> list[dict[str, Any]]:
        """Return the newest runs, at most *most*, the newest first."""
        found = []
        folders = sorted((each for each in (self.folder / RUNS).iterdir() if _RUN.fullmatch(each.name)), reverse=True)
        for folder in folders[:most]:
            about = _values(folder / RUN)
            found.append({
                "name": folder.name,
                "status": about.get("status", "runs, or was cut off"),
                "reason": about.get("reason", ""),
                "late": {"up_to": about.get("late_up_to"), "counts": about.get("late")},
                "laid": about.get("laid"),
                "cut_off": not about,
                "can_resume": _can_resume(folder, about),
                "has_report": _time(folder / PAGE) > _time(folder / RUN),
                "notes": _text(folder / NOTES),
                **_before_and_after(folder),
                "busy": busy.get(folder.name, ""),
            })  # fmt: skip
        return found

    def keep_notes(self, name: str, text: str) -> str:
        """Save a person's note on a run; return it. Raises `InputError`, `EnvironmentFault`."""
        kept = "\n".join(printable(line.rstrip()) for line in text[:MAX_NOTES].splitlines()).strip()
        write_whole(self.run_folder(name) / NOTES, kept.encode())
        return kept

    def unreported(self) -> list[str]:
        """Return runs that have ended without a report, for which none was tried."""
        return [
            each["name"]
            for each in self.runs({})
            if each["late"]["counts"] is not None
            and not each["has_report"]
            and _time(self.folder / RUNS / each["name"] / FAILED) <= _time(self.folder / RUNS / each["name"] / RUN)
        ]

    def run_folder(self, name: str) -> Path:
        """Return the folder of a run. Raises `InputError`."""
        folder = self.folder / RUNS / name
        if not _RUN.fullmatch(name) or folder.is_symlink() or not folder.is_dir():
            raise InputError("there is no such run; its folder may have been removed")
        return folder

    def job_report(self, number: str) -> bytes:
        """Return the report page of a job's check. Raises `InputError`."""
        return read_bytes(self.job(number) / REPORT / PAGE, _MAX_REPORT, "report")

    def run_report(self, name: str) -> bytes:
        """Return the report page of a run. Raises `InputError`."""
        return read_bytes(self.run_folder(name) / PAGE, _MAX_REPORT, "report")

    def job_of_run(self, name: str) -> str:
        """Return the number of a run's job. Raises `InputError`."""
        manifest = read_manifest(self.run_folder(name))
        if manifest is None or not isinstance(manifest.get("inputs"), dict):
            raise InputError(f"run {name}: its manifest is missing")
        return str(manifest["inputs"].get("job"))

    def resumed(self, name: str) -> tuple[str, str]:
        """Return number and subject of the job of a run that can be resumed. Raises `InputError`."""
        folder, job = self.run_folder(name), self.job_of_run(name)
        if not _can_resume(folder, _values(folder / RUN)):
            raise InputError(f"run {name}: is finished, or was cut off before its first checkpoint: print it again")
        self.job(job)
        return job, str((read_manifest(folder) or {})["inputs"].get("subject"))

    def _size(self) -> int:
        return sum(_bytes(each) for each in (self.folder / JOBS).glob("*/*"))


def _before_and_after(folder: Path) -> dict[str, Any]:
    """What was checked of the job of a run, and what came of it: name, verdict and expected error; measured errors."""
    inputs = (read_manifest(folder) or {}).get("inputs")
    checked = inputs.get("check") if isinstance(inputs, dict) else None
    found = _values(folder / METRICS)
    lines = found.get("lines")
    return {
        "check": checked if isinstance(checked, dict) else None,
        "result": {name: found[name] for name in _RESULTS if isinstance(found.get(name), int | float)},
        "wear": [{key: line.get(key) for key in _WEAR} for line in lines] if isinstance(lines, list) else [],
    }


def _can_resume(folder: Path, about: dict[str, Any]) -> bool:
    """Whether a run, which ended as *about* says, if it did, has more of its path to print from a checkpoint."""
    return about.get("status") != "finished" and (folder / CHECKPOINT).is_file()


def _time(path: Path) -> float:
    """When a file was written, s; 0 where there is none."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _bytes(path: Path) -> int:
    """Size of a file; 0 where it is none, or was removed just now."""
    try:
        about = path.stat()
    except OSError:
        return 0
    return about.st_size if S_ISREG(about.st_mode) else 0


def _text(path: Path) -> str:
    """The text in a small file of ours; empty where there is none."""
    try:
        return read_bytes(path, _SMALL, "file").decode("utf-8", "replace")
    except InputError:
        return ""


def _values(path: Path) -> dict[str, Any]:
    """The JSON object in a file of ours; empty where there is none."""
    try:
        found = json.loads(read_bytes(path, _SMALL, "file"))
    except (InputError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
