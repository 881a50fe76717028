"""Lengths alone: how well they fit without any other row, and whether they do so together with the others.

The encoders' sigma beside other sensors is estimated, and would grow until everything fits: this is what tests it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import stats

from cablewright.calibration.kinds import kind_fits, kind_of
from cablewright.calibration.observability import information
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.pose_fit import PoseFit, fit, framed
from cablewright.calibration.problem import CalibrationProblem

ENOUGH: Final = 5  # redundant lengths with which they test their sigma
_EXACT: Final = 1e-6  # m: smaller sigmas are alike
_KINDS: Final = {"level": "the level", "priors": "the priors", "distances": "the distances"}


@dataclass(frozen=True)
class Together:
    """Sigma of the encoders, m, from the lengths alone and together with the other rows."""

    alone: float
    joint: float
    growth: float  # of the residuals per redundant number that the other rows add, over what noise explains
    probability: float  # that noise makes them grow so much (F test)

    @property
    def ratio(self) -> float:
        """By how much the sigma grows."""
        return self.joint / self.alone


def others_of(problem: CalibrationProblem) -> str:
    """Return what there is besides lengths, in words."""
    names = ["the surveyed points"] * bool(problem.plan.points)
    names += [words for key, words in _KINDS.items() if getattr(problem.plan, key)]
    names += [f"the {name}" for name in dict.fromkeys(kind_of(problem).tolist()) if name != "lengths"]
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def together(problem: CalibrationProblem, found: PoseFit) -> Together | None:
    """Compare the lengths alone, from the solution *found* on, with the joint fit; None if they do not test it."""
    if problem.elastic:
        return None
    measured = replace(problem.measured, pose_sigma=None, tensions=None, swivel=None, tilt=None)
    plan = CalibrationPlan(
        unknowns=problem.plan.unknowns, shared=problem.plan.shared, bounds=problem.plan.bounds, sigma=problem.plan.sigma
    )
    free = CalibrationProblem.of(problem.robot, measured, plan, hold=False)
    m = problem.robot.m
    weights = np.where(problem.of_poses(found.weights)[:, :m] > 0.0, 1.0 / problem.encoder_sigma, 0.0).ravel()
    free = replace(free, weights=weights, found_encoder=problem.encoder_sigma)
    free = framed(free, problem.whole(found.theta), found.poses)
    own = fit(free, problem.whole(found.theta), found.poses)
    left = information(free, own.theta, own.poses, weights).redundancy
    if left < ENOUGH or not math.isfinite(own.cost):
        return None
    square = 2.0 * own.cost
    joint = kind_fits(problem, found)[0]
    floor = _EXACT / problem.encoder_sigma
    alone = max(math.sqrt(square / left), floor)
    more = max(joint.redundancy - left, 1.0)
    growth = max(joint.ratio**2 * joint.redundancy - square, 0.0) / (more * alone**2)
    probability = float(stats.f.sf(growth, more, left))
    sigma = problem.encoder_sigma
    return Together(alone * sigma, max(joint.ratio, floor) * sigma, math.sqrt(growth), probability)
