"""Run folders and their files: each appears complete, by rename, or not at all."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Final

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import cannot_write
from cablewright.foundation.toml_input import read_bytes
from cablewright.printing.job import Job
from cablewright.robot import library_names, library_text

GROUP: Final = 32768  # rows of a file that are made at a time
MANIFEST: Final = "manifest.json"
_MAX_MANIFEST: Final = 1 << 20  # bytes


def folder_name(command: str, *names: str) -> str:
    """Return the name of a run folder from a *command* and any *names*: letters, digits and dashes only."""
    parts = [re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-") or "unnamed" for name in names]
    return "-".join([command, *parts])[:120]


def _refuse_foreign(folder: Path) -> None:
    """Raise `InputError` if *folder* holds anything but an earlier run, which a new one may replace."""
    if not folder.name:
        raise InputError(f"--out = {str(folder)!r}: a folder with a name of its own is expected")
    if not folder.exists() or (folder.is_dir() and (read_manifest(folder) or not any(folder.iterdir()))):
        return
    raise InputError(f"--out = {folder}: exists already and holds no earlier run; choose another folder")


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Return the manifest of the run in *folder*; None if it holds no run."""
    try:
        manifest = json.loads(read_bytes(folder / MANIFEST, _MAX_MANIFEST, "manifest"))
    except (InputError, ValueError, RecursionError):
        return None
    is_run = isinstance(manifest, dict) and {"schema", "command", "cablewright"} <= manifest.keys()
    return manifest if is_run else None


@contextmanager
def run_folder(folder: Path) -> Iterator[Path]:
    """Context with a temporary folder next to *folder*; it replaces *folder* when the block ends without error.

    Raises `InputError` if *folder* holds anything but an earlier run, `EnvironmentFault` if nothing can be written
    there. On an error nothing is left behind.
    """
    folder = folder.absolute()
    _refuse_foreign(folder)
    new_parent = not folder.parent.exists()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as reason:
        raise EnvironmentFault(f"{folder}: the run folder cannot be created: {reason.strerror or reason}") from None
    try:
        part = aside / "new"
        part.mkdir()
        yield part
        _take_place(part, folder, aside / "old")
    except OSError as reason:
        raise cannot_write(folder, reason) from None
    except EnvironmentFault as fault:  # it names a file in the folder that is about to be removed
        raise EnvironmentFault(str(fault).replace(str(part), str(folder))) from None
    finally:
        shutil.rmtree(aside, ignore_errors=True)
        if new_parent:
            with suppress(OSError):  # not empty: it holds this run or another
                folder.parent.rmdir()


def _take_place(part: Path, folder: Path, old: Path) -> None:
    """Rename *part* to *folder*; an earlier run is moved aside first, and back if that fails."""
    if folder.exists():
        folder.rename(old)
    try:
        part.rename(folder)
    except OSError:
        if old.exists():
            old.rename(folder)
        raise


def job_hashes(path: Path, job: Job) -> dict[str, str]:
    """Return SHA-256 hashes of the file of a *job*, and of its G-code if it has one."""
    files = {"job": path} | ({} if job.gcode is None else {"gcode": job.gcode})
    return {key: file_hash(file) for key, file in files.items()}


def manifest_of(command: str, inputs: Mapping[str, object], options: Mapping[str, object]) -> dict[str, Any]:
    """Return the identity of a run, as JSON values: *command*, hashes of its *inputs*, its *options*, the version."""
    run = {"schema": 1, "command": command, "cablewright": version("cablewright")}
    manifest: dict[str, Any] = json.loads(json.dumps(run | {"inputs": inputs, "options": options}, default=str))
    return manifest


def write_manifest(folder: Path, command: str, inputs: Mapping[str, str], options: Mapping[str, object]) -> None:
    """Write the manifest of a run, see `manifest_of`, to its unfinished *folder*."""
    (folder / MANIFEST).write_text(json.dumps(manifest_of(command, inputs, options), indent=2) + "\n")


def by_axis(points: Mapping[str, Array]) -> dict[str, Array]:
    """Return x, y and z of points or vectors (k, 3) as columns, named by a prefix and the axis."""
    return {f"{prefix}{axis}": values[:, k] for prefix, values in points.items() for k, axis in enumerate("xyz")}


def robot_hash(robot: str) -> str:
    """Return the SHA-256 hash of the file of a library robot, or of a file."""
    if robot in library_names():
        return hashlib.sha256(library_text(robot).encode()).hexdigest()
    return file_hash(Path(robot))


def file_hash(path: Path) -> str:
    """Return the SHA-256 hash of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
