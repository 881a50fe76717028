"""Tables of a check: samples.parquet and lengths.csv, written in blocks of samples."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.models.coil import TURN
from cablewright.models.drum import drum_of
from cablewright.running.run_folders import GROUP, by_axis, file_hash, job_hashes, robot_hash, write_manifest
from cablewright.studies.checks.result import Check


def write_check(
    check: Check,
    folder: Path,
    robot: str,
    job: Path,
    options: Mapping[str, object] | None = None,
    uncertainty: Path | None = None,
) -> None:
    """Write samples.parquet, lengths.csv and the manifest of a check to an existing folder.

    *robot*: library name or file. *options*: options that changed the answer. *uncertainty*: file of the uncertainty,
    if one was given.
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
            begin = drum.angles(check.commanded[:1, i])
            found[f"turns {line.name}"] = np.round((drum.angles(check.commanded[at, i]) - begin) / TURN, 9)
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
        columns |= {f"length {name}": np.round(check.commanded[at, i], 9) for i, name in enumerate(names)}
        columns |= _turns(check, at) | {"laid": np.round(laid, 6), "layer": check.samples.layer[at]}
        return pa.table(columns)

    laid = np.zeros(1)
    with pa.csv.CSVWriter(str(file), table(slice(0, 1), laid).schema) as out:
        for at in blocks(len(check.samples), GROUP):
            laid = _laid(check, at, float(laid[-1]))
            out.write_table(table(at, laid))
            let_go((check.statics, check.samples, check.law))


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
    columns |= by_axis({"": samples.positions[at]} | nozzles)
    if check.robot.n == 6:
        columns |= by_axis({"rotation_": check.poses[at, 3:]})
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
