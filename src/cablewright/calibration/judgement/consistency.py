"""Consistency of calibration data: two halves of the rows, and the cable lengths against all other measurements.

Halves: the unknowns from one half of the rows, in their order, predict the other half, to first order about the answer,
so no half is fitted again. A slip or a drift between the halves shows; an equal error in both does not. Lengths alone:
how well they fit without any other row, and whether they do so together with the others. The encoders' sigma beside
other sensors is estimated, and would grow until everything fits: this test prevents that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import special

from cablewright.calibration.judgement.sigmas import idle, kind_fits, kind_of
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.fit import PoseFit, fit, framed
from cablewright.calibration.poses.observability import information, projected
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.foundation.arrays import Array, Mask

ENOUGH: Final = 5  # redundant lengths with which they test their sigma
_KINDS: Final = {"level": "the level", "priors": "the priors", "distances": "the distances"}
_SHORT: Final = 1e-6  # m: smaller sigmas count as equal
_FEW: Final = 5  # redundant rows of a half
_NULL: Final = 1e-9  # relative size of a singular value that counts as zero


@dataclass(frozen=True)
class HalfPrediction:
    """Distance of one half of the data from its prediction by the other, relative to noise, and its probability."""

    poses: tuple[int, int]  # first and last one predicted, from 0
    ratio: float
    probability: float


def predicted_halves(problem: CalibrationProblem, found: PoseFit) -> tuple[HalfPrediction, ...]:
    """Return how well each half of the data predicts the other, see `predicted`."""
    late = np.arange(problem.poses) >= problem.poses // 2
    return predicted(problem, found, (late, np.logical_not(late)))


def predicted(problem: CalibrationProblem, found: PoseFit, parts: Sequence[Mask]) -> tuple[HalfPrediction, ...]:
    """Return how well all other data predict each of several *parts*: masks (N,) of the poses.

    A part is left out if it or the rest has too little redundancy, or if the rest does not determine what all rows do.
    """
    if not np.isfinite(found.cost):
        return ()
    weights = found.weights.copy()
    problem.of_poses(weights)[idle(problem, found)] = 0.0  # they fit whatever is predicted
    rows = problem.derivatives(found.theta, found.poses, weights)
    off, reduced, ranks = projected(rows)
    surplus = (problem.of_poses(weights) > 0.0).sum(axis=1) - ranks
    floor = problem.floor**2
    shared = rows.others_by_unknown, rows.others
    made = []
    every = np.linalg.svd(np.concatenate([reduced.reshape(-1, reduced.shape[-1]), shared[0]]), compute_uv=False)
    rank = int((every > _NULL * every.max(initial=1e-300)).sum())
    for other in parts:
        basis, moved, square, redundancy = _own(off, reduced, surplus, np.logical_not(other), shared)
        count = int(surplus[other].sum())
        if basis.shape[1] < rank or redundancy < _FEW or count < _FEW:
            continue
        jacobian = reduced[other].reshape(-1, reduced.shape[-1])
        rest = off[other].ravel() + jacobian @ moved
        known = jacobian @ basis  # of sigma 1 each
        inner = np.linalg.solve(np.eye(known.shape[1]) + known.T @ known, known.T @ rest)
        total = max(float(rest @ rest - (known.T @ rest) @ inner), 0.0)  # Woodbury
        ratio = (total / count) / max(square / redundancy, floor)
        places = np.flatnonzero(other)
        probability = float(special.fdtrc(count, redundancy, ratio))
        made.append(HalfPrediction((int(places[0]), int(places[-1])), float(np.sqrt(ratio)), probability))
    return tuple(made)


def _own(
    off: Array, reduced: Array, surplus: Array, half: Mask, shared: tuple[Array, Array]
) -> tuple[Array, Array, float, int]:
    """Return of a fit to one *half*: the unknowns' combinations of sigma 1 (k, r), their change (k,), and its squares.

    The last is its redundancy. *shared*: rows without a pose, and their residuals.
    """
    rows = np.concatenate([reduced[half].reshape(-1, reduced.shape[-1]), shared[0]])
    rest = np.append(off[half].ravel(), shared[1])
    left, values, right = np.linalg.svd(rows, full_matrices=False)
    kept = values > _NULL * values.max(initial=1e-300)
    basis = right[kept].T / values[kept]
    moved = -basis @ (left[:, kept].T @ rest)
    square = float(np.sum((rest + rows @ moved) ** 2))
    return basis, moved, square, int(surplus[half].sum()) + len(shared[1]) - int(kept.sum())


@dataclass(frozen=True)
class Together:
    """Standard deviation of the encoders, m, from the lengths alone and together with the other measurements."""

    alone: float
    joint: float
    growth: float  # of the residuals per redundant number that the other rows add, over what noise explains
    probability: float  # that noise makes them grow as much (F test)

    @property
    def ratio(self) -> float:
        """Ratio of the encoders' sigma with all measurements to that from the lengths alone."""
        return self.joint / self.alone


def others_of(problem: CalibrationProblem) -> str:
    """Return the kinds of measurements other than cable lengths, in words."""
    names = ["the surveyed points"] * bool(problem.plan.points)
    names += [words for key, words in _KINDS.items() if getattr(problem.plan, key)]
    names += [f"the {name}" for name in dict.fromkeys(kind_of(problem).tolist()) if name != "lengths"]
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def together(problem: CalibrationProblem, found: PoseFit) -> Together | None:
    """Compare the lengths alone, from the solution *found* on, with the joint fit; None if they do not test it."""
    if problem.elastic:
        return None
    plan = CalibrationPlan(
        unknowns=problem.plan.unknowns,
        shared=problem.plan.shared,
        groups=problem.plan.groups,
        known=problem.plan.known,
        across=problem.plan.across,
        sigma=problem.plan.sigma,
    )
    free: CalibrationProblem = StraightProblem.of(problem.robot, problem.measured.lengths_alone(), plan, hold=False)
    used = problem.of_poses(found.weights)[:, : problem.lengths_per_pose] > 0.0
    weights = np.where(used, free.of_poses(free.weights) * (free.encoder_sigma / problem.encoder_sigma), 0.0).ravel()
    there = [problem.unknowns.index(each) for each in free.unknowns]  # others have no effect on lengths
    theta = problem.whole(found.theta)[there]
    # bounds may exclude the file where a prior has a value
    limits = np.ascontiguousarray(problem.without_datum().limits[:, there])
    free = replace(free, weights=weights, found_encoder=problem.encoder_sigma, limits=limits)
    free = framed(free, theta, found.poses)
    own = fit(free, theta, found.poses)
    left = information(free, own.theta, own.poses, weights, priors=True).redundancy
    if left < ENOUGH or not math.isfinite(own.cost):
        return None
    square = 2.0 * own.cost
    joint = kind_fits(problem, found)[0]
    floor = _SHORT / problem.encoder_sigma
    alone = max(math.sqrt(square / left), floor)
    more = max(joint.redundancy - left, 1.0)
    growth = max(joint.ratio**2 * joint.redundancy - square, 0.0) / (more * alone**2)
    probability = float(special.fdtrc(more, left, growth))
    sigma = problem.encoder_sigma
    return Together(alone * sigma, max(joint.ratio, floor) * sigma, math.sqrt(growth), probability)
