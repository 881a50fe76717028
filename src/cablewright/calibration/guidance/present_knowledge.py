"""Present knowledge in a guided calibration: the robot so far, and the information on its unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import with_new_home
from cablewright.calibration.guidance.pictures_to_take import PICTURED
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurement_rows.load_cells import require_tensions
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.sufficient_data import check_lengths, min_poses
from cablewright.calibration.unknowns import coordinates_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.progress import Progress
from cablewright.robot import Robot

_SPARE: Final = 5  # poses more than there must be, before anything counts as known
_ROBOTS: Final = 6  # that it may be


@dataclass(frozen=True, eq=False)
class Knowledge:
    """Present knowledge: the robot, the information on its unknowns, and robots drawn from the uncertainty."""

    problem: CalibrationProblem
    theta: Array  # (k,)
    rows: Array  # (r, k)
    sigma: float  # m, of the encoders
    rough: float  # m, max error of the file, where nothing is known yet; else 0
    poses: int
    missing: int  # poses until a result is possible
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
        pictured: bool,
    ) -> Knowledge:
        """Calibrate if there are enough poses; otherwise take exit points of the robot file, to within *rough* (m).

        *pictured*: whether each pose has, or will have, a picture.
        """
        blank = Measured(np.zeros((1, robot.m)), np.zeros((1, robot.n)))
        count = 0 if measured is None else len(measured.counted)
        own = _of_encoders(plan, count)
        alone = measured.lengths_alone() if measured is not None and pictured else measured
        problem = StraightProblem.of(robot, alone or blank, own, hold=False)
        needed = (PICTURED if pictured else min_poses(problem)) + _SPARE
        if measured is not None and count >= needed:
            found = calibrate(robot, measured, plan, need=need, rough=rough, seed=seed, progress=progress)
            if found.verdict == "bad":
                return cls(problem, problem.free, np.zeros((0, 0)), 0.0, 0.0, count, 0, None, found)
            rows = found.posterior.rows / max(found.scale, 1e-6)
            return cls(found.problem, found.fit.theta, rows, found.encoder_sigma, 0.0, count, 0, found.poses[-1], found)
        theta = problem.free
        if alone is not None:
            check_lengths(robot, alone)
            require_tensions(robot, alone)
            told = alone.without_open_zeros(plan.unknowns)
            theta = with_new_home(StraightProblem.of(robot, told, own, hold=False), theta)
        exits = problem.named("exit_point")
        rows = np.concatenate([problem.rows.linear, np.eye(len(theta))[exits] / (max(rough, 1e-6) / np.sqrt(3.0))])
        return cls(problem, theta, rows, problem.encoder_sigma, rough, count, needed - count, None, None)

    def robots(self, rng: np.random.Generator) -> Array:
        """Return exit points (R, m, 3), m: first as estimated now, then of random robots within the uncertainty."""
        exits = self.problem.points(self.theta)
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
    """Return the plan without data of poses that were not measured yet."""
    kept = {
        name: tuple(each for each in getattr(plan, name) if max(each.poses) <= count) for name in ("planes", "ranges")
    }
    return plan.model_copy(update=kept)
