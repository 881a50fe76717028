"""Print the table and write results.json beside this file."""

from __future__ import annotations

import json
import os
import platform
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


def main() -> None:
    """Run everything; an aim that is missed is said, not hidden."""
    rows = []
    print(f"{'':<52} {'measured':>12} {'':<10} {'aim':<14} {'met':<4} beside")
    for source in (
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
    ):
        for row in source.rows():
            print(row.text(), flush=True)
            rows.append(row.fields())
    host = {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()}
    host |= {name: version(name) for name in ("cablewright", "numba", "numpy", "scipy", "moorpy", "daqp")}
    part = RESULTS.with_suffix(".part")
    part.write_text(json.dumps({"schema": 1, "machine": host, "rows": rows}, indent=2, default=float) + "\n")
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
