"""What is known by the poses measured so far: unknowns and their information, and robots that it may be instead."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.states import with_new_home
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measured import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.sufficient_data import check_lengths, min_poses
from cablewright.calibration.sensors.load_cells import require_tensions
from cablewright.calibration.unknowns import coordinates_of
from cablewright.progress import Progress
from cablewright.robot import Robot

_SPARE: Final = 5  # poses more than there must be, before anything is said to be known
_ROBOTS: Final = 6  # that it may be


@dataclass(frozen=True, eq=False)
class Known:
    """What is known by now: the robot, the rows of information on its unknowns, and robots that it may be instead."""

    problem: CalibrationProblem
    theta: Array  # (k,)
    rows: Array  # (r, k)
    sigma: float  # m, of the encoders
    rough: float  # m, max error of the file, where nothing is known yet; else 0
    poses: int
    missing: int  # poses until anything can be told
    last: Array | None  # (n,) the last pose
    found: Calibration | None

    @classmethod
    def of(
        cls,
        robot: Robot,
        measured: Measured | None,
        plan: CalibrationPlan,
        rough: float,
        need: float,
        seed: int,
        progress: Progress,
    ) -> Known:
        """Calibrate where there are enough poses; else what is known is the file, to *rough*."""
        blank = Measured(np.zeros((1, robot.m)), np.zeros((1, robot.n)))
        count = 0 if measured is None else len(measured.counted)
        own = _of_encoders(plan, count)
        problem = CalibrationProblem.of(robot, measured or blank, own, hold=False)
        needed = min_poses(problem) + _SPARE
        if measured is not None and count >= needed:
            found = calibrate(robot, measured, plan, need=need, rough=rough, seed=seed, progress=progress)
            if found.verdict == "bad":
                return cls(problem, problem.free, np.zeros((0, 0)), 0.0, 0.0, count, 0, None, found)
            rows = found.posterior.rows / max(found.scale, 1e-6)
            return cls(found.problem, found.fit.theta, rows, found.encoder_sigma, 0.0, count, 0, found.poses[-1], found)
        theta = problem.free
        if measured is not None:
            check_lengths(robot, measured)
            require_tensions(robot, measured)
            told = measured.without_open_zeros(plan.unknowns)
            theta = with_new_home(CalibrationProblem.of(robot, told, own, hold=False), theta)
        exits = problem.named("exit_point")
        sigma = max(rough, 1e-6) / np.sqrt(3.0)
        rows = np.concatenate([problem.rows.linear, np.eye(len(theta))[exits] / sigma])
        return cls(problem, theta, rows, problem.encoder_sigma, rough, count, needed - count, None, None)

    def robots(self, rng: np.random.Generator) -> Array:
        """Return exit points (R, m, 3), m, of the robot as it is known, and of some that it may be."""
        exits = self.problem.exit_points(self.theta)
        which, coordinates = coordinates_of(self.problem.robot, self.problem.unknowns)
        away = np.zeros((_ROBOTS, exits.size))
        if self.rough:
            away[:, coordinates] = rng.uniform(-self.rough, self.rough, (_ROBOTS, len(coordinates)))
        else:
            assert self.found is not None
            values, vectors = np.linalg.eigh(self.found.covariance[np.ix_(which, which)])
            drawn = rng.normal(size=(_ROBOTS, len(values))) * np.sqrt(values.clip(min=0.0))
            away[:, coordinates] = drawn @ vectors.T
        return np.concatenate([exits[None], exits + away.reshape(-1, *exits.shape)])


def _of_encoders(plan: CalibrationPlan, count: int) -> CalibrationPlan:
    """Return the plan without what is measured at poses that are not there yet."""
    kept = {
        name: tuple(each for each in getattr(plan, name) if max(each.poses) <= count) for name in ("planes", "ranges")
    }
    return plan.model_copy(update=kept)
