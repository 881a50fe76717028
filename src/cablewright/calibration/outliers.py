"""Gross errors: found after a plain fit by re-weighting, then judged one by one against what the others predict."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cablewright.arrays import Array, Mask
from cablewright.calibration.checks import gauge_size
from cablewright.calibration.observability import projected
from cablewright.calibration.pose_fit import QUICK, PoseFit, fit, poses_alone
from cablewright.calibration.problem import CalibrationProblem
from cablewright.progress import Progress, silent

_FALSE_ALARM: Final = 0.003
"""How often a calibration without gross errors may reject anything."""

_ROUNDS: Final = 12  # of re-weighting
_SETTLING: Final = 12  # of judging
_EXACT: Final = 1e-8  # m: what fits better than this is no gross error, whatever the others do
_PARTS: Final = (40, 12)  # where few poses are left over, and where many are
_CONCENTRATIONS: Final = 4
_MANY: Final = 3  # times the poses a part needs: from here on re-weighting seldom fails
_KEPT: Final = 75  # percent of the poses by whose fit parts are compared
_LEFT_OVER: Final = 5  # measurements beyond those that decide, in a part
_TOO_MANY: Final = 0.4  # share of poses beyond which it is the model that does not fit


@dataclass(frozen=True)
class Rejected:
    """A pose (counted from 0) left out, or one line of it where the others tell which; `size`: how far off it is.

    `sensor` is the line's that is off: "encoder" (m), or "tension" (N) where tensions stand by themselves.
    """

    pose: int
    line: str | None
    size: float
    sensor: str | None = "encoder"

    @property
    def unit(self) -> str:
        """Of the size, SI."""
        return "N" if self.sensor == "tension" else "m"


def without_outliers(
    problem: CalibrationProblem, plain: PoseFit, start: PoseFit, seed: int, progress: Progress = silent
) -> tuple[PoseFit, tuple[Rejected, ...]]:
    """Fit again without gross errors. *plain* is a fit of all rows, *start* where fits of a part of them may begin.

    A pose says of its own error no more than its surplus of rows: with one row more than freedoms, that something is
    wrong; with more, which line it is.
    """
    shape, counts = problem.of_poses(plain.weights).shape, _counts(problem)
    robust = _best_of_parts(problem, _reweighted(problem, plain), start, seed, progress)
    off, ranks, _, _ = _surplus(problem, robust)
    spread = max(_spread(off, counts - ranks), _floor(problem))
    limit = stats.chi2.isf(_FALSE_ALARM / len(off), np.maximum(counts - ranks, 1))
    bad = np.sum(off * off, axis=1) > limit * spread**2
    found, rows = robust, np.zeros(shape, dtype=bool)
    for _ in range(_SETTLING):
        if bad.mean() > _TOO_MANY:
            return plain, ()
        rows = _rows_of(problem, found, bad, _spread_of(problem, found, bad))
        weights = plain.weights.copy()
        problem.of_poses(weights)[rows] = 0.0
        again = fit(problem, found.theta, found.poses, weights)
        found = replace(plain, theta=again.theta, poses=again.poses, weights=weights, cost=again.cost, code=again.code)
        judged = _judged(problem, found, plain.weights, bad)
        if np.array_equal(judged, bad):
            break
        bad = judged
    if not rows.any():  # the same rows as before: the better of two fits of them
        return (found if found.cost < plain.cost else plain), ()
    return found, tuple(_told(problem, found, rows))


def _surplus(
    problem: CalibrationProblem, found: PoseFit, weights: Array | None = None
) -> tuple[Array, NDArray[np.int64], Array, Array]:
    """What poses leave unexplained: (N, r), their ranks, derivatives (N, r, k), and the covariance (k, k)."""
    used = found.weights if weights is None else weights
    off, reduced, ranks = projected(problem.derivatives(found.theta, found.poses, used))
    inner = problem.derivatives(found.theta, found.poses, found.weights)
    _, own, _ = projected(inner)
    rows = np.concatenate([own.reshape(-1, own.shape[-1]), inner.others_by_unknown])
    covariance = np.linalg.pinv(rows.T @ rows, rcond=1e-13, hermitian=True)
    return off, ranks, reduced, covariance


def _counts(problem: CalibrationProblem) -> NDArray[np.int64]:
    """How many rows each pose has (N,)."""
    return np.asarray((problem.of_poses(problem.weights) > 0.0).sum(axis=1))


def _spread(off: Array, surplus: NDArray[np.int64]) -> float:
    """Standard deviation of a row over that of its weight, from the middle of all poses: few of them cannot move it."""
    freedom = max(int(np.median(surplus)), 1)
    return float(np.sqrt(np.median(np.sum(off * off, axis=1)) / stats.chi2.median(freedom)))


def _floor(problem: CalibrationProblem) -> float:
    """The same of what is as good as exact."""
    return _EXACT / problem.encoder_sigma


def _reweighted(problem: CalibrationProblem, plain: PoseFit) -> PoseFit:
    """Re-weight poses by 1 / |what they leave unexplained|, until a few bad ones count for next to nothing."""
    found = plain
    for _ in range(_ROUNDS):
        off, ranks, _, _ = _surplus(problem, found, plain.weights)
        size = np.sqrt(np.sum(off * off, axis=1))
        smallest = max(0.3 * _spread(off, _counts(problem) - ranks), _floor(problem))
        weights = plain.weights.copy()
        problem.of_poses(weights)[:] *= np.sqrt(smallest / np.maximum(size, smallest))[:, None]
        found = fit(problem, found.theta, found.poses, weights)
    return replace(found, weights=plain.weights)


def _best_of_parts(
    problem: CalibrationProblem, reweighted: PoseFit, start: PoseFit, seed: int, progress: Progress
) -> PoseFit:
    """The fit whose better poses fit best, of *reweighted* and of fits of random parts of the poses.

    Least trimmed squares (Rousseeuw, Van Driessen 2006): where few poses are left over, gross errors draw a plain fit
    so far that no weights bring it back, while a part without them has the right answer.
    """
    count, surplus = problem.poses, int(_counts(problem).min()) - problem.own
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
            weights = reweighted.weights.copy()
            left_out = np.ones(count, dtype=bool)
            left_out[chosen] = False
            problem.of_poses(weights)[left_out] = 0.0
            found = fit(problem, found.theta, found.poses, weights, settings=QUICK)
            if not np.isfinite(found.cost):
                break
            found = replace(found, poses=poses_alone(problem, found.theta, found.poses))
            trimmed, order = _trimmed(problem, found, kept)
            chosen = order[:kept]
        if trimmed < size:
            best, size = replace(reweighted, theta=found.theta, poses=found.poses), trimmed
    return best


def _trimmed(problem: CalibrationProblem, found: PoseFit, kept: int) -> tuple[float, NDArray[np.int64]]:
    """Sum of squares that the *kept* best poses leave unexplained, and poses in the order of theirs."""
    if not problem.reaches(found.theta, found.poses):  # a pose that does not count is in a sheave
        return np.inf, np.arange(problem.poses)
    off, _, _ = projected(problem.derivatives(found.theta, found.poses))
    sizes = np.sum(off * off, axis=1)
    order = np.argsort(sizes)
    return float(sizes[order[:kept]].sum()), order


def _spread_of(problem: CalibrationProblem, found: PoseFit, bad: Mask) -> float:
    off, ranks, _, _ = _surplus(problem, found)
    return max(_spread(off[~bad], (_counts(problem) - ranks)[~bad]), _floor(problem))


def _judged(problem: CalibrationProblem, found: PoseFit, weights: Array, bad: Mask) -> Mask:
    """Which poses are off by more than chance: each against what all others say (an F test, shared over all poses)."""
    off, ranks, reduced, covariance = _surplus(problem, found, weights)
    own, own_ranks, _, _ = _surplus(problem, found)
    k = np.linalg.matrix_rank(covariance, tol=1e-13 * np.abs(covariance).max(), hermitian=True)
    used = problem.of_poses(found.weights) > 0.0
    freedom = max(int(used.sum() - own_ranks.sum() - k), 1)
    total = max(float(np.sum(own * own)), freedom * _floor(problem) ** 2)
    judged, counts = np.zeros(len(off), dtype=bool), _counts(problem)
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
        judged[j] = square / (surplus * variance) > stats.f.isf(_FALSE_ALARM / len(off), surplus, left)
    return judged


def _rows_of(problem: CalibrationProblem, found: PoseFit, bad: Mask, spread: float) -> Mask:
    """Which rows (N, e) to leave out: that of the one line whose removal explains a bad pose, else all of the pose."""
    weights = problem.of_poses(problem.weights)
    rows = np.zeros(weights.shape, dtype=bool)
    derivatives = problem.derivatives(found.theta, found.poses)
    _, _, ranks = projected(derivatives)
    left, _, _ = np.linalg.svd(derivatives.by_pose, full_matrices=True)
    named, counts = _named(problem), _counts(problem)
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


def _named(problem: CalibrationProblem) -> int:
    """How many of a pose's rows are of one line each: its encoder's, and its tension's where lines hang."""
    return problem.robot.m * (2 if problem.hangs and problem.measured.tensions is not None else 1)


def _told(problem: CalibrationProblem, found: PoseFit, rows: Mask) -> list[Rejected]:
    """Name what is left out."""
    everything = problem.weights.copy()
    residual = problem.derivatives(found.theta, found.poses, everything).residual
    told = []
    m, sigma = problem.robot.m, problem.encoder_sigma
    off, _, _ = projected(problem.derivatives(found.theta, found.poses, everything))
    for j in np.flatnonzero(rows.any(axis=1)):
        if rows[j].all():
            told.append(Rejected(int(j), None, float(np.linalg.norm(off[j])) * sigma, None))
            continue
        i = int(np.flatnonzero(rows[j, : _named(problem)])[0])
        size, sensor = (sigma, "encoder") if i < m else (problem.plan.sigma.tension, "tension")
        told.append(Rejected(int(j), problem.robot.lines[i % m].name, abs(float(residual[j, i])) * size, sensor))
    return told
