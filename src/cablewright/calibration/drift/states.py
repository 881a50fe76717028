"""Where the platform was at new measurements, by the numbers of a calibration."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.elastic_start import equilibria_at, straight_plan
from cablewright.calibration.poses.fit import best_fit, fit, fitted_poses, unmirrored
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.models.rotation import yawed
from cablewright.models.statics import Model

_YAWS: Final = tuple(np.radians(range(30, 360, 30)).tolist())
_FITS: Final = 100.0  # max mean square of a pose's residuals over their sigma: beyond, other start values are tried
_BETTER: Final = 0.5  # of the squares, to prefer those of another start


def states_at(problem: CalibrationProblem, theta: Array, new_home: bool) -> tuple[Array, Array]:
    """Return the unknowns (k,), with lengths at home that fit if they are new, and the states (N, ..) of the poses."""
    straight = problem
    if isinstance(problem, ElasticProblem):
        plan = straight_plan(problem)
        straight = CalibrationProblem.of(problem.robot, problem.measured, plan, hold=False)
    start = _moved(problem, theta, straight)
    if new_home:
        start = with_new_home(straight, start)
    poses = _poses(straight, start)
    if not isinstance(problem, ElasticProblem):
        return start, fit(problem.for_poses_only(start), np.zeros(0), poses).poses
    theta = theta.copy()
    if new_home:
        theta[problem.named("length_offset")] = start[straight.named("length_offset")]
    states = problem.states_of(equilibria_at(problem, Model(problem.robot), poses))
    return theta, fit(problem.for_poses_only(theta), np.zeros(0), states).poses


def _moved(problem: CalibrationProblem, theta: Array, straight: CalibrationProblem) -> Array:
    """Return the unknowns of straight lines (k,) with the values of those of *problem* that they have too."""
    known = dict(zip(problem.unknowns, theta.tolist(), strict=True))
    return np.array([known[each] for each in straight.unknowns])


def _poses(problem: CalibrationProblem, theta: Array) -> Array:
    """Return the poses (N, n) that fit, from the start values in the data, or from the middle of the frame.

    A calibration with azimuths may have turned the frame, so where start values do not fit others are tried that turn
    about the middle with it.
    """
    scene, guess = problem.robot.scene, problem.measured.guess
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    start = np.zeros((problem.poses, problem.robot.n))
    start[:, :3] = middle
    if guess is not None:
        known = np.asarray(np.isfinite(guess).all(axis=1))
        start = np.where(known[:, None], guess, start)
    best, cost = _fitted(problem, theta, start)
    plane = problem.robot.platform.plane
    axis = (0.0, 0.0, 1.0) if plane is None else plane.across
    for yaw in _YAWS if (cost > _FITS * problem.per_pose).any() else ():
        found, its = _fitted(problem, theta, yawed(start, yaw, middle, axis))
        better = its < _BETTER * cost
        best, cost = np.where(better[:, None], found, best), np.where(better, its, cost)
    return best


def _fitted(problem: CalibrationProblem, theta: Array, start: Array) -> tuple[Array, Array]:
    """Return the poses (N, n) that fit from a *start* (N, n), and their sums (N,) of squared residuals."""
    poses = unmirrored(problem, theta, fitted_poses(problem, theta, start))
    squares = np.sum(problem.derivatives(theta, poses).residual ** 2, axis=1)
    return poses, np.where(np.isfinite(squares), squares, np.inf)


def with_new_home(problem: CalibrationProblem, theta: Array) -> Array:
    """Return the unknowns (k,) with the lengths at home that fit the data, all others held."""
    homes = problem.named("length_offset")
    if not homes.any():  # lengths are absolute
        return theta
    plan = problem.plan.model_copy(
        update={"unknowns": ("length_offset",), "shared": (), "groups": (), "priors": (), "bounds": ()}
    )
    only = CalibrationProblem.of(problem.robot, problem.measured, plan, hold=False)
    only = replace(only, rows=only.rows._replace(lines=problem.line_numbers(theta)))
    changed = theta.copy()
    changed[homes] = best_fit(only, seed=0, rough=0.0).theta
    return changed
