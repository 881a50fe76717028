"""Where a calibration of lines that stretch and sag begins: at the fit of straight, stiff ones, let go in equilibrium.

Straight lines are found from rough dimensions by many starts; from their answer the equilibria are near.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.checks import spare
from cablewright.calibration.elastic_lines import FREED, Hanging
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.pose_fit import NEAR, PoseFit, best_fit, first_start, fit, poses_alone, quick_fit
from cablewright.calibration.problem import CalibrationProblem
from cablewright.calibration.unknowns import with_values
from cablewright.errors import AnswerError, InputError
from cablewright.models.statics import Equilibrium, Model
from cablewright.progress import Progress, silent
from cablewright.solvers.inverse import solve_inverse

_SAG: Final = 5e-3  # m: how exact lengths of straight lines are taken to be, at best
_SAGGING: Final = 0.02  # of the platform's weight: the same of tensions along straight lines
_FITS: Final = 5.0  # half the sum of squares for each measurement left over: 0.5 is what is due
_WIDER: Final = 10.0  # times: tensions may be further than those measured, while a start is sought


def hanging_fit(problem: Hanging, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """Fit from straight lines on; where those have nothing to spare, from the file and the guesses of the poses.

    Raises `InputError` where there are neither, `AnswerError` where the platform does not hang near any pose.
    """
    straight = CalibrationProblem.of(problem.robot, problem.measured, _straight(problem), hold=False)
    guessed = problem.measured.guess is not None
    if spare(straight) < 1:
        if guessed:
            return _fit_from(problem, straight, first_start(straight))
        raise InputError(f"{problem.measured.origin}: columns x,y,z are wanted, guesses of the poses to start from")
    first = _fit_from(problem, straight, quick_fit(straight, rough)) if guessed else None
    if first is not None and first.cost < _FITS * _left_over(problem):
        return first
    again = _fit_from(problem, straight, best_fit(straight, seed, rough, progress))
    return again if first is None or again.cost <= first.cost else first


def _left_over(problem: Hanging) -> int:
    """How many measurements there are beyond unknowns, at least one."""
    return max(len(problem.values) - problem.poses * problem.own - len(problem.start), 1)


def _fit_from(problem: Hanging, straight: CalibrationProblem, found: PoseFit) -> PoseFit:
    theta, own = _let_go(problem, straight, found)
    plain = fit(problem, theta, poses_alone(problem, theta, own), settings=NEAR)
    return replace(plain, starts=found.starts, alike=found.alike)


def _straight(problem: Hanging) -> CalibrationPlan:
    """The plan for straight lines, as exact as those can be."""
    plan, robot = problem.plan, problem.robot
    min_tension = _SAGGING * robot.platform.mass * robot.scene.gravity
    exact = {"encoder": max(plan.sigma.encoder or 0.0, _SAG), "tension": max(plan.sigma.tension, min_tension)}
    kept = {
        "unknowns": tuple(name for name in plan.unknowns if name != "modulus"),
        "shared": tuple(name for name in plan.shared if name != "modulus"),
        "priors": tuple(prior for prior in plan.priors if prior.name != "modulus"),
        "sigma": plan.sigma.model_copy(update=exact),
    }
    return plan.model_copy(update=kept)


def _let_go(problem: Hanging, straight: CalibrationProblem, found: PoseFit) -> tuple[Array, Array]:
    """Unknowns and what is kept of each pose, in equilibrium where the straight lines were."""
    values = straight.whole(found.theta)
    known = dict(zip(straight.unknowns, values, strict=True))
    whole = np.array([known.get(*each) for each in zip(problem.unknowns, problem.start, strict=True)])
    sizes = np.array([each.size for each in straight.unknowns])
    held = _hung(
        problem, Model(with_values(problem.robot, straight.unknowns, values * sizes, raised=True)), found.poses
    )
    own = problem.kept(held)
    home = {each.line: at for at, each in enumerate(problem.unknowns) if each.name == "length_offset"}
    theta = whole[~problem.held]
    if home:
        off = problem.derivatives(theta, own).residual[:, : problem.robot.m] * problem.encoder_sigma
        for i, line in enumerate(problem.robot.lines):
            whole[home[line.name]] += np.median(off[:, i])
    return whole[~problem.held], own


def _hung(problem: Hanging, found: Model, poses: Array) -> Equilibrium:
    """Equilibria at *poses*, tensions near the measured ones. Raises `AnswerError` where there are none."""
    robot, measured = problem.robot, problem.measured
    tensions, limits = measured.tensions, None
    if tensions is not None:
        tensions = tensions.clip(min=1e-3 * robot.platform.mass * robot.scene.gravity)
        limits = float(tensions.min() / _WIDER), float(tensions.max() * _WIDER)
    given = poses.copy()
    if robot.m < robot.n:  # gravity decides the others, the yaw last of all
        given[:, FREED[robot.m :]] = np.nan
    model = Model(found.robot, problem.model.fidelity, limits)
    held = solve_inverse(model, given, preferred=tensions)
    lost = ~np.isfinite(held.lengths).all(axis=1) | ~np.isfinite(held.pose).all(axis=1)
    if lost.all():
        place = ", ".join(f"{x:.3g}" for x in poses[0, :3])
        where = f"{measured.origin}, {measured.place(0)}"
        raise AnswerError(f"not calibrated: {where}: the platform does not hang near ({place}): {held[0].sentence()}")
    good = np.flatnonzero(~lost)  # where it does not hang, the nearest pose where it does will do to start from
    apart = np.linalg.norm(poses[:, None, :3] - poses[good, :3], axis=2)
    return held[np.where(lost, good[np.argmin(apart, axis=1)], np.arange(len(poses)))]
