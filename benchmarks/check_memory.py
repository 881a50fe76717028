"""Memory of `check` for each sample: the constants by which one that would not fit is refused.

    python -m benchmarks.check_memory

Each size runs in a process of its own; the slope between the two is printed.
"""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import cablewright as cw
from cablewright.studies.checks.check import BYTES, BYTES_OF_LINE

SIZES = (20_000, 120_000)
ROBOTS = ("house-printer", "cogiro")
TURN = 20_000  # moves


def main() -> None:
    """Print the memory for each sample, measured and as `check` reckons it."""
    for name in ROBOTS:
        found = [_measured(name, moves) for moves in SIZES]
        slope = (found[1] - found[0]) / (SIZES[1] - SIZES[0])
        lines = cw.load(name).m
        print(f"{name}, {lines} lines: {slope:.0f} bytes a sample; reckoned {BYTES + BYTES_OF_LINE * lines:.0f}")


def _measured(name: str, moves: int) -> float:
    """The most memory, bytes, of a process that checks so many short moves."""
    ended = subprocess.run(
        [sys.executable, "-m", "benchmarks.check_memory", name, str(moves)], capture_output=True, text=True, check=True
    )
    return float(ended.stdout)


def _check(name: str, moves: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "part.gcode"
        turns = (2.0 * math.pi * k / TURN for k in range(moves))
        places = (f"G1 X{300 * math.cos(turn):.3f} Y{300 * math.sin(turn):.3f} Z500 E1" for turn in turns)
        file.write_text("\n".join(["G21", "G90", "M83", "G0 X300 Y0 Z500", *places, ""]))
        cw.check(cw.load(name), file)
    print(1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


if __name__ == "__main__":
    _check(sys.argv[1], int(sys.argv[2])) if len(sys.argv) == 3 else main()
