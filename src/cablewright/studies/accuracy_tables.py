"""The table of an accuracy study: places.parquet, written in blocks of positions."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet

from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.running.run_folders import GROUP, by_axis
from cablewright.studies.accuracy import AccuracyStudy


def write_places(study: AccuracyStudy, folder: Path) -> None:
    """Write places.parquet of an accuracy study to an existing folder: one row per position, SI, block by block."""
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
    columns |= by_axis(
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
