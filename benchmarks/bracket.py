"""Stress of both bracket designs at the paper's pose: the whole work on the default mesh, in a process of its own.

`python -m benchmarks.bracket TIMES` is that process: elements divided so often; it prints JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator

from benchmarks.processes import alone
from benchmarks.timing import Row, installed
from cablewright.analyses.bracket.stress import TIMES, bracket_at
from cablewright.models.statics import Model
from cablewright.robot import load

POSE = (-2.25, -6.75, 13.0)
SECONDS, GIGABYTES, ERROR = 60.0, 4.0, 5.0
FULL, QUICK = TIMES, 1


def rows(times: int) -> Iterator[Row]:
    """All rows of this file; none without the extra `fem`."""
    if not installed("skfem"):
        return
    output, _, memory = alone(["-m", "benchmarks.bracket", str(times)])
    (seconds, errors, ratio), memory = json.loads(output), memory / 1e9
    yield Row("bracket: both designs, two meshes", seconds, "s", f"<= {SECONDS:.0f} s", seconds <= SECONDS)
    yield Row("bracket: memory", memory, "GB", f"<= {GIGABYTES:.0f} GB", memory <= GIGABYTES)
    yield Row("bracket: estimated error of the stresses", errors, "%", f"< {ERROR:.0f} %", errors < ERROR)
    yield Row("bracket: conventional over universal joint", ratio, "")


def compare(times: int) -> tuple[float, float, float]:
    """Time in s without imports, the largest estimated error in % (NaN of one mesh), the designs' ratio."""
    begin = time.perf_counter()
    found = bracket_at(Model(load("house-printer")), POSE, times=times)
    errors = [peak.error for design in (found.universal_joint, found.conventional) for peak in design.peaks]
    return time.perf_counter() - begin, 100.0 * max(errors), found.ratio


if __name__ == "__main__":
    print(json.dumps(compare(int(sys.argv[1]))))
