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
    """Run everything, or the files that are named and keep the other rows; an aim that is missed is said, not hidden."""
    by_name = {source.__name__.rpartition(".")[2]: source for source in SOURCES}
    chosen = [by_name[name] for name in sys.argv[1:]] or list(SOURCES)
    kept = json.loads(RESULTS.read_text())["rows"] if sys.argv[1:] else []
    rows = {row["name"]: row for row in kept}
    print(f"{'':<52} {'measured':>12} {'':<10} {'aim':<14} {'met':<4} beside")
    for source in chosen:
        for row in source.rows():
            print(row.text(), flush=True)
            rows[row.name] = row.fields()
    host = {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()}
    host |= {name: version(name) for name in ("cablewright", "numba", "numpy", "scipy", "moorpy", "daqp")}
    part = RESULTS.with_suffix(".part")
    text = json.dumps({"schema": 1, "machine": host, "rows": list(rows.values())}, indent=2, default=float)
    part.write_text(text + "\n")
    part.replace(RESULTS)


def processor() -> str:
    """The processor's name as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    main()
