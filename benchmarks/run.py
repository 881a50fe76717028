"""Print the table and write results.json beside this file."""

from __future__ import annotations

import json
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

from benchmarks import (
    accuracy,
    bodies,
    bracket,
    calibration,
    certificates,
    commands,
    equilibria,
    estimation,
    hanging,
    interference,
    keeping,
    machine,
    print_job,
    statics,
    walls,
    workspace,
)
from cablewright.file_output import write_whole

RESULTS = Path(__file__).with_name("results.json")


SOURCES = (
    statics,
    bodies,
    certificates,
    equilibria,
    accuracy,
    workspace,
    interference,
    bracket,
    calibration,
    walls,
    machine,
    keeping,
    estimation,
    print_job,
    hanging,
    commands,
)


def main() -> None:
    """Run everything, or the files that are named and keep the others' rows; a missed aim is said, not hidden."""
    by_name = {source.__name__.rpartition(".")[2]: source for source in SOURCES}
    chosen = sys.argv[1:] or list(by_name)
    rows: dict[str, list[dict[str, object]]] = {name: [] for name in by_name}
    if sys.argv[1:]:
        for row in json.loads(RESULTS.read_text())["rows"]:
            rows[row["file"]].append(row)
    print(f"{'':<52} {'measured':>12} {'':<10} {'aim':<14} {'met':<4} beside")
    for name in chosen:
        rows[name] = []
        for row in by_name[name].rows():
            print(row.text(), flush=True)
            rows[name].append({"file": name, **row.fields()})
    host = {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()}
    host |= {name: version(name) for name in ("cablewright", "numba", "numpy", "scipy", "moorpy", "daqp")}
    table = {"schema": 1, "machine": host, "rows": [row for each in rows.values() for row in each]}
    write_whole(RESULTS, json.dumps(table, indent=2, default=float).encode() + b"\n")


def processor() -> str:
    """The processor's name as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    main()
