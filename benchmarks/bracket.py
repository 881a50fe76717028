"""Stress of both bracket designs at the paper's pose: the whole work on the default mesh, in a process of its own."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from multiprocessing import get_context

from benchmarks.timing import Row

POSE = (-2.25, -6.75, 13.0)
SECONDS, GIGABYTES, ERROR = 60.0, 4.0, 5.0


def rows() -> Iterator[Row]:
    """All rows of this file; none without the extra `fem`."""
    if find_spec("skfem") is None:
        return
    with get_context("spawn").Pool(1) as pool:
        seconds, memory, errors, ratio = pool.apply(compare)
    yield Row("bracket: both designs, two meshes", seconds, "s", f"<= {SECONDS:.0f} s", seconds <= SECONDS)
    yield Row("bracket: memory", memory, "GB", f"<= {GIGABYTES:.0f} GB", memory <= GIGABYTES)
    yield Row("bracket: estimated error of the stresses", errors, "%", f"< {ERROR:.0f} %", errors < ERROR)
    yield Row("bracket: conventional over universal joint", ratio, "")


def compare() -> tuple[float, float, float, float]:
    """Time in s without imports, the process's memory in GB, the largest estimated error in %, the designs' ratio."""
    from cablewright.analyses.bracket.stress import bracket_at
    from cablewright.models.statics import Model
    from cablewright.robot import load

    begin = time.perf_counter()
    found = bracket_at(Model(load("house-printer")), POSE)
    errors = [peak.error for design in (found.universal_joint, found.conventional) for peak in design.peaks]
    seconds = time.perf_counter() - begin
    unit = 1e9 if sys.platform == "darwin" else 1e6
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    return seconds, memory, 100.0 * max(errors), found.ratio
