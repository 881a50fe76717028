"""Kinds of measurements: how well each fits for its sigma, and which rows carry something.

A row's leverage is the share of it that the fit takes as its own: rows of redundancy 1 - leverage test the fit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import SURVEY, CalibrationProblem
from cablewright.kernels.fitting import calibration_residuals as rows_of

NAMES: Final = {
    rows_of.ENCODER: "lengths",
    rows_of.PAID_OUT: "lengths",
    rows_of.TENSION: "tensions",
    rows_of.BALANCE: "tensions",
    rows_of.COORDINATE: "positions",
    rows_of.ALONG: "positions",
    rows_of.SWIVEL: "swivel angles",
    rows_of.TILT: "tilts",
    rows_of.YAW: "yaw angles",
    rows_of.PLANE: "planes",
    rows_of.REACH: "ranges",
}
"""What people call the kinds of rows that belong to poses."""

_CARRIES: Final = 1e-3  # min leverage of a measured coordinate: below, others know it 30 times better


@dataclass(frozen=True)
class KindFit:
    """How well one kind of measurement fits: rms residual over the told sigma, for its redundancy."""

    name: str
    ratio: float
    redundancy: float
    count: int


def kind_of(problem: CalibrationProblem) -> NDArray[np.str_]:
    """Return the name of the kind of each row (e,) of a pose."""
    return np.array([NAMES[int(code)] for code in problem.rows.kind[: problem.per_pose]])


def leverages(problem: CalibrationProblem, found: PoseFit) -> Array:
    """Return the leverage (N, e) of each row of the poses; 0 where it does not count, or has no value."""
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    rows = rows.blank(np.logical_not(rows.whole))
    covariance = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    left, values, _ = np.linalg.svd(rows.by_pose, full_matrices=False)
    kept = left * (values > 1e-9 * np.maximum(values.max(axis=1, initial=0.0, keepdims=True), 1e-300))[:, None]
    rest = rows.by_unknown - kept @ (np.swapaxes(kept, 1, 2) @ rows.by_unknown)
    own, shared = np.sum(kept**2, axis=2), np.einsum("nek,kl,nel->ne", rest, covariance, rest)
    return np.asarray((own + shared).clip(0.0, 1.0))


def kind_fits(problem: CalibrationProblem, found: PoseFit) -> tuple[KindFit, ...]:
    """Return how well each kind fits, at its full weight; rows left out do not count."""
    used, names = problem.of_poses(found.weights) > 0.0, kind_of(problem)
    residual = problem.derivatives(found.theta, found.poses).residual
    free = np.where(used, 1.0 - leverages(problem, found), 0.0)
    made = []
    for name in dict.fromkeys(names.tolist()):
        of = used & (names == name)
        total = float(free[of].sum())
        ratio = float(np.sqrt(np.sum(residual[of] ** 2) / total)) if total > 0.0 else np.nan
        made.append(KindFit(name, ratio * problem.factors.get(name, 1.0), total, int(of.sum())))
    return (*made, *_of_no_pose(problem, found))


def _of_no_pose(problem: CalibrationProblem, found: PoseFit) -> Iterator[KindFit]:
    """Yield how well what was measured of exit points fits: points, distances and their level."""
    measured = np.logical_not(problem.is_prior)
    if not measured.any():
        return
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    covariance = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    taken = np.einsum("gk,kl,gl->g", rows.others_by_unknown, covariance, rows.others_by_unknown)
    total = float((1.0 - taken[measured].clip(0.0, 1.0)).sum())
    if total > 0.0:
        ratio = float(np.sqrt(np.sum(rows.others[measured] ** 2) / total))
        yield KindFit(SURVEY, ratio * problem.factors.get(SURVEY, 1.0), total, int(measured.sum()))


def idle(problem: CalibrationProblem, found: PoseFit) -> Mask:
    """Return which rows (N, e) are measured coordinates so vague that all else knows them far better.

    None are if leaving them out would open a freedom.
    """
    vague = (kind_of(problem) == "positions") & (leverages(problem, found) < _CARRIES)
    vague &= problem.of_poses(problem.weights) > 0.0
    if vague.any():
        weights = found.weights.copy()
        problem.of_poses(weights)[vague] = 0.0
        before, after = (
            information(problem, found.theta, found.poses, each, priors=True) for each in (found.weights, weights)
        )
        if after.null.shape[1] > before.null.shape[1]:
            return np.zeros_like(vague)
    return np.asarray(vague)
