"""Gross errors: found after a plain fit by re-weighting, then tested one by one against all other poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cablewright.arrays import Array, Mask
from cablewright.calibration.checks import gauge_size
from cablewright.calibration.observability import projected
from cablewright.calibration.pose_fit import QUICK, PoseFit, fit, fitted_poses
from cablewright.calibration.problem import CalibrationProblem
from cablewright.progress import Progress, silent

_FALSE_ALARM: Final = 0.003
"""Probability that a calibration without gross errors rejects anything."""

_ROUNDS: Final = 12  # of re-weighting
_SETTLING: Final = 12  # max rounds of testing
_EXACT: Final = 1e-8  # m: smaller residuals are no gross errors, however small the others are
_PARTS: Final = (40, 12)  # random parts of the poses, with few redundant poses and with many
_CONCENTRATIONS: Final = 4
_MANY: Final = 3  # times the poses of a part: with more, re-weighting seldom fails
_KEPT: Final = 75  # percent of the poses, the best ones, by whose residuals parts are compared
_LEFT_OVER: Final = 5  # redundant measurements in a part
_TOO_MANY: Final = 0.4  # share of rejected poses beyond which the model is wrong, not the data


@dataclass(frozen=True)
class Rejected:
    """A pose (counted from 0) left out, or one `sensor` of a `line` if the others single it out; `size`: its error.

    `sensor`: "encoder" (m) or, with elastic lines, "tension" (N); None for a whole pose.
    """

    pose: int
    line: str | None
    size: float
    sensor: str | None = "encoder"

    @property
    def unit(self) -> str:
        """Of the size: m or N."""
        return "N" if self.sensor == "tension" else "m"


def without_outliers(
    problem: CalibrationProblem, plain: PoseFit, start: PoseFit, seed: int, progress: Progress = silent
) -> tuple[PoseFit, tuple[Rejected, ...]]:
    """Fit again without gross errors. *plain*: a fit of all rows; *start*: a start for fits of parts of them.

    The surplus of a pose, its rows less its freedoms, limits what can be found: with 1, that the pose has an error;
    with more, in which line.
    """
    robust = _best_of_parts(problem, _reweighted(problem, plain), start, seed, progress)
    squares, surplus = _unexplained(problem, robust, robust.weights)
    spread = max(_spread(squares, surplus), _floor(problem))
    bad = squares > spread**2 * stats.chi2.isf(_FALSE_ALARM / len(squares), np.maximum(surplus, 1))
    found, rows = robust, np.zeros((problem.poses, problem.per_pose), dtype=bool)
    for _ in range(_SETTLING):
        if bad.mean() > _TOO_MANY:
            return plain, ()
        squares, surplus = _unexplained(problem, found, found.weights)
        rows = _rows_of(problem, found, bad, max(_spread(squares[~bad], surplus[~bad]), _floor(problem)))
        weights = _weights_without(problem, rows)
        again = fit(problem, found.theta, found.poses, weights)
        found = replace(plain, theta=again.theta, poses=again.poses, weights=weights, cost=again.cost, code=again.code)
        rejected = _tested(problem, found, plain.weights, bad)
        if np.array_equal(rejected, bad):
            break
        bad = rejected
    if not rows.any():  # all rows count in both fits: return the better one
        return (found if found.cost < plain.cost else plain), ()
    return found, tuple(_rejected(problem, found, rows))


def _unexplained(problem: CalibrationProblem, found: PoseFit, weights: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return the sum of squares (N,) of each pose that no change of the pose explains, and its surplus of rows (N,)."""
    off, _, ranks = projected(problem.derivatives(found.theta, found.poses, weights))
    return np.sum(off * off, axis=1), _counts(problem) - ranks


def _weights_without(problem: CalibrationProblem, rows: Mask) -> Array:
    """Return the weights (R,) with those of *rows* (N, e), or of whole poses (N,), set to 0."""
    weights = problem.weights.copy()
    problem.of_poses(weights)[rows] = 0.0
    return weights


def _counts(problem: CalibrationProblem) -> NDArray[np.int64]:
    """Return the number of rows of each pose (N,)."""
    return np.asarray((problem.of_poses(problem.weights) > 0.0).sum(axis=1))


def _spread(squares: Array, surplus: NDArray[np.int64]) -> float:
    """Return the sigma of a row over that of its weight, from the median over poses: a few outliers cannot move it."""
    freedom = max(int(np.median(surplus)), 1)
    return float(np.sqrt(np.median(squares) / stats.chi2.median(freedom)))


def _floor(problem: CalibrationProblem) -> float:
    """Return the min of `_spread`, for data without noise."""
    return _EXACT / problem.encoder_sigma


def _reweighted(problem: CalibrationProblem, plain: PoseFit) -> PoseFit:
    """Return the fit with poses re-weighted by 1 / |unexplained residuals|: a few bad ones hardly count."""
    found = plain
    for _ in range(_ROUNDS):
        squares, surplus = _unexplained(problem, found, plain.weights)
        size = np.sqrt(squares)
        smallest = max(0.3 * _spread(squares, surplus), _floor(problem))
        weights = plain.weights.copy()
        problem.of_poses(weights)[:] *= np.sqrt(smallest / np.maximum(size, smallest))[:, None]
        found = fit(problem, found.theta, found.poses, weights)
    return replace(found, weights=plain.weights)


def _best_of_parts(
    problem: CalibrationProblem, reweighted: PoseFit, start: PoseFit, seed: int, progress: Progress
) -> PoseFit:
    """Return the fit whose best poses have the smallest residuals, of *reweighted* and fits of random parts of poses.

    Least trimmed squares (Rousseeuw, Van Driessen 2006): with few redundant poses, gross errors move a plain fit so far
    that no re-weighting brings it back, while a part of the poses without them has the right answer.
    """
    count, surplus = problem.poses, int(_counts(problem).min()) - problem.unknowns_per_pose
    decided = len(reweighted.theta) - gauge_size(problem)
    smallest = -(-(decided + _LEFT_OVER) // surplus)
    kept = max(-(-_KEPT * count // 100), smallest)
    if kept >= count:
        return reweighted
    rng = np.random.default_rng(seed)
    best, size = reweighted, _trimmed(problem, reweighted, kept)[0]
    parts = _PARTS[kept > _MANY * smallest]
    for part in range(parts):
        progress("gross errors, parts of the poses", part, parts)
        found = (start, reweighted)[part % 2]
        chosen = rng.choice(count, min(smallest, kept), replace=False)
        trimmed = np.inf
        for _ in range(_CONCENTRATIONS):
            weights = _weights_without(problem, ~np.isin(np.arange(count), chosen))
            found = fit(problem, found.theta, found.poses, weights, settings=QUICK)
            if not np.isfinite(found.cost):
                break
            found = replace(found, poses=fitted_poses(problem, found.theta, found.poses))
            trimmed, order = _trimmed(problem, found, kept)
            chosen = order[:kept]
        if trimmed < size:
            best, size = replace(reweighted, theta=found.theta, poses=found.poses), trimmed
    return best


def _trimmed(problem: CalibrationProblem, found: PoseFit, kept: int) -> tuple[float, NDArray[np.int64]]:
    """Return the unexplained sum of squares of the *kept* best poses, and all poses in order of theirs."""
    if not problem.is_finite(found.theta, found.poses):  # a pose of weight 0 is inside a sheave
        return np.inf, np.arange(problem.poses)
    squares, _ = _unexplained(problem, found, problem.weights)
    order = np.argsort(squares)
    return float(squares[order[:kept]].sum()), order


def _tested(problem: CalibrationProblem, found: PoseFit, weights: Array, bad: Mask) -> Mask:
    """Return which poses (N,) an F test rejects, each against all others, at a level shared by all poses."""
    off, reduced, ranks = projected(problem.derivatives(found.theta, found.poses, weights))
    kept = problem.derivatives(found.theta, found.poses, found.weights)
    own, own_reduced, own_ranks = projected(kept)
    by_unknown = np.concatenate([own_reduced.reshape(-1, own_reduced.shape[-1]), kept.others_by_unknown])
    covariance = np.linalg.pinv(by_unknown.T @ by_unknown, rcond=1e-13, hermitian=True)
    k = np.linalg.matrix_rank(covariance, tol=1e-13 * np.abs(covariance).max(), hermitian=True)
    used = problem.of_poses(found.weights) > 0.0
    freedom = max(int(used.sum() - own_ranks.sum() - k), 1)
    total = max(float(np.sum(own * own)), freedom * _floor(problem) ** 2)
    rejected, counts = np.zeros(len(off), dtype=bool), _counts(problem)
    for j, (rest, rows) in enumerate(zip(off, reduced, strict=True)):
        surplus = int(counts[j] - ranks[j])
        if surplus < 1:
            continue
        shared = rows @ covariance @ rows.T
        if bad[j]:
            square, others, left = rest @ np.linalg.solve(np.eye(len(rest)) + shared, rest), total, freedom
        else:
            square = rest @ np.linalg.pinv(np.eye(len(rest)) - shared, rcond=1e-9, hermitian=True) @ rest
            others, left = max(total - square, 0.0), max(freedom - surplus, 1)
        variance = max(others / left, _floor(problem) ** 2)
        rejected[j] = square / (surplus * variance) > stats.f.isf(_FALSE_ALARM / len(off), surplus, left)
    return rejected


def _rows_of(problem: CalibrationProblem, found: PoseFit, bad: Mask, spread: float) -> Mask:
    """Return the rows (N, e) to leave out: the one row of a line that explains a bad pose, else all of the pose."""
    weights = problem.of_poses(problem.weights)
    rows = np.zeros(weights.shape, dtype=bool)
    derivatives = problem.derivatives(found.theta, found.poses)
    _, _, ranks = projected(derivatives)
    left, _, _ = np.linalg.svd(derivatives.by_pose, full_matrices=True)
    named, counts = _rows_of_lines(problem), _counts(problem)
    for j in np.flatnonzero(bad):
        surplus = int(counts[j] - ranks[j])
        if surplus < 2:
            rows[j] = True
            continue
        free = left[j][:, ranks[j] :]
        rest = free.T @ derivatives.residual[j]
        explained = (free[:named] @ rest) ** 2 / np.maximum(np.sum(free[:named] ** 2, axis=1), 1e-12)
        remains = (rest @ rest - explained) / ((surplus - 1) * spread**2)
        order = np.argsort(remains)
        limit = stats.chi2.isf(_FALSE_ALARM / len(bad), surplus - 1) / (surplus - 1)
        if remains[order[0]] < 3.0 * limit and remains[order[1]] > limit:
            rows[j, order[0]] = True
        else:
            rows[j] = True
    return rows


def _rows_of_lines(problem: CalibrationProblem) -> int:
    """Return how many rows of a pose are of one line each: its encoder and, with elastic lines, its tension."""
    return problem.robot.m * (2 if problem.elastic and problem.measured.tensions is not None else 1)


def _rejected(problem: CalibrationProblem, found: PoseFit, rows: Mask) -> Iterator[Rejected]:
    """Yield what the *rows* (N, e) left out are of, and their errors."""
    derivatives = problem.derivatives(found.theta, found.poses)
    m, sigma = problem.robot.m, problem.encoder_sigma
    off, _, _ = projected(derivatives)
    for j in np.flatnonzero(rows.any(axis=1)):
        if rows[j].all():
            yield Rejected(int(j), None, float(np.linalg.norm(off[j])) * sigma, None)
            continue
        i = int(np.flatnonzero(rows[j])[0])
        size, sensor = (sigma, "encoder") if i < m else (problem.plan.sigma.tension, "tension")
        yield Rejected(int(j), problem.robot.lines[i % m].name, abs(float(derivatives.residual[j, i])) * size, sensor)
