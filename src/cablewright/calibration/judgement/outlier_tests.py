"""Tests of poses against all others, such that noise alone seldom rejects any: F tests, with the level shared out.

A pose is tested by what its freedoms do not explain. A set of poses is the worst of all sets of its size, so its level
is divided by their number (Bonferroni): the false alarms of a whole file are at most `FALSE_ALARM`, to first order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cablewright.arrays import Array, Mask
from cablewright.calibration.poses.fit import PoseFit, fitted_poses
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import CalibrationProblem

FALSE_ALARM: Final = 0.003
"""Probability that a calibration without gross errors rejects anything."""

EXACT: Final = 1e-8  # m: smaller residuals are no gross errors, however small the others are


def floor_of(problem: CalibrationProblem) -> float:
    """Return the min sigma of a row over that of its weight, for data without noise."""
    return EXACT / problem.encoder_sigma


def counts(problem: CalibrationProblem) -> NDArray[np.int64]:
    """Return the number of rows of each pose (N,)."""
    return np.asarray((problem.of_poses(problem.weights) > 0.0).sum(axis=1))


@dataclass(frozen=True, eq=False)
class Unexplained:
    """What of each pose no change of it explains, at a fit of those that are not `out`, and what that fit determines.

    Each row is of sigma 1 or less: the weights are those of `weights.evened`.
    """

    off: Array  # (N, e)
    rows: Array  # (N, e, k)
    surplus: NDArray[np.int64]  # (N,)
    covariance: Array  # (k, k), of the unknowns by the poses that are not out
    out: Mask  # (N,)
    total: float  # sum of squares of the fit
    freedom: float  # the redundancy of its poses: their rows less what poses and unknowns take

    @classmethod
    def of(cls, problem: CalibrationProblem, found: PoseFit, out: Mask) -> Unexplained:
        """Return it at a fit *found*, whose weights leave something out of the poses *out*."""
        poses = found.poses
        if out.any():  # at the place that fits all its rows best, for the equations are linear only near it
            poses = np.where(out[:, None], fitted_poses(problem, found.theta, poses), poses)
        off, rows, ranks = projected(problem.derivatives(found.theta, poses))
        kept = problem.derivatives(found.theta, found.poses, found.weights)
        own, own_rows, own_ranks = projected(kept)
        by_unknown = np.concatenate([own_rows.reshape(-1, own_rows.shape[-1]), kept.others_by_unknown])
        covariance = np.linalg.pinv(by_unknown.T @ by_unknown, rcond=1e-13, hermitian=True)
        used = problem.of_poses(found.weights) > 0.0
        taken = float(np.einsum("nek,kl,nel->", own_rows, covariance, own_rows))
        freedom = max(float(used.sum() - own_ranks.sum()) - taken, 1.0)
        return cls(off, rows, counts(problem) - ranks, covariance, out, float(np.sum(own * own)), freedom)

    def rejected(self) -> Mask:
        """Return which poses (N,) an F test rejects, each against all others."""
        return np.asarray(self._single > math.log(len(self.off) / FALSE_ALARM))

    @cached_property
    def _single(self) -> Array:
        """How improbable each pose (N,) is: minus the logarithm of the probability of as much by noise."""
        return np.array([self._one(j) for j in range(len(self.off))])

    def _one(self, j: int) -> float:
        surplus, rest, rows = int(self.surplus[j]), self.off[j], self.rows[j]
        if surplus < 1:
            return 0.0
        if not np.isfinite(rest).all():
            return math.inf
        if self.out[j]:
            return self._improbable(self._predicted(np.array([j])), surplus, self.total, self.freedom)
        shared = np.eye(len(rest)) - rows @ self.covariance @ rows.T
        square = float(rest @ np.linalg.pinv(shared, rcond=1e-9, hermitian=True) @ rest)
        return self._improbable(square, surplus, max(self.total - square, 0.0), max(self.freedom - surplus, 1.0))

    def _predicted(self, poses: NDArray[np.int64]) -> float:
        """Return the sum of squares of poses that are out, over what the others predict of them together."""
        rest = self.off[poses].ravel()
        rows = self.rows[poses].reshape(len(rest), -1)
        return float(rest @ np.linalg.solve(np.eye(len(rest)) + rows @ self.covariance @ rows.T, rest))

    def _improbable(self, square: float, surplus: int, others: float, freedom: float) -> float:
        variance = max(others / freedom, 1.0)  # rows whose sigma is told too large would make it small
        with np.errstate(divide="ignore"):  # what is too improbable for a number is infinitely so
            return -float(np.log(special.fdtrc(surplus, freedom, square / (surplus * variance))))

    def mistaken(self) -> NDArray[np.int64]:
        """Return the poses that are out though noise may explain them, as the worst of all sets of as many."""
        places = np.flatnonzero(self.out & (self.surplus > 0))
        places = places[np.argsort(self._single[places], kind="stable")]
        whole = np.isfinite(self.off[places]).all(axis=1)
        mistaken = 0
        for size in range(1, int(whole.sum()) + 1):
            left = len(self.off) - len(places) + size  # the worse ones are out anyway
            level = math.log(FALSE_ALARM / (size * (size + 1))) - _log_binomial(left, size)
            least = places[whole][:size]
            square, surplus = self._predicted(least), int(self.surplus[least].sum())
            if self._improbable(square, surplus, self.total, self.freedom) < -level:
                mistaken = size
        return places[whole][:mistaken]


def _log_binomial(of: int, size: int) -> float:
    """Return the logarithm of the number of sets of a size."""
    return float(special.gammaln(of + 1) - special.gammaln(size + 1) - special.gammaln(of - size + 1))
