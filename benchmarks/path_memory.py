"""Memory of `check`, `accuracy` and `interference` of long paths.

    python -m benchmarks.path_memory          # for each sample: the constants by which too much is rejected
    python -m benchmarks.path_memory long     # the most of whole commands, which keep samples in their run folders

Each size runs in a process of its own. A command's paths are 2 million short moves, and 10 million samples of straight
moves; the latter takes some 10 GB of the disk of the temporary folder, and a quarter of an hour.
"""

from __future__ import annotations

import math
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import cablewright as cw
from benchmarks.processes import alone
from cablewright.studies import accuracy, interference
from cablewright.studies.checks import check

SIZES = {False: (10_000, 40_000), True: (100_000, 200_000)}
"""Moves, without and with arrays in files."""
ROBOTS = ("house-printer", "cogiro")
TURN = 20_000  # moves
STUDIES: dict[str, tuple[Callable[..., Any], Callable[[cw.Robot, Path | None], float]]] = {
    "check": (cw.check, check.bytes_each),
    "accuracy": (partial(cw.accuracy, method="first-order"), lambda one, room: accuracy.bytes_each(one, one.m, room)),
    "interference": (cw.interference, interference.bytes_each),
}
"""By name: the study of a robot and a job, and the bytes that it reckons with for a sample, without and with a room."""


def long() -> None:
    """Print the most memory of `cablewright check` of long paths, without and with all that is on by default."""
    house = Path(__file__).parents[1] / "examples" / "house.toml"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        moves = _rings(folder / "moves.gcode", 2_000_000)
        straight = folder / "straight.toml"
        _beams(folder / "straight.gcode")
        straight.write_text('schema = 1\nname = "straight"\ngcode = "straight.gcode"\n[sampling]\nstep = "2 mm"\n')
        less = ("--no-interference", "--no-expected-error")
        for job, options in ((house, less), (house, ()), (moves, less), (moves, ()), (straight, less)):
            command = ["check", "house-printer", str(job), *options, "--out", str(folder / "run"), "--json"]
            _, seconds, peak = alone(["-m", "cablewright", *command])
            shutil.rmtree(folder / "run")
            rest = " ".join(options) or "nothing left out"
            print(f"check {job.stem}, {rest}: {peak / 1e9:.3f} GB, {seconds:.0f} s", flush=True)


def _rings(file: Path, moves: int) -> Path:
    """Write rings one above the other, of so many moves of 0.1 mm in all."""
    turns = ((2.0 * math.pi * k / TURN, k // TURN) for k in range(moves))
    places = (f"G1 X{300 * math.cos(a):.3f} Y{300 * math.sin(a):.3f} Z{500 + layer} E1\n" for a, layer in turns)
    with file.open("w", encoding="utf-8") as out:
        out.write("G21\nG90\nM83\nG0 X300 Y0 Z500\n")
        out.writelines(places)
    return file


def _beams(file: Path) -> None:
    """Write squares of 4 m, one above the other: 20 km, which are 10 million samples of 2 mm."""
    corners = ((2000, -2000), (2000, 2000), (-2000, 2000), (-2000, -2000))
    with file.open("w", encoding="utf-8") as out:
        out.write("G21\nG90\nM83\nG0 X-2000 Y-2000 Z500\n")
        for layer in range(1250):
            out.writelines(f"G1 X{x} Y{y} Z{500 + layer} E1\n" for x, y in corners)


def main() -> None:
    """Print the memory for each sample, measured and as it is reckoned with."""
    for study, (_, reckoned) in STUDIES.items():
        for name in ROBOTS:
            robot = cw.load(name)
            for in_files, (few, many) in SIZES.items():
                found = [_measured(study, name, moves, in_files) for moves in (few, many)]
                slope, own = (found[1] - found[0]) / (many - few), reckoned(robot, Path() if in_files else None)
                where = "in files" if in_files else "in memory"
                print(f"{study} {name}, {robot.m} lines, {where}: {slope:.0f} bytes a sample; reckoned {own:.0f}")


def _measured(study: str, name: str, moves: int, in_files: bool) -> float:
    """The most memory, bytes, of a process that studies so many short moves."""
    command = [sys.executable, "-m", "benchmarks.path_memory", study, name, str(moves), str(int(in_files))]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def _run(study: str, name: str, moves: int, in_files: bool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = _rings(Path(folder) / "part.gcode", moves)
        STUDIES[study][0](cw.load(name), cw.load_job(file), room=Path(folder) if in_files else None)
    print(1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


if __name__ == "__main__":
    if len(sys.argv) == 5:
        _run(sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4] == "1")
    elif sys.argv[1:] == ["long"]:
        long()
    else:
        main()
