"""Print the table and write results.json beside this file.

`python -m benchmarks.run [--quick] [NAMES]` runs the files that are named, or all. With --quick sizes are so small that
a file takes seconds: that shows whether it still runs, and nothing else, so no aim is judged and nothing is written.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from cablewright.__main__ import limit_threads
from cablewright.foundation.file_output import write_whole

RESULTS = Path(__file__).with_name("results.json")
NAMES = (
    "statics", "bodies", "certificates", "equilibria", "accuracy", "workspace", "interference", "bracket",
    "calibration", "walls", "machine", "keeping", "estimation", "print_job", "drives",
    "hanging", "commands",
)  # fmt: skip
VERSIONS = ("cablewright", "numba", "numpy", "scipy", "moorpy", "daqp")


def main(arguments: list[str]) -> int:
    """Run what is named, or all; a missed aim is said, not hidden. 0, or 2 for an unknown name or option."""
    limit_threads()  # as for commands
    quick, chosen = "--quick" in arguments, [each for each in arguments if each != "--quick"]
    unknown = [each for each in chosen if each not in NAMES]
    if unknown:
        print(f"{', '.join(unknown)}: unknown; --quick, {', '.join(NAMES)} are allowed", file=sys.stderr)
        return 2
    title = "QUICK: far too small to judge by" if quick else ""
    print(f"{title:<52} {'measured':>12} {'':<10} {'aim':<14} {'met':<4} beside")
    host, measured_at = machine(), commit()
    for name in chosen or NAMES:
        source, rows = import_module(f"benchmarks.{name}"), []
        for row in source.rows(source.QUICK if quick else source.FULL):
            print((replace(row, aim="", met=None) if quick else row).text(), flush=True)
            rows.append({"file": name, **row.fields(), "commit": measured_at})
        if not quick:
            keep(name, rows, host)
    return 0


def keep(name: str, rows: list[dict[str, object]], host: dict[str, object]) -> None:
    """Put the rows of a file in the place of its old ones; those of files that are no more go."""
    kept = json.loads(RESULTS.read_text())["rows"] if RESULTS.exists() else []
    every = rows + [row for row in kept if row["file"] != name and row["file"] in NAMES]
    every.sort(key=lambda row: NAMES.index(row["file"]))
    write_whole(RESULTS, json.dumps({"schema": 2, "machine": host, "rows": every}, indent=2).encode() + b"\n")


def commit() -> dict[str, object] | None:
    """The commit that is measured, and whether the tree is clean but for the results; None outside git."""
    try:
        sha = git("rev-parse", "HEAD")
        return {"hash": sha, "clean": not git("status", "--porcelain", "--", ":/", f":!{RESULTS.name}")}
    except (OSError, subprocess.CalledProcessError):
        return None


def git(*arguments: str) -> str:
    """What git says in the folder of the results."""
    done = subprocess.run(["git", *arguments], cwd=RESULTS.parent, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def machine() -> dict[str, object]:
    """The computer of the rows; None for the version of a package that is not installed."""
    host: dict[str, object] = {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()}
    for name in VERSIONS:
        try:
            host[name] = version(name)
        except PackageNotFoundError:
            host[name] = None
    return host


def processor() -> str:
    """The processor's name as far as the system reports it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
