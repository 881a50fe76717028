"""Speed of the kernels against an earlier revision, in turns on one machine, and the first compilation of both.

    python -m benchmarks.revisions REVISION [ROUNDS]

Each round runs both revisions in processes of their own. Printed are the ratios of the best times, now over then.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROBOTS = ("paty2021", "merlet2023", "house-printer", "cogiro", "jung2020")
POSES = 400
REPEATS = 5
ROUNDS = 3
FIRST = ("inverse", "merlet2023", "--at", "0.2,0.1,1")
"""The command whose first run, without compiled kernels, is timed."""


def main(revision: str, rounds: int) -> None:
    """Print one line for each robot and solve, then the first compilation."""
    from benchmarks.timing import HERE, checked_out  # the process that measures has only the sources on its path

    with checked_out(revision) as there:
        sides = {"then": there, "now": HERE}
        best: dict[str, dict[str, float]] = {"then": {}, "now": {}}
        for _ in range(rounds):
            for side, source in sides.items():
                for key, seconds in _timed(source).items():
                    best[side][key] = min(seconds, best[side].get(key, seconds))
        for key, then in best["then"].items():
            now = best["now"][key]
            print(f"{key}: {1e6 * then:.1f} us then, {1e6 * now:.1f} us now: {now / then:.3f}")
        first = {side: min(_first_run(source) for _ in range(2)) for side, source in sides.items()}
        ratio = first["now"] / first["then"]
        print(f"first {' '.join(FIRST)}: {first['then']:.1f} s then, {first['now']:.1f} s now: {ratio:.3f}")


def _environment(source: Path, **more: str) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(source / "src"), "NUMBA_NUM_THREADS": "1"} | more


def _timed(source: Path) -> dict[str, float]:
    command = [sys.executable, __file__, "--times"]
    done = subprocess.run(command, env=_environment(source), capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def _first_run(source: Path) -> float:
    """Seconds of the first command without compiled kernels."""
    with tempfile.TemporaryDirectory() as cache:
        begin = time.perf_counter()
        command = [sys.executable, "-m", "cablewright", *FIRST]
        subprocess.run(command, env=_environment(source, CABLEWRIGHT_CACHE_DIR=cache), capture_output=True, check=True)
        return time.perf_counter() - begin


def times() -> dict[str, float]:
    """Seconds of each solve of one pose, by robot, of the installed revision."""
    import numpy as np

    import cablewright as cw

    found = {}
    for name in ROBOTS:
        robot = cw.load(name)
        low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
        places = np.random.default_rng(1).uniform(0.3 * high + 0.7 * low, 0.7 * high + 0.3 * low, (POSES, 3))
        held = cw.inverse(robot, places)
        held = held[held.ok]
        for solve, run in _solves(robot, places, held).items():
            run()
            found[f"{name}, {solve}"] = min(_seconds(run) for _ in range(REPEATS)) / POSES
    return found


def _solves(robot: Any, places: Any, held: Any) -> dict[str, Callable[[], Any]]:
    """The solves that are timed, by name: of *robot* at *places*, and from the *held* solutions there."""
    import cablewright as cw

    return {
        "inverse": lambda: cw.inverse(robot, places),
        "forward": lambda: cw.forward(robot, held.lengths),
        "forward, near": lambda: cw.forward(robot, held.lengths, guess=held.pose),
        "linearise": lambda: cw.linearise(held),
        "certify": lambda: cw.certify(held),
    }


def _seconds(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


if __name__ == "__main__":
    if sys.argv[1:] == ["--times"]:
        print(json.dumps(times()))
    else:
        main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else ROUNDS)
