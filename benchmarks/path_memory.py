"""Memory of `check`, `accuracy` and `interference` for each sample: the constants by which too much is refused.

    python -m benchmarks.path_memory

Each size runs in a process of its own; the slope between the two is printed.
"""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cablewright as cw
from cablewright.studies import accuracy, interference
from cablewright.studies.checks import check

SIZES = (10_000, 40_000)
ROBOTS = ("house-printer", "cogiro")
TURN = 20_000  # moves
STUDIES: dict[str, tuple[Callable[..., Any], Callable[[cw.Robot], float]]] = {
    "check": (cw.check, check.bytes_each),
    "accuracy": (cw.accuracy, lambda robot: accuracy.bytes_each(robot, robot.m)),
    "interference": (cw.interference, interference.bytes_each),
}
"""By name: the study of a robot and a job, and the bytes that it reckons with for a sample."""


def main() -> None:
    """Print the memory for each sample, measured and as it is reckoned with."""
    for study, (_, reckoned) in STUDIES.items():
        for name in ROBOTS:
            found = [_measured(study, name, moves) for moves in SIZES]
            slope, robot = (found[1] - found[0]) / (SIZES[1] - SIZES[0]), cw.load(name)
            print(f"{study} {name}, {robot.m} lines: {slope:.0f} bytes a sample; reckoned {reckoned(robot):.0f}")


def _measured(study: str, name: str, moves: int) -> float:
    """The most memory, bytes, of a process that studies so many short moves."""
    command = [sys.executable, "-m", "benchmarks.path_memory", study, name, str(moves)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def _run(study: str, name: str, moves: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "part.gcode"
        turns = (2.0 * math.pi * k / TURN for k in range(moves))
        places = (f"G1 X{300 * math.cos(turn):.3f} Y{300 * math.sin(turn):.3f} Z500 E1" for turn in turns)
        file.write_text("\n".join(["G21", "G90", "M83", "G0 X300 Y0 Z500", *places, ""]))
        STUDIES[study][0](cw.load(name), cw.load_job(file))
    print(1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


if __name__ == "__main__":
    _run(sys.argv[1], sys.argv[2], int(sys.argv[3])) if len(sys.argv) == 4 else main()
