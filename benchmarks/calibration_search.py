"""The search for gross errors: how often it leaves something out of data without any, and how often it finds them.

`python -m benchmarks.calibration_search [FILES] [SEED]` prints for each kind of file the share of files of
which something is left out, or exactly what is wrong, with its 95 % interval (Clopper and Pearson).
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.calibration import GROSS, NOISE, WANG
from benchmarks.timing import interval
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.robot import Robot, load

PLACED = 2e-3  # m: true sigma of measured positions
EIGHT = load("cogiro")


@dataclass(frozen=True)
class Files:
    """Simulated files of one kind."""

    name: str
    rows: int
    wrong: int = 0  # rows with one length wrong by `GROSS`
    told: float | None = None  # m: the given sigma of positions good to `PLACED`; None: no positions
    off: float = GROSS  # m
    robot: Robot = WANG

    def made(self, seed: int) -> tuple[Measured, list[int]]:
        """One file, and which of its rows are wrong."""
        rng = np.random.default_rng(seed)
        made = measure(self.robot, random_poses(self.robot, self.rows, rng), NOISE, rng)
        measured, bad = made.measured, rng.choice(self.rows, self.wrong, replace=False)
        counted = measured.counted.copy()
        counted[bad, rng.integers(0, self.robot.m, self.wrong)] += self.off * rng.choice([-1.0, 1.0], self.wrong)
        if self.told is None:
            return replace(measured, counted=counted), sorted(bad.tolist())
        guess = made.poses + rng.normal(0.0, PLACED, made.poses.shape)
        sigma = np.full(guess.shape, self.told)
        return replace(measured, counted=counted, guess=guess, pose_sigma=sigma), sorted(bad.tolist())


KINDS = (
    Files("100 rows, clean", 100),
    Files("40 rows, clean", 40),
    Files("24 rows, clean", 24),
    Files("40 rows, clean, positions told right", 40, told=PLACED),
    Files("40 rows, clean, positions of 2 mm told to 1 m", 40, told=1.0),
    Files("40 rows of a body on 8 lines, clean", 40, robot=EIGHT),
    Files("100 rows, 5 off by 50 mm", 100, 5),
    Files("40 rows, 4 off by 50 mm", 40, 4),
    Files("24 rows, 2 off by 50 mm", 24, 2),
    Files("40 rows, 4 off by 2 mm", 40, 4, off=2e-3),
    Files("40 rows, 2 off, positions of 2 mm told to 1 m", 40, 2, told=1.0),
)


def main(count: int, seed: int) -> None:
    """Print a row for each kind."""
    for files in KINDS:
        good, lost, begin = 0, 0, time.perf_counter()
        for each in range(count):
            measured, bad = files.made(seed + each)
            found = {one.pose for one in calibrate(files.robot, measured, CalibrationPlan(sigma=Sigmas())).rejected}
            good += found == set(bad)
            lost += bool(found - set(bad))
        spent = 1e3 * (time.perf_counter() - begin) / count
        told = f"good rows left out: {interval(lost, count)}"
        if files.wrong:
            told += f", exactly the wrong ones: {interval(good, count)}"
        print(f"{files.name:<46} {told}, {spent:.0f} ms a file", flush=True)


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]] + [300, 5000][len(sys.argv) - 1 :]
    main(*given)
