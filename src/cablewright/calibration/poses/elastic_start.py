"""The start of a calibration with elastic lines: the fit of straight, rigid lines, then equilibria near its poses.

Straight lines are fitted from rough dimensions by many starts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.elastic import FREED, ElasticProblem
from cablewright.calibration.poses.fit import PoseFit, best_fit, first_start, fit, fitted_poses, quick_fit
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.sufficient_data import surplus_per_pose
from cablewright.calibration.unknowns import with_values
from cablewright.errors import AnswerError, InputError
from cablewright.models.parameters import lines_of
from cablewright.models.statics import Equilibrium, Model
from cablewright.progress import Progress, silent
from cablewright.solvers.inverse import solve_inverse

_ELASTIC: Final = ("modulus", "exit_compliance")
_SAG: Final = 5e-3  # m: min sigma of lengths of straight lines
_SAGGING: Final = 0.02  # of the platform's weight: min sigma of tensions along straight lines
_FITS: Final = 5.0  # max cost per redundant measurement of an accepted fit: 0.5 is expected
_WIDER: Final = 10.0  # factor on the range of measured tensions, the tension limits of a start


def elastic_fit(problem: ElasticProblem, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """Fit from the answer of straight lines; where those have no redundancy, from the file and the poses' start values.

    Raises `InputError` if both are missing, `AnswerError` if there is no equilibrium near any pose.
    """
    straight = CalibrationProblem.of(problem.robot, problem.measured, straight_plan(problem), hold=False)
    guessed = problem.measured.guess is not None
    if surplus_per_pose(straight) < 1:
        if guessed:
            return _fit_from(problem, straight, first_start(straight))
        raise InputError(f"{problem.measured.origin}: columns x,y,z are required, start values of the poses")
    first = _fit_from(problem, straight, quick_fit(straight, rough)) if guessed else None
    redundancy = len(problem.values) - problem.poses * problem.unknowns_per_pose - len(problem.start)
    if first is not None and first.cost < _FITS * max(redundancy, 1):
        return first
    again = _fit_from(problem, straight, best_fit(straight, seed, rough, progress))
    return again if first is None or again.cost <= first.cost else first


def _fit_from(problem: ElasticProblem, straight: CalibrationProblem, found: PoseFit) -> PoseFit:
    theta, states = _relaxed(problem, straight, found)
    plain = fit(problem, theta, fitted_poses(problem, theta, states))
    return replace(plain, starts=found.starts, alike=found.alike)


def straight_plan(problem: ElasticProblem) -> CalibrationPlan:
    """Return the plan for straight lines: without what loads do to lengths, with sigmas that allow for sag."""
    plan, robot = problem.plan, problem.robot
    min_tension = _SAGGING * robot.platform.mass * robot.scene.gravity
    exact = {"encoder": max(plan.sigma.encoder or 0.0, _SAG), "tension": max(plan.sigma.tension, min_tension)}
    kept = {
        **{
            name: tuple(each for each in getattr(plan, name) if each not in _ELASTIC) for name in ("unknowns", "shared")
        },
        **{
            name: tuple(each for each in getattr(plan, name) if each.name not in _ELASTIC)
            for name in ("groups", "priors", "bounds")
        },
        "sigma": plan.sigma.model_copy(update=exact),
    }
    return plan.model_copy(update=kept)


def _relaxed(problem: ElasticProblem, straight: CalibrationProblem, found: PoseFit) -> tuple[Array, Array]:
    """Return free unknowns (k,) and states (N, ..) in equilibrium at the poses of the straight lines."""
    values = straight.whole(found.theta)
    known = dict(zip(straight.unknowns, values, strict=True))
    theta = np.array([known.get(*each) for each in zip(problem.free_unknowns, problem.free, strict=True)])
    sizes = np.array([each.size for each in straight.unknowns])
    robot = with_values(problem.robot, straight.unknowns, values * sizes, raised=True)
    states = problem.states_of(equilibria_at(problem, Model(robot), found.poses))
    off = problem.derivatives(theta, states).residual[:, : problem.robot.m] * problem.encoder_sigma
    for at, each in enumerate(problem.free_unknowns):
        if each.name == "length_offset":
            theta[at] += np.median(off[:, lines_of(problem.robot, each)[0]])
    return theta, states


def equilibria_at(problem: ElasticProblem, found: Model, poses: Array) -> Equilibrium:
    """Return equilibria at *poses*, with tensions near the measured ones. Raises `AnswerError` if there are none."""
    robot, measured = problem.robot, problem.measured
    tensions, limits = measured.tensions, None
    if tensions is not None:
        tensions = tensions.clip(min=1e-3 * robot.platform.mass * robot.scene.gravity)
        limits = float(tensions.min() / _WIDER), float(tensions.max() * _WIDER)
    given = poses.copy()
    if robot.m < robot.freedoms:  # gravity determines the others
        given[:, FREED[robot.m :]] = np.nan
    model = Model(found.robot, problem.model.fidelity, limits)
    held = solve_inverse(model, given, preferred=tensions)
    lost = ~np.isfinite(held.lengths).all(axis=1) | ~np.isfinite(held.pose).all(axis=1)
    if lost.all():
        place = ", ".join(f"{x:.3g}" for x in poses[0, :3])
        where = f"{measured.origin}, {measured.place(0)}"
        raise AnswerError(f"not calibrated: {where}: no equilibrium near ({place}): {held[0].sentence()}")
    good = np.flatnonzero(~lost)  # a pose without an equilibrium starts from the nearest one that has one
    apart = np.linalg.norm(poses[:, None, :3] - poses[good, :3], axis=2)
    return held[np.where(lost, good[np.argmin(apart, axis=1)], np.arange(len(poses)))]
