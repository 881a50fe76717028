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

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import EnvironmentFault, InputError
from cablewright.file_output import cannot_write
from cablewright.models.coil import TURN
from cablewright.models.drum import drum_of
from cablewright.paging import blocks, let_go
from cablewright.printing.job import Job
from cablewright.robot import library_names, library_text
from cablewright.studies.accuracy import AccuracyStudy
from cablewright.studies.checks.result import Check
from cablewright.toml_input import read_bytes

GROUP: Final = 32768  # rows of a file that are made at a time
MANIFEST: Final = "manifest.json"
_MAX_MANIFEST: Final = 1 << 20  # bytes


def folder_name(command: str, *names: str) -> str:
    """Return a folder's name from a *command* and any *names*: letters, digits and dashes only."""
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
    """Yield a temporary folder beside *folder* to write to; it replaces *folder* when the block ends without error.

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
        raise EnvironmentFault(f"{folder}: the run folder cannot be made: {reason.strerror or reason}") from None
    try:
        part = aside / "new"
        part.mkdir()
        yield part
        _take_place(part, folder, aside / "old")
    except OSError as reason:
        raise cannot_write(folder, reason) from None
    except EnvironmentFault as fault:  # it names a file in what is about to be removed
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


def write_check(
    check: Check,
    folder: Path,
    robot: str,
    job: Path,
    options: Mapping[str, object] | None = None,
    uncertainty: Path | None = None,
) -> None:
    """Write samples.parquet, lengths.csv and the manifest of a check to an existing folder.

    *robot*: library name or file. *options*: those that changed the answer. *uncertainty*: its file, if one was given.
    """
    names = [line.name for line in check.robot.lines]
    _write_samples(check, names, folder / "samples.parquet")
    _write_lengths(check, names, folder / "lengths.csv")
    inputs = {"robot": robot_hash(robot)} | job_hashes(job, check.job)
    if uncertainty is not None:
        inputs["uncertainty"] = file_hash(uncertainty)
    write_manifest(folder, "check", inputs, options or {})


def _turns(check: Check, at: slice) -> dict[str, Array]:
    """Return the turns of each drum since the first sample, positive as it pays out, where its radius is known."""
    found = {}
    for i, line in enumerate(check.robot.lines):
        drum = drum_of(line)
        if drum is not None:
            begin = drum.angles(check.lengths[:1, i])
            found[f"turns {line.name}"] = np.round((drum.angles(check.lengths[at, i]) - begin) / TURN, 9)
    return found


def _laid(check: Check, at: slice, before: float) -> Array:
    """Return the length of strand (b,), m, laid until each of some samples; *before*: until the one before these."""
    pieces = check.samples.lengths(at) * check.samples.extruding[at]
    return np.cumsum(np.concatenate([[before], pieces]))[1:]


def _write_samples(check: Check, names: list[str], file: Path) -> None:
    """Write all samples, some at a time."""
    schema = _table(check, names, slice(0, 1)).schema
    floats = [field.name for field in schema if pa.types.is_floating(field.type)]
    whole = [field.name for field in schema if field.name not in floats]
    with (
        pa.OSFile(str(file), "wb") as sink,
        pa.parquet.ParquetWriter(
            sink, schema, compression="zstd", use_dictionary=whole, use_byte_stream_split=floats
        ) as out,
    ):
        for at in blocks(len(check.samples), GROUP):
            out.write_table(_table(check, names, at))
            let_go((check.statics, check.samples, check.law, check.poses))


def _write_lengths(check: Check, names: list[str], file: Path) -> None:
    """Write what the winches pay out over time, some samples at a time."""

    def table(at: slice, laid: Array) -> pa.Table:
        columns: dict[str, NDArray[Any]] = {"time": np.round(check.law.time[at], 6)}
        columns |= {f"length {name}": np.round(check.lengths[at, i], 9) for i, name in enumerate(names)}
        columns |= _turns(check, at) | {"laid": np.round(laid, 6), "layer": check.samples.layer[at]}
        return pa.table(columns)

    laid = np.zeros(1)
    with pa.csv.CSVWriter(str(file), table(slice(0, 1), laid).schema) as out:
        for at in blocks(len(check.samples), GROUP):
            laid = _laid(check, at, float(laid[-1]))
            out.write_table(table(at, laid))
            let_go((check.statics, check.samples, check.law))


def job_hashes(path: Path, job: Job) -> dict[str, str]:
    """Return SHA-256 hashes of the file of a *job*, and of its G-code if it has one."""
    files = {"job": path} | ({} if job.gcode is None else {"gcode": job.gcode})
    return {key: file_hash(file) for key, file in files.items()}


def manifest_of(command: str, inputs: Mapping[str, str], options: Mapping[str, object]) -> dict[str, Any]:
    """Return what identifies a run, as JSON values: *command*, hashes of its *inputs*, its *options*, the version."""
    run = {"schema": 1, "command": command, "cablewright": version("cablewright")}
    manifest: dict[str, Any] = json.loads(json.dumps(run | {"inputs": inputs, "options": options}, default=str))
    return manifest


def write_manifest(folder: Path, command: str, inputs: Mapping[str, str], options: Mapping[str, object]) -> None:
    """Write the manifest of a run, see `manifest_of`, to its unfinished *folder*."""
    (folder / MANIFEST).write_text(json.dumps(manifest_of(command, inputs, options), indent=2) + "\n")


def write_places(study: AccuracyStudy, folder: Path) -> None:
    """Write places.parquet of an accuracy study to an existing folder: one row per place, SI; some places at a time."""
    schema = _places(study, slice(0, 0)).schema
    with (
        pa.OSFile(str(folder / "places.parquet"), "wb") as sink,
        pa.parquet.ParquetWriter(sink, schema, compression="zstd") as out,
    ):
        for at in blocks(len(study), GROUP):
            out.write_table(_places(study, at))
            let_go((study.accuracy, study.places))


def _places(study: AccuracyStudy, at: slice) -> pa.Table:
    found = study.accuracy[at]
    spread = found.spread
    columns: dict[str, object] = {"status": found.codes}
    if study.places.distance is not None:
        columns["distance"] = study.places.distance[at]
    columns |= _by_axis(
        {
            "": found.wanted_nozzle,
            "nominal_error_": found.nominal_offset,
            "worst_error_": found.worst_offset,
            "lowest_error_": spread.low,
            "highest_error_": spread.high,
            "deviation_": spread.deviation,
        }
    )
    for name in ("max_error", "max_deviation", "max_turn", "likely_error", "nonlinearity", "unsolved"):
        columns[name] = getattr(spread, name)
    columns |= {f"worst {each.parameter.label}": spread.worst_values[:, k] for k, each in enumerate(found.ranges)}
    return pa.table(columns)


def _by_axis(points: Mapping[str, Array]) -> dict[str, Array]:
    """Columns of the x, y and z of some points or vectors (k, 3), named by their prefix and the axis."""
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


def _table(check: Check, names: list[str], at: slice) -> pa.Table:
    """One row for each of some samples, one column per quantity and line, SI."""
    samples = check.samples
    columns: dict[str, object] = {
        "time": check.law.time[at],
        "speed": check.law.speed[at],
        "distance": samples.distance[at],
        "layer": samples.layer[at],
        "gcode_line": samples.line[at],
        "extruding": samples.extruding[at],
        "status": check.codes[at],
    }
    reached = ("uncompensated", "elastic_only", "compensated")
    nozzles = {f"{name}_": check.nozzle(getattr(check.statics, name)[at]) for name in reached}
    columns |= _by_axis({"": samples.positions[at]} | nozzles)
    if check.robot.n == 6:
        columns |= _by_axis({"rotation_": check.poses[at, 3:]})
        columns["turned_uncompensated"] = check.turn_uncompensated[at]
        columns["turned_compensated"] = check.turn_compensated[at]
    columns["acceleration_displacement"] = check.statics.displacement[at]
    if check.expected is not None:
        columns["expected_error_rms"] = check.expected.rms[at]
    if check.distances is not None:
        columns["clearance"] = check.distances.smallest[at]
    if check.retraction is not None:
        columns["retraction"] = check.retraction[at]
    statics, lines = check.statics, check.statics.lines
    by_line = {"rigid_lengths": statics.rigid_lengths, "lengths": check.lengths, "tensions": statics.tensions}
    by_line |= {"cable_speed": lines.winch_speed, "torque": lines.winch_torque}
    for quantity, values in (by_line | {"swing": lines.swing, "lever": lines.lever}).items():
        columns |= {f"{quantity} {name}": values[at, i] for i, name in enumerate(names)}
    return pa.table(columns)
